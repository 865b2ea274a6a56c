#pragma once
// Sections of the object in planes across an axis of the image, followed from one depth to the next.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "lumesh/field/label_field.hpp"

namespace lumesh::field {

/// The other two axes.
[[nodiscard]] inline std::array<int, 2> axes_across(int axis) {
  return {(axis + 1) % 3, (axis + 2) % 3};
}

inline constexpr int kSquaresPerVoxel = 3;  ///< Along each of its edges.

/// Squares of planes behind a border face of the image, a few to a voxel.
struct SectionWindow {
  int axis = 0;                 ///< Across the planes.
  bool is_upper = false;        ///< Whether depths are counted from the image's end along it.
  double border = 0;            ///< Voxel index along the axis.
  double step = 1;              ///< Unit of depths, in voxels along the axis.
  Index3 low = Index3::Zero();  ///< The first voxel, in the image's outermost layer.
  int columns = 0, rows = 0;    ///< Squares along axes_across().

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  /// Voxel index of a square's centre.
  [[nodiscard]] Vec3 place(std::size_t square, double depth) const;
  /// The voxel of the outermost layer that a square at the border belongs to.
  [[nodiscard]] Index3 voxel(std::size_t square) const;
};

/// A connected piece of the object in such a plane. Areas and lengths are in squares.
struct PlaneSection {
  std::vector<std::uint8_t> is_inside;  ///< By square.
  double area = 0;
  double growth =
      0;  ///< Derivative of the area by a shift of the wall, an edge of the smallest voxel outwards.
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
};

/// Keeps references to both.
class SectionFinder {
 public:
  /// @param label  Whose sections are found; 0: those of all labels together.
  SectionFinder(const LabelField& field, const SectionWindow& window, LabelField::LabelIndex label);

  /// The section at a depth that lies over squares; none if it has a hole or leaves the window, or if
  /// something else is as near as `room` voxels.
  /// @param room  At most kMaxRoom.
  [[nodiscard]] std::optional<PlaneSection> find(const std::vector<std::uint8_t>& over, double depth,
                                                 int room) const;
  /// Edges of a voxel, in units of the smallest.
  [[nodiscard]] const Vec3& edges() const { return edges_; }

  static constexpr int kMaxRoom = 3;

 private:
  [[nodiscard]] double value(const Vec3& place) const;
  [[nodiscard]] bool is_alone(const std::vector<std::uint8_t>& inside, const std::vector<double>& values,
                              int room) const;
  void measure(const std::vector<double>& values, PlaneSection& section) const;

  const LabelField& field_;
  const SectionWindow& window_;
  LabelField::LabelIndex label_;
  Vec3 edges_;
  double square_ = 1;  // Edge of a square, in edges of the smallest voxel.
};

}  // namespace lumesh::field
