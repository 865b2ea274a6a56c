#include "checked_shape.hpp"

#include <cmath>

#include "lumesh/core/grid.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/image/selection.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/quality/surface.hpp"
#include "lumesh/surface/edges.hpp"
#include "scene.hpp"

namespace lumesh::report {

namespace {

std::vector<Cell<3>> outer_triangles(const MeshView& mesh) {
  if (mesh.cell_count() == 0) return {mesh.triangles.begin(), mesh.triangles.end()};
  return surface_for_pictures(mesh).outer();
}

/// Whether most triangles of a surface, which need not be closed, face its centroid.
bool points_inwards(std::span<const Vec3> points, std::span<const Cell<3>> triangles) {
  Vec3 middle = Vec3::Zero();
  double area = 0, six_volumes = 0;
  for (const auto& [a, b, c] : triangles) {
    const double own = triangle_area(points[a], points[b], points[c]);
    middle += own / 3 * (points[a] + points[b] + points[c]);
    area += own;
  }
  if (area > 0) middle /= area;
  for (const auto& [a, b, c] : triangles)
    six_volumes += (points[a] - middle).dot(triangle_area_normal(points[a], points[b], points[c]));
  return six_volumes < 0;
}

/// Labels of blocks of step^3 voxels, each that of the first voxel in it that has one. There is one block
/// more on each side than was asked for.
class Blocks {
 public:
  Blocks(const LabelImage& image, const Index3& low, const Index3& high, int step)
      : low_(low - Index3::Constant(step)),
        size_((high - low) / step + Index3::Constant(3)),
        step_(step),
        labels_(grid_count(size_)) {
    parallel::for_each_index(static_cast<std::size_t>(size_.z()), 1, [&](std::size_t k) {
      for_each_place({0, 0, static_cast<int>(k)}, {size_.x() - 1, size_.y() - 1, static_cast<int>(k)},
                     [&](const Index3& at) { labels_[grid_offset(size_, at)] = label_of(image, at); });
    });
  }

  [[nodiscard]] LabelImage::Index at(const Index3& block) const { return labels_[grid_offset(size_, block)]; }
  [[nodiscard]] const Index3& size() const { return size_; }
  [[nodiscard]] Index3 first_voxel(const Index3& block) const { return low_ + step_ * block; }
  [[nodiscard]] int step() const { return step_; }

 private:
  [[nodiscard]] LabelImage::Index label_of(const LabelImage& image, const Index3& block) const {
    LabelImage::Index found = 0;
    const Index3 first = first_voxel(block), last = first + Index3::Constant(step_ - 1);
    for_each_place(first.cwiseMax(0), last.cwiseMin(image.frame().size - Index3::Ones()),
                   [&](const Index3& voxel) {
                     if (found == 0) found = image.at(voxel);
                   });
    return found;
  }

  Index3 low_, size_;
  int step_;
  std::vector<LabelImage::Index> labels_;
};

/// The side of a block to the next one along an axis.
struct BlockSide {
  Index3 block;
  int axis = 0;
  int direction = 1;  ///< Or -1.
};

/// Makes two triangles of sides of blocks.
class SideFaces {
 public:
  SideFaces(const ImageFrame& frame, const Blocks& blocks)
      : frame_(frame), blocks_(blocks), is_mirrored_(frame.direction.determinant() < 0) {}

  void add(const BlockSide& side, Colour colour, bool matt, Shape& out) const {
    const int u = (side.axis + 1) % 3, v = (side.axis + 2) % 3;
    Vec3 corner = blocks_.first_voxel(side.block).cast<double>() - Vec3::Constant(0.5);
    const double step = blocks_.step();
    if (side.direction > 0) corner[side.axis] += step;
    const Vec3 along_u = step * Vec3::Unit(u), along_v = step * Vec3::Unit(v);
    std::array<Vec3, 4> corners = {corner, corner + along_u, corner + along_u + along_v, corner + along_v};
    for (Vec3& c : corners) c = frame_.to_physical(c);
    if ((side.direction < 0) != is_mirrored_) std::swap(corners[1], corners[3]);
    // The sides of the quadrilateral are outlined, not its diagonal.
    out.faces.push_back({{corners[0], corners[1], corners[2]}, colour, 3, false, matt});
    out.faces.push_back({{corners[0], corners[2], corners[3]}, colour, 6, false, matt});
  }

