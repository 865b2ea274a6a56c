#include "lumesh/image/grey_values.hpp"

#include <algorithm>
#include <cmath>

#include "lumesh/parallel/sum.hpp"

namespace lumesh {
namespace {

constexpr std::size_t kValuesPerBlock = std::size_t{1} << 18;

GreyValues sum(GreyValues a, const GreyValues& b) {
  a.least = std::min(a.least, b.least);
  a.most = std::max(a.most, b.most);
  a.count += b.count;
  for (std::size_t i = 0; i < GreyValues::kBins; ++i) a.bins[i] += b.bins[i];
  return a;
}

/// Calls visit(result, value) for all finite values, and adds up the results of blocks.
template <class Value, class Visit>
GreyValues visit_finite(std::span<const Value> values, const Visit& visit) {
  return parallel::reduce(
      values.size(), kValuesPerBlock, GreyValues{},
      [&](GreyValues& result, std::size_t i) {
        if (const auto value = static_cast<double>(values[i]); std::isfinite(value)) visit(result, value);
      },
      sum);
}

template <class Value>
GreyValues grey_values_of(std::span<const Value> values) {
  const GreyValues range = visit_finite(values, [](GreyValues& result, double value) {
    result.least = std::min(result.least, value);
    result.most = std::max(result.most, value);
    ++result.count;
  });
  const double per_bin_wanted =
      range.most > range.least ? static_cast<double>(GreyValues::kBins) / (range.most - range.least) : 0;
  const double per_bin = std::isfinite(per_bin_wanted) ? per_bin_wanted : 0;
  GreyValues result = visit_finite(values, [&](GreyValues& block, double value) {
    ++block.bins[std::min(GreyValues::kBins - 1, static_cast<std::size_t>((value - range.least) * per_bin))];
  });
  result.least = range.least;
  result.most = range.most;
  result.count = range.count;
  return result;
}

}  // namespace

double GreyValues::otsu_threshold() const {
  double all = 0;
  for (std::size_t i = 0; i < kBins; ++i) all += static_cast<double>(i) * static_cast<double>(bins[i]);
  double below = 0, moment = 0, best = -1;
  std::size_t first = 0, last = 0;  // Between groups far apart all are equally good.
  for (std::size_t i = 0; i + 1 < kBins; ++i) {
    below += static_cast<double>(bins[i]);
    moment += static_cast<double>(i) * static_cast<double>(bins[i]);
    const double above = static_cast<double>(count) - below;
    if (below == 0 || above == 0) continue;
    const double apart = moment / below - (all - moment) / above;
    const double between = below * above * apart * apart;  // The variance between the groups, scaled.
    if (between > best) best = between, first = i + 1;
    if (between == best) last = i + 1;
  }
  return least + 0.5 * static_cast<double>(first + last) * bin_width();
}

double GreyValues::share_from(double value) const {
  if (count == 0) return 0;
  std::size_t from = 0;
  for (std::size_t i = 0; i < kBins; ++i)
    if (least + (static_cast<double>(i) + 0.5) * bin_width() >= value) from += bins[i];
  return static_cast<double>(from) / static_cast<double>(count);
}

GreyValues grey_values(const VoxelValues& values) {
  return std::visit([](const auto& typed) { return grey_values_of(typed); }, values);
}

}  // namespace lumesh
