#include "lumesh/quality/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "extremes.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/tetrahedron.hpp"
#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh::quality {

void Histogram::add(double value) {
  const double bin = (value - low) / bin_width();
  const double last = static_cast<double>(counts.size()) - 1;
  ++counts[static_cast<std::size_t>(std::clamp(std::isnan(bin) ? 0 : bin, 0.0, last))];
}

void Histogram::merge(const Histogram& other) {
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] += other.counts[i];
}

std::uint64_t Histogram::total() const {
  std::uint64_t sum = 0;
  for (const std::uint64_t count : counts) sum += count;
  return sum;
}

namespace {

constexpr std::size_t kBlock = 8192;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Sums and extremes of a run of tetrahedra; means are still sums.
struct Tally {
  TetrahedronStatistics s;
  std::uint64_t not_flat = 0;

  Tally() {
    s.smallest_dihedral_deg.value = kInfinity;
    s.largest_dihedral_deg.value = -kInfinity;
    s.smallest_mean_ratio.value = kInfinity;
    s.largest_aspect.value = -kInfinity;
    s.dihedral_deg = {0, 180, std::vector<std::uint64_t>(180, 0)};
    s.mean_ratio = {0, 1, std::vector<std::uint64_t>(50, 0)};
  }
};

void count_angles(TetrahedronStatistics& s, const std::array<double, 6>& angles, std::uint32_t index) {
  const auto [smallest, largest] = std::ranges::minmax_element(angles);
  for (const double angle : angles) s.dihedral_deg.add(angle);
  s.mean_smallest_dihedral_deg += *smallest;
  lower(s.smallest_dihedral_deg, *smallest, index);
  raise(s.largest_dihedral_deg, *largest, index);
  s.below_5_deg += *smallest < 5;
  s.below_10_deg += *smallest < 10;
  s.below_15_deg += *smallest < 15;
  s.above_150_deg += *largest > 150;
  s.above_160_deg += *largest > 160;
  s.above_165_deg += *largest > 165;
}

void count_tetrahedron(Tally& tally, const MeshView& mesh, std::uint32_t index) {
  const Cell<4>& v = mesh.tetrahedra[index];
  const Vec3 &a = mesh.points[v[0]], &b = mesh.points[v[1]], &c = mesh.points[v[2]], &d = mesh.points[v[3]];
  TetrahedronStatistics& s = tally.s;
  ++s.count;
  s.inverted += !(tetrahedron_volume(a, b, c, d) > 0);
  count_angles(s, dihedral_angles_deg(a, b, c, d), index);
  const double ratio = mean_ratio(a, b, c, d);
  s.mean_ratio.add(ratio);
  s.mean_mean_ratio += ratio;
  lower(s.smallest_mean_ratio, ratio, index);
  const double aspect = aspect_ratio(a, b, c, d);
  raise(s.largest_aspect, aspect, index);
  if (std::isfinite(aspect)) {
    s.mean_aspect += aspect;
    ++tally.not_flat;
  }
  s.mean_edge_mm +=
      ((b - a).norm() + (c - a).norm() + (d - a).norm() + (c - b).norm() + (d - b).norm() + (d - c).norm()) /
      6;
}

Tally combine(Tally all, const Tally& more) {
  TetrahedronStatistics& s = all.s;
  const TetrahedronStatistics& m = more.s;
  s.count += m.count;
  s.inverted += m.inverted;
  lower(s.smallest_dihedral_deg, m.smallest_dihedral_deg.value, m.smallest_dihedral_deg.tetrahedron);
  raise(s.largest_dihedral_deg, m.largest_dihedral_deg.value, m.largest_dihedral_deg.tetrahedron);
  lower(s.smallest_mean_ratio, m.smallest_mean_ratio.value, m.smallest_mean_ratio.tetrahedron);
  raise(s.largest_aspect, m.largest_aspect.value, m.largest_aspect.tetrahedron);
  s.mean_smallest_dihedral_deg += m.mean_smallest_dihedral_deg;
  s.mean_mean_ratio += m.mean_mean_ratio;
  s.mean_aspect += m.mean_aspect;
  s.mean_edge_mm += m.mean_edge_mm;
  s.dihedral_deg.merge(m.dihedral_deg);
  s.mean_ratio.merge(m.mean_ratio);
  s.below_5_deg += m.below_5_deg;
  s.below_10_deg += m.below_10_deg;
  s.below_15_deg += m.below_15_deg;
  s.above_150_deg += m.above_150_deg;
  s.above_160_deg += m.above_160_deg;
  s.above_165_deg += m.above_165_deg;
  all.not_flat += more.not_flat;
  return all;
}

TetrahedronStatistics measure_tetrahedra(const MeshView& mesh) {
  Tally tally = parallel::reduce(
      mesh.tetrahedra.size(), kBlock, Tally(),
      [&](Tally& part, std::size_t i) { count_tetrahedron(part, mesh, static_cast<std::uint32_t>(i)); },
      combine);
  TetrahedronStatistics& s = tally.s;
  if (s.count == 0) {
    for (Extreme* extreme :
         {&s.smallest_dihedral_deg, &s.largest_dihedral_deg, &s.smallest_mean_ratio, &s.largest_aspect})
      extreme->value = 0;
    return s;
  }
  const auto count = static_cast<double>(s.count);
  s.mean_smallest_dihedral_deg /= count;
  s.mean_mean_ratio /= count;
  s.mean_edge_mm /= count;
  s.mean_aspect /= std::max<double>(1, static_cast<double>(tally.not_flat));
  for (Extreme* extreme :
       {&s.smallest_dihedral_deg, &s.largest_dihedral_deg, &s.smallest_mean_ratio, &s.largest_aspect})
    locate(*extreme, mesh);
  return s;
}

/// Least determinant of the three edges that leave a corner, over the product of their lengths.
double min_scaled_jacobian(std::span<const Vec3> points, std::span<const std::uint32_t> cell) {
  double smallest = 1;
  for (const auto& [at, a, b, c] : corners_of_cell(cell.size())) {
    const Vec3& corner = points[cell[at]];
    const Vec3 u = points[cell[a]] - corner, v = points[cell[b]] - corner, w = points[cell[c]] - corner;
    const double lengths = u.norm() * v.norm() * w.norm();
    smallest = std::min(smallest, lengths > 0 ? u.cross(v).dot(w) / lengths : 0);
  }
  return smallest;
}

template <std::size_t N>
double min_over_cells(std::span<const Vec3> points, std::span<const Cell<N>> cells) {
  return parallel::min_of(cells.size(), kBlock, 1.0,
                          [&](std::size_t i) { return scaled_jacobian(points, cells[i]); });
}

double smallest_scaled_jacobian(const MeshView& mesh) {
  return std::min({min_over_cells(mesh.points, mesh.hexahedra), min_over_cells(mesh.points, mesh.prisms),
                   min_over_cells(mesh.points, mesh.pyramids)});
}

std::vector<Label> labels_in_use(const AllCells& cells) {
  auto merge = [](std::vector<Label> all, const std::vector<Label>& more) {
    all.insert(all.end(), more.begin(), more.end());
    sort_unique(all);
    return all;
  };
  return parallel::reduce_blocks(
      cells.size(), kBlock, std::vector<Label>(),
      [&](std::size_t begin, std::size_t end) {
        std::vector<Label> seen;
        for (std::size_t i = begin; i < end; ++i)
          if (seen.empty() || seen.back() != cells.label(i)) seen.push_back(cells.label(i));
        return merge(std::move(seen), {});
      },
      merge);
}

struct VolumeTally {
  std::vector<LabelVolume> labels;
  std::uint64_t inverted = 0;
};

VolumeTally measure_volumes(const MeshView& mesh) {
  const AllCells cells(mesh);
  VolumeTally empty;
  for (const Label label : labels_in_use(cells)) empty.labels.push_back({label, 0, 0});
  return parallel::reduce_blocks(
      cells.size(), kBlock, empty,
      [&](std::size_t begin, std::size_t end) {
        VolumeTally part = empty;
        auto entry = part.labels.begin();
        for (std::size_t i = begin; i < end; ++i) {
          const Label label = cells.label(i);
          if (entry->label != label)
            entry = std::ranges::lower_bound(part.labels, label, {}, &LabelVolume::label);
          const double volume = cells.volume(i);
          ++entry->cells;
          entry->volume_mm3 += volume;
          part.inverted += !(volume > 0) || cells.has_turned_corner(i);
        }
        return part;
      },
      [](VolumeTally all, const VolumeTally& more) {
        for (std::size_t i = 0; i < all.labels.size(); ++i) {
          all.labels[i].cells += more.labels[i].cells;
          all.labels[i].volume_mm3 += more.labels[i].volume_mm3;
        }
        all.inverted += more.inverted;
        return all;
      });
}

}  // namespace

double scaled_jacobian(std::span<const Vec3> points, const Cell<5>& pyramid) {
  return min_scaled_jacobian(points, pyramid);
}
double scaled_jacobian(std::span<const Vec3> points, const Cell<6>& prism) {
  return min_scaled_jacobian(points, prism);
}
double scaled_jacobian(std::span<const Vec3> points, const Cell<8>& hexahedron) {
  return min_scaled_jacobian(points, hexahedron);
}

MeshStatistics measure(const MeshView& mesh) {
  MeshStatistics result;
  result.vertices = mesh.points.size();
  result.pyramids = mesh.pyramids.size();
  result.prisms = mesh.prisms.size();
  result.hexahedra = mesh.hexahedra.size();
  result.tetrahedra = measure_tetrahedra(mesh);
  result.smallest_scaled_jacobian = smallest_scaled_jacobian(mesh);
  VolumeTally volumes = measure_volumes(mesh);
  result.labels = std::move(volumes.labels);
  result.inverted_cells = volumes.inverted;
  if (const Box3 box = bounding_box(mesh.points); !box.isEmpty()) {
    result.low_mm = box.min();
    result.high_mm = box.max();
  }
  return result;
}

}  // namespace lumesh::quality