 private:
  const ImageFrame& frame_;
  const Blocks& blocks_;
  bool is_mirrored_;
};

Colour colour_of_label(const LabelImage& image, LabelImage::Index label) {
  return image.values().size() <= 2 ? kShapeColour : softened(distinct_colour(label - 1U));
}
Colour colour_of_section(const LabelImage& image, LabelImage::Index label) {
  return image.values().size() <= 2 ? kSectionColour : distinct_colour(label - 1U);
}

/// Calls visit(side, label, label of the neighbour) for the sides of blocks, but not of those at the rim.
template <class Visit>
void for_each_side(const Blocks& blocks, const Visit& visit) {
  for_each_place(Index3::Ones(), blocks.size() - Index3::Constant(2), [&](const Index3& block) {
    const LabelImage::Index label = blocks.at(block);
    if (label == 0) return;
    for (int axis = 0; axis < 3; ++axis)
      for (const int direction : {-1, 1}) {
        Index3 next = block;
        next[axis] += direction;
        visit(BlockSide{block, axis, direction}, label, blocks.at(next));
      }
  });
}

/// A line as two triangles that face the viewer.
void add_line(const Camera& camera, const ShapeLine& line, double width, std::vector<ScreenTriangle>& out) {
  constexpr float kInFront = 2.5F;  // Pixels.
  const auto a = camera.project(line.from), b = camera.project(line.to);
  const float x = b[0] - a[0], y = b[1] - a[1], length = std::hypot(x, y);
  if (!(length > 0)) return;
  const float half = static_cast<float>(width) / 2, ux = x / length * half, uy = y / length * half;
  const auto corner = [&](const std::array<float, 3>& end, float along, float across) {
    return std::array<float, 3>{end[0] + along * ux - across * uy, end[1] + along * uy + across * ux,
                                end[2] + kInFront};
  };
  const std::array<std::array<float, 3>, 4> corners = {corner(a, -1, -1), corner(b, 1, -1), corner(b, 1, 1),
                                                       corner(a, -1, 1)};
  out.push_back({{corners[0], corners[1], corners[2]}, {0, 0, 1}, line.colour, 0, true});
  out.push_back({{corners[0], corners[2], corners[3]}, {0, 0, 1}, line.colour, 0, true});
}

}  // namespace

Shape shape_of(const MeshView& mesh) {
  std::vector<Cell<3>> outer = outer_triangles(mesh);
  if (points_inwards(mesh.points, outer))
    for (Cell<3>& triangle : outer) std::swap(triangle[1], triangle[2]);
  Shape shape;
  shape.faces.reserve(outer.size());
  for (const auto& [a, b, c] : outer)
    shape.faces.push_back({{mesh.points[a], mesh.points[b], mesh.points[c]}, kShapeColour, 7, true, false});
  const TriangleMesh welded = surfaces::weld(mesh.points, outer, {});
  for_each_edge(sorted_sides(welded.triangles), [&](std::span<const TriangleSide> edge) {
    if (edge.size() == 2) return;
    shape.lines.push_back({welded.points[edge[0].low], welded.points[edge[0].high],
                           edge.size() == 1 ? kOpenEdgeColour : kCrowdedEdgeColour});
  });
  return shape;
}

Shape shape_of(const LabelImage& image) {
  constexpr int kMaxBlocks = 256;
  const VoxelBox object = object_box(image);
  const Index3 low = object.is_empty() ? Index3(Index3::Zero()) : object.low;
  const Index3 high = object.is_empty() ? low : Index3(object.high - Index3::Ones());
  const int step = ((high - low).maxCoeff() + kMaxBlocks) / kMaxBlocks;
  const Blocks blocks(image, low, high, step);
  const SideFaces faces(image.frame(), blocks);
  Shape shape;
  shape.inexact_mm = (step - 1) * image.frame().spacing_mm.norm();
  for_each_side(blocks, [&](const BlockSide& side, LabelImage::Index label, LabelImage::Index next) {
    if (next == 0) faces.add(side, colour_of_label(image, label), false, shape);
  });
  return shape;
}

Shape part_near(const Shape& shape, const Vec3& place, double reach_mm) {
  constexpr double kTouching = 1e-4;  // Of the reach.
  Shape part;
  for (const ShapeFace& face : shape.faces) {
    const auto& [a, b, c] = face.corners;
    if (((a.cwiseMin(b).cwiseMin(c) - place).array() > reach_mm).any() ||
        ((place - a.cwiseMax(b).cwiseMax(c)).array() > reach_mm).any())
      continue;
    const double distance = (closest_point_on_triangle(place, a, b, c) - place).norm();
    if (distance > reach_mm) continue;
    part.faces.push_back(face);
    if (distance > kTouching * reach_mm) continue;
    part.faces.back().colour = kAtPlaceColour;
    part.faces.back().has_inner_side = false;
  }
  for (const ShapeLine& line : shape.lines)
    if ((closest_point_on_segment(place, line.from, line.to) - place).norm() <= reach_mm)
      part.lines.push_back(line);
  return part;
}

Shape part_near(const LabelImage& image, const Index3& voxel, double reach_mm, const Index3& cut) {
  const Index3 reach = (reach_mm / image.frame().spacing_mm.array()).ceil().cast<int>();
  const Blocks blocks(image, voxel - reach, voxel + reach, 1);
  const SideFaces faces(image.frame(), blocks);
  const int axis = cut.x() != 0 ? 0 : cut.y() != 0 ? 1 : 2;
  const auto is_cut_off = [&](const Index3& v) { return (v - voxel).dot(cut) > 0; };
  Shape part;
  for_each_side(blocks, [&](const BlockSide& side, LabelImage::Index label, LabelImage::Index next) {
    const Index3 own = blocks.first_voxel(side.block);
    if (is_cut_off(own)) return;
    const bool is_section =
        !cut.isZero() && own[axis] == voxel[axis] && side.axis == axis && side.direction == cut[axis];
    if (next != 0 && !is_section) return;
    const Colour colour = own == voxel ? kAtPlaceColour
                          : is_section ? colour_of_section(image, label)
                                       : colour_of_label(image, label);
    faces.add(side, colour, is_section, part);
  });
  if (image.at(voxel) == 0)  // What is wrong is that there is none.
    for (int side = 0; side < 6; ++side)
      faces.add({reach + Index3::Ones(), side / 2, side % 2 == 0 ? 1 : -1}, kAtPlaceColour, false, part);
  return part;
}

std::vector<Vec3> some_points(const Shape& shape) {
  constexpr std::size_t kEnough = 100000;
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < shape.faces.size(); i += 1 + shape.faces.size() / kEnough)
    points.insert(points.end(), shape.faces[i].corners.begin(), shape.faces[i].corners.end());
  return points;
}

std::vector<ScreenTriangle> on_screen(const Shape& shape, const Camera& camera, double line_pixels) {
  std::vector<ScreenTriangle> triangles;
  triangles.reserve(shape.faces.size() + 2 * shape.lines.size());
  for (const ShapeFace& face : shape.faces) {
    const Vec3 normal = triangle_normal(face.corners[0], face.corners[1], face.corners[2]);
    const bool is_inner = face.has_inner_side && normal.dot(camera.toward) < 0;
    ScreenTriangle triangle;
    for (std::size_t i = 0; i < 3; ++i) triangle.corners[i] = camera.project(face.corners[i]);
    triangle.normal = camera.direction(is_inner ? Vec3(-normal) : normal);
    triangle.colour = is_inner ? kInnerColour : face.colour;
    triangle.outlined = face.outlined;
    triangle.matt = face.matt;
    triangles.push_back(triangle);
  }
  for (const ShapeLine& line : shape.lines) add_line(camera, line, line_pixels, triangles);
  return triangles;
}

}  // namespace lumesh::report
