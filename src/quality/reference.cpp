#include "lumesh/quality/reference.hpp"

#include <cmath>

#include "lumesh/core/angles.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "on_planes.hpp"
#include "samples.hpp"
#include "voxel_faces.hpp"

namespace lumesh::quality {

namespace {

/// Gradient of the label's signed distance by central differences; unit length, or zero where it has none.
Vec3 outward_normal(const Phantom& phantom, const Vec3& p, Label label, double step_mm) {
  Vec3 gradient;
  for (int d = 0; d < 3; ++d) {
    const Vec3 step = step_mm * Vec3::Unit(d);
    gradient[d] = phantom.signed_distance_mm(p + step, label) - phantom.signed_distance_mm(p - step, label);
  }
  const double length = gradient.norm();
  return length > 0 ? Vec3(gradient / length) : Vec3(Vec3::Zero());
}

class LabelComparison {
 public:
  LabelComparison(const MeshView& mesh, const MeshSurface& surface, const Phantom& phantom,
                  std::span<const CutPlane> planes, Label label)
      : points_(mesh.points),
        triangles_(surface.around(label)),
        phantom_(phantom),
        label_(label),
        voxel_mm_(std::cbrt(phantom.frame().voxel_volume_mm3())),
        planes_(planes, voxel_mm_) {}

  [[nodiscard]] bool empty() const { return triangles_.empty(); }

  [[nodiscard]] DistanceSummary distances() const {
    std::vector<WeightedValue> values = parallel::collect<WeightedValue>(
        triangles_.size(), 64, [&](std::size_t t, std::vector<WeightedValue>& out) {
          const Vec3 &a = corner(t, 0), &b = corner(t, 1), &c = corner(t, 2);
          if (planes_.contain({a, b, c})) return;
          sample_triangle(a, b, c, voxel_mm_, [&](const Vec3& p, double weight) {
            out.push_back({phantom_.surface_distance_mm(p, label_), weight, p});
          });
        });
    return summarise(values);
  }

  /// @param faces  Of the label, in the phantom's image.
  [[nodiscard]] std::optional<DistanceSummary> distances_of_truth(std::span<const VoxelFace> faces) const {
    const TriangleTree tree(points_, triangles_);
    std::vector<WeightedValue> values = parallel::collect<WeightedValue>(
        faces.size(), 256, [&](std::size_t i, std::vector<WeightedValue>& out) {
          if (const auto x = place_on_surface(faces[i])) out.push_back({tree.nearest(*x).distance, 1, *x});
        });
    if (values.empty()) return std::nullopt;
    return summarise(values);
  }

  [[nodiscard]] DistanceSummary normal_angles() const {
    std::vector<WeightedValue> values = parallel::collect<WeightedValue>(
        triangles_.size(), 64, [&](std::size_t t, std::vector<WeightedValue>& out) { add_angle(t, out); });
    return summarise(values);
  }

 private:
  [[nodiscard]] const Vec3& corner(std::size_t t, std::size_t i) const { return points_[triangles_[t][i]]; }

  /// Where the exact surface is next to a square between voxels; nothing for those on cuts, and where the way
  /// there does not end.
  [[nodiscard]] std::optional<Vec3> place_on_surface(const VoxelFace& face) const {
    constexpr int kSteps = 6;
    const ImageFrame& frame = phantom_.frame();
    const Vec3 index = Vec3(face.twice_centre[0], face.twice_centre[1], face.twice_centre[2]) / 2;
    const auto is_inside = [&](const Vec3& at) {
      return (at.array() > -0.5).all() && (at.array() < frame.size.cast<double>().array() - 0.5).all();
    };
    if (!is_inside(index)) return std::nullopt;
    Vec3 x = frame.to_physical(index);
    for (int step = 0; step < kSteps; ++step)
      x -= phantom_.signed_distance_mm(x, label_) * outward_normal(phantom_, x, label_, 0.02 * voxel_mm_);
    const bool has_arrived = std::abs(phantom_.signed_distance_mm(x, label_)) < 1e-3 * voxel_mm_;
    if (!has_arrived || !is_inside(frame.to_index(x)) || planes_.beyond(x)) return std::nullopt;
    return x;
  }

  void add_angle(std::size_t t, std::vector<WeightedValue>& out) const {
    const Vec3 &a = corner(t, 0), &b = corner(t, 1), &c = corner(t, 2);
    const Vec3 centre = triangle_centre(a, b, c);
    const double distance = phantom_.signed_distance_mm(centre, label_);
    // Where the cut of the image is nearer than the shape's own surface the triangle belongs to a flat cap.
    const bool on_cap = phantom_.surface_distance_mm(centre, label_) < std::abs(distance) - 1e-6 * voxel_mm_;
    if (on_cap || planes_.contain({a, b, c})) return;
    const double step = 0.02 * voxel_mm_;
    const Vec3 foot = centre - distance * outward_normal(phantom_, centre, label_, step);
    const Vec3 truth = outward_normal(phantom_, foot, label_, step);
    const Vec3 normal = triangle_normal(a, b, c);
    const double angle = degrees(angle_between(normal, truth));
    out.push_back({angle, triangle_area(a, b, c), centre});
  }

  std::span<const Vec3> points_;
  std::vector<Cell<3>> triangles_;
  const Phantom& phantom_;
  Label label_;
  double voxel_mm_;
  CutPlanes planes_;
};

}  // namespace

std::vector<LabelReference> compare_with_phantom(const MeshView& mesh, const MeshSurface& surface,
                                                 const Phantom& phantom, std::span<const CutPlane> planes) {
  std::vector<LabelReference> result;
  const std::vector<LabelFaces> faces = collect_voxel_faces(phantom.rasterise());
  for (const Label label : phantom.labels()) {
    LabelReference reference;
    reference.label = label;
    reference.volume_mm3 = phantom.volume_mm3(label);
    const PhantomTruth truth = phantom.truth(label);
    reference.components = truth.component_count;
    reference.euler = truth.euler_number;
    const LabelComparison comparison(mesh, surface, phantom, planes, label);
    if (!comparison.empty()) {
      reference.surface_distance_mm = comparison.distances();
      for (const LabelFaces& of_label : faces)
        if (of_label.label == label)
          reference.truth_to_mesh_mm = comparison.distances_of_truth(of_label.faces);
      reference.normal_angle_deg = comparison.normal_angles();
    }
    result.push_back(reference);
  }
  return result;
}

}  // namespace lumesh::quality
