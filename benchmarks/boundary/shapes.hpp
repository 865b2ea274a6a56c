#pragma once
/// @file Shapes whose surface is known by a formula, and images of their labels.
///
/// The smallest voxel edge is 1 mm in every image, so that mm and voxels are the same; the centre of voxel
/// (0, 0, 0) is the origin. Random places come from seeds: the same name and seed give the same image.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh::boundary {

/// Axis and radius of a straight tube.
struct Tube {
  Vec3 centre_mm = Vec3::Zero();
  Vec3 direction = Vec3::UnitX();  ///< Unit.
  double radius_mm = 0;
};

struct Shape {
  std::string name;
  ImageFrame frame;
  /// > 0 inside; zero on the surface and the distance to it near by, to first order at least.
  std::function<double(const Vec3&)> depth_mm;
  std::optional<Tube> tube;
  /// Where a sharp edge is so near that no smooth surface can be right; empty: nowhere.
  std::function<bool(const Vec3&)> near_crease;
  double radius_mm = 0;  ///< Of the thinnest part: what elements have to resolve.

  /// Unit, into the shape.
  [[nodiscard]] Vec3 inward_normal(const Vec3& point_mm) const;
  /// The place of the surface near a point of which depth_mm() is the distance about.
  [[nodiscard]] Vec3 on_surface(const Vec3& near_mm) const;
  /// In voxels, of the point to the border voxels' centres; < 0 outside of them.
  [[nodiscard]] double voxels_from_border(const Vec3& point_mm) const;
};

/// What an image tells besides labels.
enum class Told : std::uint8_t {
  kSides,      ///< Labels: of voxels' centres.
  kThreshold,  ///< Labels: of voxels of which the shape has at least half the volume.
  kVolumes,    ///< These shares of volume, too.
  kRamp,       ///< Values that rise with the depth, from 0 to 1 within two voxels, and the labels they make.
};

/// What separates the labels from the shape's own voxels.
struct LabelError {
  double flipped_share = 0;  ///< Of the voxels with a neighbour of the other label.
  double correlated_mm = 0;  ///< Standard deviation of a smooth random shift of the surface.
  Told told = Told::kSides;
  double value_noise = 0;  ///< Standard deviation of an error of the values.
};

/// One entry of the list of shapes.
struct Case {
  std::string name;
  LabelError error;
  std::function<Shape(std::uint64_t seed)> make;
};

/// All shapes, in the order in which they are reported.
[[nodiscard]] std::vector<Case> all_cases();

/// Images of values besides labels, and of the labels that they make alone.
[[nodiscard]] std::vector<Case> value_cases();

/// Label 1 where a voxel's centre is inside. With a correlated error the largest piece alone.
[[nodiscard]] LabelImage labels_of(const Shape& shape, const LabelError& error, std::uint64_t seed);

/// Uniform in [0, 1), the same on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform();
  double normal();
  Vec3 in_box(const Vec3& low, const Vec3& high);
  Vec3 direction();

 private:
  std::uint64_t next();
  std::uint64_t state_;
};

/// A seed for one purpose, from a name and a number.
[[nodiscard]] std::uint64_t seed_of(const std::string& name, std::uint64_t number);

}  // namespace lumesh::boundary
