#include "cell_sides.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::detail {
namespace {

template <std::size_t N>
FaceCorners corners_of(const Cell<N>& cell, std::size_t face) {
  const LocalFace& local = faces_of_cell(N)[face];
  return {cell[local[0]], cell[local[1]], cell[local[2]], cell[local[3]]};
}

template <std::size_t N>
void append_sides(std::span<const Cell<N>> cells, std::vector<CellSide>& sides) {
  const std::vector<CellSide> own =
      parallel::collect<CellSide>(cells.size(), [&](std::size_t c, std::vector<CellSide>& out) {
        for (std::size_t f = 0; f < faces_of_cell(N).size(); ++f)
          out.push_back({key_of(corners_of(cells[c], f)), static_cast<std::uint32_t>(c),
                         static_cast<std::uint16_t>(N), static_cast<std::uint16_t>(f)});
      });
  sides.insert(sides.end(), own.begin(), own.end());
}

bool is_below(const CellSide& side, const Cell<4>& key) {
  return side.key < key;
}

}  // namespace

Cell<4> key_of(const FaceCorners& face) {
  Cell<4> key = face;
  if (is_triangle(face)) key[3] = VertexId::kNone;
  std::sort(key.begin(), key.end());
  return key;
}

bool are_opposite(const FaceCorners& a, const FaceCorners& b) {
  const std::size_t count = is_triangle(a) ? 3 : 4;
  if (is_triangle(b) != is_triangle(a)) return false;
  const auto first = static_cast<std::size_t>(
      std::find(b.begin(), b.begin() + static_cast<std::ptrdiff_t>(count), a[0]) - b.begin());
  for (std::size_t i = 0; i < count; ++i)
    if (first == count || b[(first + count - i) % count] != a[i]) return false;
  return true;
}

Vec3 middle_of(std::span<const Vec3> points, const FaceCorners& face) {
  const std::size_t count = is_triangle(face) ? 3 : 4;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) sum += points[face[i]];
  return sum / static_cast<double>(count);
}

std::string place_text(const Vec3& place) {
  return fmt::format("{:.6g} {:.6g} {:.6g}", place.x(), place.y(), place.z());
}

CellSides::CellSides(const MeshView& mesh) : mesh_(mesh) {
  append_sides(mesh.tetrahedra, sides_);
  append_sides(mesh.pyramids, sides_);
  append_sides(mesh.prisms, sides_);
  append_sides(mesh.hexahedra, sides_);
  parallel::sort(sides_.begin(), sides_.end());
}

void CellSides::check() const {
  const auto starts_group = [&](std::size_t i) { return i == 0 || sides_[i].key != sides_[i - 1].key; };
  const auto is_sound = [&](std::size_t i) {
    if (i + 1 == sides_.size() || sides_[i + 1].key != sides_[i].key) return true;
    const bool third = i + 2 < sides_.size() && sides_[i + 2].key == sides_[i].key;
    return !third && are_opposite(outward(sides_[i]), outward(sides_[i + 1]));
  };
  const std::vector<std::size_t> faults =
      parallel::collect<std::size_t>(sides_.size(), [&](std::size_t i, std::vector<std::size_t>& out) {
        if (starts_group(i) && !is_sound(i)) out.push_back(i);
      });
  if (faults.empty()) return;
  const FaceCorners face = outward(sides_[faults.front()]);
  throw Error(
      ErrorKind::kBadInput,
      fmt::format("cells overlap: {} faces have more than two cells, or two on the same side, such as "
                  "that at {}; repair the mesh",
                  faults.size(), place_text(middle_of(mesh_.points, face))));
}

std::vector<CellSide> CellSides::outer() const {
  const auto differ = [&](std::size_t i, std::size_t j) { return sides_[i].key != sides_[j].key; };
  return parallel::collect<CellSide>(sides_.size(), [&](std::size_t i, std::vector<CellSide>& out) {
    if ((i == 0 || differ(i, i - 1)) && (i + 1 == sides_.size() || differ(i, i + 1)))
      out.push_back(sides_[i]);
  });
}

std::span<const CellSide> CellSides::find(const Cell<4>& key) const {
  const auto first = std::lower_bound(sides_.begin(), sides_.end(), key, is_below);
  auto last = first;
  while (last != sides_.end() && last->key == key) ++last;
  return {first, last};
}

FaceCorners CellSides::outward(const CellSide& side) const {
  switch (side.corners_of_cell) {
    case 5:
      return corners_of(mesh_.pyramids[side.cell], side.face);
    case 6:
      return corners_of(mesh_.prisms[side.cell], side.face);
    case 8:
      return corners_of(mesh_.hexahedra[side.cell], side.face);
    default:
      return corners_of(mesh_.tetrahedra[side.cell], side.face);
  }
}

Label CellSides::label(const CellSide& side) const {
  switch (side.corners_of_cell) {
    case 5:
      return mesh_.pyramid_labels[side.cell];
    case 6:
      return mesh_.prism_labels[side.cell];
    case 8:
      return mesh_.hexahedron_labels[side.cell];
    default:
      return mesh_.tetrahedron_labels[side.cell];
  }
}

}  // namespace lumesh::detail
