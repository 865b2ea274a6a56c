#include "surface_rebuild.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/image/crossings.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/stages/delaunay_stage.hpp"
#include "lumesh/surface/findings.hpp"
#include "lumesh/surface/winding.hpp"

namespace lumesh {
namespace {

constexpr double kInsideWinding = 0.5;  // Winding number.
constexpr double kMaxVoxels = 3e7;

ImageFrame frame_around(std::span<const Vec3> points, double spacing_mm) {
  constexpr double kMargin = 4;  // Voxels.
  const Box3 box = bounding_box(points);
  ImageFrame frame;
  frame.spacing_mm = Vec3::Constant(spacing_mm);
  frame.origin_mm = box.min() - Vec3::Constant(kMargin * spacing_mm);
  for (int axis = 0; axis < 3; ++axis)
    frame.size[axis] = static_cast<int>(std::ceil(box.sizes()[axis] / spacing_mm + 2 * kMargin));
  return frame;
}

/// A given surface, and questions to it.
class GivenSurface {
 public:
  explicit GivenSurface(const TriangleMesh& mesh)
      : mesh_(mesh), tree_(mesh.points, mesh.triangles), winding_(mesh.points, mesh.triangles) {}

  [[nodiscard]] LabelImage image(double spacing_mm) const {
    LabelImage image(frame_around(mesh_.points, spacing_mm), {0, 1});
    std::vector<float> depths(image.voxels().size());
    const Index3 blocks = (image.frame().size.array() + kBlock - 1) / kBlock;
    const Index3 rows(1, blocks.y(), blocks.z());
    parallel::for_each_index(grid_count(rows), 1, [&](std::size_t r) {
      BlockRow row{*this, image, depths};
      for (Index3 at = grid_place(rows, r); at.x() < blocks.x(); ++at.x()) row.fill(kBlock * at);
    });
    parallel::for_each_index(depths.size(),
                             [&](std::size_t i) { image.voxels()[i] = depths[i] > 0 ? 1 : 0; });
    (void)find_crossings(depths, 0.0, image);
    return image;
  }

  /// Whether there is inside on one side of a place on the surface and outside on the other.
  [[nodiscard]] bool is_boundary(const Vec3& point, std::size_t triangle, double step_mm) const {
    const Vec3 step = step_mm * triangle_normal(mesh_.points, mesh_.triangles[triangle]);
    return winding_.at(point + step) < kInsideWinding || winding_.at(point - step) < kInsideWinding;
  }
  [[nodiscard]] const TriangleTree& tree() const { return tree_; }

 private:
  static constexpr int kBlock = 4;  // Voxels along its edges.

  /// Side of one place after another along a row: as that before where no triangle lies between them.
  class Side {
   public:
    /// @param is_free  Whether there is none for sure, and holes between are wide.
    bool is_inside(const WindingNumbers& winding, const Vec3& place, bool is_free) {
      // Beside a wide hole, winding numbers change little by little.
      constexpr double kSure = 0.02;
      if (!is_free || !(std::abs(winding_ - std::round(winding_)) < kSure)) winding_ = winding.at(place);
      return winding_ > kInsideWinding;
    }

   private:
    double winding_ = std::numeric_limits<double>::quiet_NaN();
  };

  /// Blocks of voxels along x.
  struct BlockRow {
    const GivenSurface& surface;
    const LabelImage& image;
    std::vector<float>& depths;
    Side of_block = {};
    std::array<Side, kBlock* kBlock> of_voxels = {};
    bool was_near = true;

