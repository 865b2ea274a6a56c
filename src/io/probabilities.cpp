// Values besides labels: what they may be, and that they are of the same grid.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "file_fault.hpp"
#include "lumesh/image/crossings.hpp"
#include "lumesh/parallel/sum.hpp"
#include "raw_image.hpp"

namespace lumesh::io {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kValuesPerBlock = std::size_t{1} << 18;
constexpr double kProbabilityRounding = 1e-3;  // sums of a network's outputs and resampling leave as much
constexpr double kSameGrid = 0.01;             // voxels; headers round spacings and directions
constexpr double kMaxAgainst = 20;             // per cent of the faces

struct ValueRange {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  bool fractional = false;

  [[nodiscard]] bool is_of_probabilities() const {
    return least >= -kProbabilityRounding && most <= 1 + kProbabilityRounding;
  }
};

template <class Value>
ValueRange range_of(std::span<const Value> values) {
  return parallel::reduce(
      values.size(), kValuesPerBlock, ValueRange{},
      [&](ValueRange& range, std::size_t i) {
        const auto value = static_cast<double>(values[i]);
        range.fractional |= std::trunc(value) != value && !std::isnan(value);
        range.least = value < range.least ? value : range.least;
        range.most = value > range.most ? value : range.most;
      },
      [](const ValueRange& a, const ValueRange& b) {
        return ValueRange{std::min(a.least, b.least), std::max(a.most, b.most), a.fractional || b.fractional};
      });
}

}  // namespace

void require_same_grid(const ImageFrame& frame, const ImageFrame& wanted, const fs::path& path) {
  if (frame.size != wanted.size)
    fail(path, fmt::format("has {} x {} x {} voxels, but the image {} x {} x {}; it has to be on "
                           "the image's grid: resample it",
                           frame.size.x(), frame.size.y(), frame.size.z(), wanted.size.x(), wanted.size.y(),
                           wanted.size.z()));
  double furthest = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const Vec3 at = (wanted.size - Index3::Ones())
                        .cwiseProduct(Index3(corner & 1U, corner >> 1U & 1U, corner >> 2U))
                        .cast<double>();
    furthest = std::max(furthest, (wanted.to_index(frame.to_physical(at)) - at).cwiseAbs().maxCoeff());
  }
  if (!(furthest <= kSameGrid))
    fail(path, fmt::format("lies up to {:.2g} voxels off the image (spacing, origin or directions differ); "
                           "it has to be on the image's grid: resample it",
                           furthest));
}

namespace {

void check_values(const ValueRange& range, const fs::path& path) {
  if (!range.is_of_probabilities())
    fail(path,
         fmt::format("has values from {:g} to {:g}; probabilities are from 0 to 1: scale them{}", range.least,
                     range.most, range.least < 0 ? " (logits by the logistic function)" : ""));
}

void warn_of_doubts(const CrossingCounts& counts, const fs::path& path, const Context& context) {
  const double against = 100.0 * static_cast<double>(counts.against) /
                         static_cast<double>(std::max<std::size_t>(1, counts.faces));
  if (counts.values_are_labels)
    context.warn(path.string() +
                 ": has no values between 0 and 1 at the boundary, so it says no more than the labels");
  else if (against > kMaxAgainst)
    context.warn(
        fmt::format("{}: is on the wrong side of 0.5 at {:.0f} % of the object's voxel faces, which the "
                    "labels alone place; is it of this image, and of the object?",
                    path.string(), against));
}

}  // namespace

bool are_probabilities(const RawImage& raw) {
  return visit_voxels(raw, [](auto voxels) {
    if constexpr (std::is_floating_point_v<typename decltype(voxels)::value_type>) {
      const ValueRange range = range_of(voxels);
      return range.fractional && range.is_of_probabilities();
    } else {
      return false;
    }
  });
}

void place_by_values(const RawImage& raw, const ObjectValues& object, Interpolation interpolation,
                     LabelImage& image) {
  visit_voxels(raw, [&](auto voxels) {
    using Voxel = std::remove_const_t<typename decltype(voxels)::element_type>;
    static_cast<void>(find_crossings(voxels, as_stored<Voxel>(object), image, interpolation));
  });
}

void place_by_probabilities(const RawImage& probabilities, const fs::path& path, const Context& context,
                            LabelImage& image) {
  if (probabilities.volumes > 1) fail(path, several_volumes_text(probabilities.volumes));
  require_same_grid(probabilities.frame, image.frame(), path);
  visit_voxels(probabilities, [&](auto voxels) {
    check_values(range_of(voxels), path);
    warn_of_doubts(find_crossings(voxels, kEvenProbability, image), path, context);
  });
}

}  // namespace lumesh::io
