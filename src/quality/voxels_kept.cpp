#include "lumesh/quality/voxels_kept.hpp"

#include <cmath>

#include "counted_voxels.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"
#include "nearby.hpp"
#include "on_planes.hpp"
#include "rows_of_tetrahedron.hpp"

namespace lumesh::quality {

namespace {

using image::Run;

constexpr double kOnBoundary = 1e-6;  // A centre so near to the boundary lies on it, in voxels.

/// Marks the counted voxels whose centres lie in cells: those with a label in cells of their own, those of
/// the background in any.
class Marks {
 public:
  Marks(const LabelImage& image, const CountedVoxels& voxels)
      : image_(image), voxels_(voxels), marks_(voxels.size(), 0) {}

  [[nodiscard]] bool at(std::size_t number) const { return marks_[number] != 0; }

  /// Cells of any shape; all but tetrahedra are cut into those between their centre and their sides.
  void add_cells(const MeshView& mesh, std::span<const Vec3> points_in_voxels) {
    const AllCells cells(mesh);
    parallel::for_each_index(cells.size(), [&](std::size_t cell) {
      const Label label = cells.label(cell);
      for_each_tetrahedron(mesh, cells, cell, points_in_voxels,
                           [&](const RowsOfTetrahedron& rows) { mark(rows, label); });
    });
  }

 private:
  void mark(const RowsOfTetrahedron& rows, Label label) {
    for_each_held_run(rows, voxels_.runs(), [&](std::size_t r, std::int32_t begin, std::int32_t end) {
      const Run& run = voxels_.runs().runs[r];
      if (run.label != 0 && image_.values()[run.label] != label) return;
      const std::size_t number = voxels_.number_of(r);
      for (std::int32_t i = begin; i < end; ++i)
        parallel::raise(marks_[number + static_cast<std::size_t>(i - run.begin)]);
    });
  }

  const LabelImage& image_;
  const CountedVoxels& voxels_;
  std::vector<std::uint8_t> marks_;
};

/// The voxels whose centres can lie in the points' box.
VoxelBox box_of(std::span<const Vec3> points_in_voxels) {
  const Box3 box = bounding_box(points_in_voxels);
  // Numbers far outside of any image keep within what an index can be.
  const auto index = [](const Vec3& p) { return Index3(p.cwiseMax(-1e9).cwiseMin(1e9).cast<int>()); };
  return {index((box.min().array() - kOnBoundary).ceil()),
          index((box.max().array() + kOnBoundary).floor() + 1)};
}

/// A voxel that is not where its label is in the mesh, or on the boundary of that.
struct Candidate {
  Index3 voxel;
  Vec3 centre_mm;
};

/// Counts of one label index, before distances are known.
struct KeptTally {
  std::uint64_t counted = 0;
  std::vector<Candidate> missed;
};

std::vector<KeptTally> tally(const LabelImage& image, const CountedVoxels& voxels, const Marks& marks,
                             const CutPlanes& planes) {
  const image::RunImage& runs = voxels.runs();
  const std::vector<KeptTally> zero(image.values().size());
  return parallel::reduce(
      runs.first.size() - 1, 512, zero,
      [&](std::vector<KeptTally>& counts, std::size_t row) {
        for (std::size_t r = runs.first[row]; r < runs.first[row + 1]; ++r) {
          const Run& run = runs.runs[r];
          for (std::int32_t i = run.begin; i < run.end; ++i) {
            const Index3 voxel = grid_row(runs.size, row) + i * Index3::UnitX();
            const std::size_t number = voxels.number_of(r) + static_cast<std::size_t>(i - run.begin);
            const bool missed = marks.at(number) == (run.label == 0);
            if (!missed && planes.none()) {
              ++counts[run.label].counted;
              continue;
            }
            const Vec3 centre_mm = image.frame().to_physical(voxel.cast<double>());
            if (planes.beyond(centre_mm)) continue;
            ++counts[run.label].counted;
            if (missed) counts[run.label].missed.push_back({voxel, centre_mm});
          }
        }
      },
      [](std::vector<KeptTally> all, std::vector<KeptTally> more) {
        for (std::size_t l = 0; l < all.size(); ++l) {
          all[l].counted += more[l].counted;
          all[l].missed.insert(all[l].missed.end(), more[l].missed.begin(), more[l].missed.end());
        }
        return all;
      });
}

/// Tells how far candidates are from the boundary; those on it are kept.
KeptVoxels measured(const KeptTally& tally, std::span<const Vec3> points,
                    const std::vector<Cell<3>>& boundary, double voxel_size_mm) {
  KeptVoxels result;
  result.counted = tally.counted;
  result.kept = tally.counted - tally.missed.size();
  if (tally.missed.empty() || boundary.empty()) return result;
  std::vector<double> distances_mm(tally.missed.size());
  const TriangleTree tree(points, boundary);
  for_each_nearby(tree, distances_mm.size(), [&](Nearby& nearby, std::size_t i) {
    distances_mm[i] = nearby.distance(tally.missed[i].centre_mm);
  });
  for (std::size_t i = 0; i < distances_mm.size(); ++i) {
    if (distances_mm[i] <= kOnBoundary * voxel_size_mm)
      ++result.kept;
    else if (!result.worst || distances_mm[i] > result.worst->distance_mm)
      result.worst = {distances_mm[i], tally.missed[i].centre_mm, tally.missed[i].voxel};
  }
  return result;
}

void add(const KeptVoxels& part, KeptVoxels& all) {
  all.counted += part.counted;
  all.kept += part.kept;
  if (part.worst && (!all.worst || part.worst->distance_mm > all.worst->distance_mm)) all.worst = part.worst;
}

}  // namespace

VoxelsKept count_voxels_kept(const MeshView& mesh, const MeshSurface& surface, const LabelImage& image,
                             std::span<const CutPlane> planes) {
  const double voxel_size_mm = std::cbrt(image.frame().voxel_volume_mm3());
  std::vector<Vec3> points_in_voxels(mesh.points.size());
  parallel::for_each_index(points_in_voxels.size(), [&](std::size_t v) {
    points_in_voxels[v] = image.frame().to_index(mesh.points[v]);
  });
  const CountedVoxels voxels(image, box_of(points_in_voxels));
  Marks marks(image, voxels);
  marks.add_cells(mesh, points_in_voxels);
  const std::vector<KeptTally> tallies = tally(image, voxels, marks, CutPlanes(planes, voxel_size_mm));
  VoxelsKept result;
  result.background = measured(tallies[0], mesh.points, surface.outer(), voxel_size_mm);
  result.all = result.background;
  for (std::size_t l = 1; l < tallies.size(); ++l) {
    if (tallies[l].counted == 0) continue;
    const Label label = image.values()[l];
    result.labels.push_back({label, measured(tallies[l], mesh.points, surface.around(label), voxel_size_mm)});
    add(result.labels.back().voxels, result.all);
  }
  return result;
}

}  // namespace lumesh::quality