    /// Where no triangle is near, one voxel speaks for all.
    void fill(const Index3& first) {
      const ImageFrame& frame = image.frame();
      const Index3 end = (first.array() + kBlock).min(frame.size.array());
      const Vec3 low = frame.to_physical(first.cast<double>()), high = frame.to_physical(end.cast<double>());
      const bool is_near = !surface.tree_.overlapping(low - frame.spacing_mm, high).empty();
      if (is_near && !was_near) of_voxels.fill(of_block);
      const bool is_inside = !is_near && of_block.is_inside(surface.winding_, low, !was_near);
      for (int k = first.z(); k < end.z(); ++k)
        for (int j = first.y(); j < end.y(); ++j)
          for (int i = first.x(); i < end.x(); ++i) {
            const Index3 v(i, j, k);
            Side& side = of_voxels[static_cast<std::size_t>((k - first.z()) * kBlock + j - first.y())];
            depths[frame.offset(v)] =
                static_cast<float>(is_near ? depth_near(frame.to_physical(v.cast<double>()), side)
                                           : signed_distance(kFar * frame.spacing_mm.x(), is_inside));
          }
      was_near = is_near;
    }
    /// Within a block with triangles near.
    [[nodiscard]] double depth_near(const Vec3& place, Side& side) const {
      constexpr double kFree = 1.5;  // Steps.
      const double step = image.frame().spacing_mm.x(), far = kFar * step;
      const double distance = std::min(far, surface.tree_.nearest(place, far).distance);
      return signed_distance(distance, side.is_inside(surface.winding_, place, distance > kFree * step));
    }
    [[nodiscard]] static double signed_distance(double distance, bool is_inside) {
      return is_inside ? std::max(distance, 1e-30) : -distance;
    }
  };
  static constexpr double kFar = 2;  // Voxels; beyond, distances do not matter.

  const TriangleMesh& mesh_;
  TriangleTree tree_;
  WindingNumbers winding_;
};

TriangleMesh meshed_boundary(const LabelImage& image, Context context) {
  context.report_results_to({});  // An incomplete mesh is no result of a repair: a stop ends that.
  const ImageDomain domain(image, {{BoundaryFidelity::kExact}, {}});
  DelaunayRequest request;
  request.delaunay.size_mm = 8 * domain.resolution_mm();  // Only its surface is wanted.
  return extract_boundary(make_delaunay_mesh(domain, request, nullptr, context).mesh);
}

/// One try. @param max_distance_mm  What it may move at most.
RebuiltSurface rebuilt_at(const TriangleMesh& given, const GivenSurface& surface, double spacing_mm,
                          double max_distance_mm, Context& context) {
  RebuiltSurface made;
  made.spacing_mm = spacing_mm;
  try {
    made.surface = meshed_boundary(surface.image(spacing_mm), context);
  } catch (const Error& error) {  // Its advice is on options of the mesher, which a repair does not have.
    if (error.kind() != ErrorKind::kBadInput) throw;
    made.failure = "nothing of its inside is left when it is rebuilt";
    made.failure_mm = given.points[given.triangles.front()[0]];
    return made;
  }
  for (std::size_t t = 0; t < made.surface.triangles.size(); ++t) {
    const Vec3 middle = triangle_centre(made.surface.points, made.surface.triangles[t]);
    made.surface.patches[t] = given.patches[surface.tree().nearest(middle).triangle];
  }
  made.surface.volume_points.clear();
  const double step = max_distance_mm / 4;
  const TriangleTree tree(made.surface.points, made.surface.triangles);
  const surfaces::FarthestPoint out = surfaces::farthest_from(
      given, tree, step, nullptr,
      [&](const Vec3& p, std::size_t t) { return surface.is_boundary(p, t, max_distance_mm / 2); });
  const surfaces::FarthestPoint back = surfaces::farthest_from(made.surface, surface.tree(), step);
  made.moved = back.distance_mm > out.distance_mm ? back : out;
  if (made.moved.distance_mm > max_distance_mm) {
    made.failure = "rebuilt it would move farther than asked";
    made.failure_mm = made.moved.place_mm;
  }
  for (const Finding& finding : surfaces::findings_of(made.surface.points, made.surface.triangles)) {
    if (finding.severity != Severity::kFault || finding.places_mm.empty()) continue;
    made.failure = "rebuilt it still has " + finding.text;
    made.failure_mm = finding.places_mm.front();
  }
  return made;
}

}  // namespace

RebuiltSurface rebuild_surface(const TriangleMesh& given, double max_distance_mm, Context& context) {
  constexpr int kTries = 3;
  const GivenSurface surface(given);
  RebuiltSurface made;
  made.failure = "so small a distance needs too fine a grid";
  double spacing = max_distance_mm / 2;
  for (int n = 0; n < kTries; ++n, spacing /= 2) {
    if (frame_around(given.points, spacing).size.cast<double>().prod() > kMaxVoxels) break;
    made = rebuilt_at(given, surface, spacing, max_distance_mm, context);
    // Grids move a surface by about a step: what is off by more is so on finer ones, too.
    constexpr double kSteps = 2;
    if (made.failure.empty() || made.moved.distance_mm > max_distance_mm + kSteps * spacing) break;
  }
  return made;
}

}  // namespace lumesh
