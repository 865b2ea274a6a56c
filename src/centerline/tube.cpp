#include "tube.hpp"

#include <fmt/format.h>

#include <cmath>

#include "lumesh/core/error.hpp"
#include "lumesh/core/even_places.hpp"

namespace lumesh::centerline {

namespace {

/// Catmull-Rom's cubic between the middle ones of four values, 0 <= t <= 1.
template <class Value>
Value cubic(const Value& a, const Value& b, const Value& c, const Value& d, double t) {
  return b + 0.5 * t * ((c - a) + t * ((2 * a - 5 * b + 4 * c - d) + t * (3 * (b - c) + d - a)));
}

/// Points at given ways along the line.
Tube sampled(const Tube& tube, const std::vector<double>& length, const std::vector<double>& ways) {
  const std::size_t count = tube.size();
  const auto wrapped = [&](std::ptrdiff_t i) {
    const auto n = static_cast<std::ptrdiff_t>(count);
    return static_cast<std::size_t>(tube.closed ? (i % n + n) % n : std::clamp<std::ptrdiff_t>(i, 0, n - 1));
  };
  Tube out;
  out.closed = tube.closed;
  std::size_t leg = 0;
  for (const double way : ways) {
    while (leg + 2 < length.size() && length[leg + 1] < way) ++leg;
    const double gap = length[leg + 1] - length[leg];
    const double t = gap > 0 ? std::clamp((way - length[leg]) / gap, 0.0, 1.0) : 0.0;
    const auto i = static_cast<std::ptrdiff_t>(leg);
    const std::size_t a = wrapped(i - 1), b = wrapped(i), c = wrapped(i + 1), d = wrapped(i + 2);
    out.append(cubic<Vec3>(tube.centres[a], tube.centres[b], tube.centres[c], tube.centres[d], t),
               cubic(tube.radii[a], tube.radii[b], tube.radii[c], tube.radii[d], t));
  }
  return out;
}

}  // namespace

void Tube::cut(std::size_t begin, std::size_t end) {
  const auto from = static_cast<std::ptrdiff_t>(begin), to = static_cast<std::ptrdiff_t>(end);
  centres = std::vector<Vec3>(centres.begin() + from, centres.begin() + to);
  radii = std::vector<double>(radii.begin() + from, radii.begin() + to);
}

std::vector<double> lengths_along(const Tube& tube) {
  std::vector<double> length = {0};
  for (std::size_t i = 1; i < tube.size(); ++i)
    length.push_back(length.back() + (tube.centres[i] - tube.centres[i - 1]).norm());
  if (tube.closed) length.push_back(length.back() + (tube.centres.front() - tube.centres.back()).norm());
  return length;
}

Tube resampled(const Tube& tube, double gap_mm) {
  if (tube.size() < 2) return tube;
  constexpr double kMaxGaps = 1e7;
  const std::vector<double> length = lengths_along(tube);
  if (length.back() > kMaxGaps * gap_mm)
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("a spacing of {:g} mm would make {:.2g} points of a line of {:.3g} mm; give a larger one",
                    gap_mm, length.back() / gap_mm, length.back()));
  const auto gaps = std::max<std::size_t>(2, static_cast<std::size_t>(std::lround(length.back() / gap_mm)));
  std::vector<double> ways;
  for (std::size_t i = 0; i < gaps + (tube.closed ? 0 : 1); ++i)
    ways.push_back(length.back() * static_cast<double>(i) / static_cast<double>(gaps));
  return sampled(tube, length, ways);
}

Tube resampled_by_radius(const Tube& tube, double share, double min_mm) {
  if (tube.size() < 2) return tube;
  // The integral of 1 / gap grows by one from point to point.
  const std::vector<double> length = lengths_along(tube);
  const auto gap_at = [&](std::size_t i) { return std::max(min_mm, share * tube.radii[i % tube.size()]); };
  std::vector<double> steps = {0};
  for (std::size_t i = 1; i < length.size(); ++i)
    steps.push_back(steps.back() + (length[i] - length[i - 1]) * 2 / (gap_at(i - 1) + gap_at(i)));
  const auto gaps = std::max<std::size_t>(2, static_cast<std::size_t>(std::ceil(steps.back())));
  std::vector<double> ways;
  for (const PolylinePlace& at : even_places(steps, gaps, gaps + (tube.closed ? 0 : 1)))
    ways.push_back(at.between(length[at.leg], length[at.leg + 1]));
  return sampled(tube, length, ways);
}

Tube averaged(const Tube& tube, double reach_mm) {
  const std::vector<double> length = lengths_along(tube);
  const auto count = static_cast<std::ptrdiff_t>(tube.size());
  const double gap = length.back() / static_cast<double>(std::max<std::size_t>(1, length.size() - 1));
  const auto wanted = static_cast<std::ptrdiff_t>(gap > 0 ? std::lround(reach_mm / gap) : 0);
  Tube out = tube;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::ptrdiff_t reach =
        tube.closed ? std::min(wanted, count / 2) : std::min({wanted, i, count - 1 - i});
    Vec3 centre = Vec3::Zero();
    double radius = 0;
    for (std::ptrdiff_t n = i - reach; n <= i + reach; ++n) {
      const auto at = static_cast<std::size_t>((n + count) % count);
      centre += tube.centres[at];
      radius += tube.radii[at];
    }
    const auto share = 1 / static_cast<double>(2 * reach + 1);
    out.centres[static_cast<std::size_t>(i)] = share * centre;
    out.radii[static_cast<std::size_t>(i)] = share * radius;
  }
  return out;
}

Vec3 direction_at(const Tube& tube, std::size_t at, std::size_t reach) {
  const std::size_t count = tube.size();
  reach = std::max<std::size_t>(1, std::min(reach, count / 2));
  const std::size_t before = tube.closed ? (at + count - reach) % count : at - std::min(at, reach);
  const std::size_t after = tube.closed ? (at + reach) % count : std::min(count - 1, at + reach);
  const Vec3 way = tube.centres[after] - tube.centres[before];
  return way.norm() > 0 ? Vec3(way.normalized()) : Vec3(Vec3::UnitZ());
}

bool is_inside(const Lumen& lumen, const Tube& tube) {
  return std::ranges::all_of(tube.centres, [&](const Vec3& p) { return lumen.inside(p) >= 0.5; });
}

Tube bridge(const Vec3& from, const Vec3& from_direction, double from_radius, const Vec3& to,
            const Vec3& to_direction, double to_radius, double gap_mm) {
  const double span = (to - from).norm();
  const auto gaps = static_cast<int>(std::ceil(span / gap_mm));
  Tube out;
  for (int i = 1; i < gaps; ++i) {
    const double t = static_cast<double>(i) / gaps;
    const double s = 1 - t;
    // Hermite's cubic.
    out.append(s * s * (1 + 2 * t) * from + t * t * (1 + 2 * s) * to +
                   span * (t * s * s * from_direction - t * t * s * to_direction),
               s * from_radius + t * to_radius);
  }
  return out;
}

}  // namespace lumesh::centerline
