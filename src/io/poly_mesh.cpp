#include "poly_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "file_fault.hpp"
#include "lumesh/mesh/cell_sides.hpp"
#include "lumesh/parallel/key_table.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::io {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

/// The boundary and interface faces of a mesh: triangles, then quadrilaterals.
class MeshFaces {
 public:
  explicit MeshFaces(const MeshView& mesh) : mesh_(mesh) {}
  [[nodiscard]] std::size_t size() const { return mesh_.triangles.size() + mesh_.quadrilaterals.size(); }
  [[nodiscard]] Cell<4> corners(std::size_t face) const {
    if (face >= mesh_.triangles.size()) return mesh_.quadrilaterals[face - mesh_.triangles.size()];
    return face_of(mesh_.triangles[face]);
  }
  [[nodiscard]] std::int32_t patch(std::uint32_t face) const {
    if (face == kNone) return kNoPatch;
    const std::int32_t patch = face < mesh_.triangles.size()
                                   ? mesh_.triangle_patches[face]
                                   : mesh_.quadrilateral_patches[face - mesh_.triangles.size()];
    return patch < 0 ? kNoPatch : patch;
  }

 private:
  const MeshView& mesh_;
};

/// Sides and faces of the mesh, each under a key that does not depend on who looks at it.
struct KeyedFace {
  Cell<4> key;           // As key_of().
  std::uint32_t number;  // Of a side, or behind all sides that of a face of the mesh.
  auto operator<=>(const KeyedFace&) const = default;
};

/// Sides and faces of the mesh that have the same corners.
struct FaceRun {
  std::size_t side_count = 0;
  std::array<std::uint32_t, 2> sides = {kNone, kNone};  ///< The first two.
  std::uint32_t face = kNone;                           ///< The first face of the mesh.

  FaceRun(std::span<const KeyedFace> run, std::size_t all_sides) {
    for (const KeyedFace& one : run) {
      if (one.number >= all_sides) {
        face = one.number - static_cast<std::uint32_t>(all_sides);
        break;
      }
      if (side_count < 2) sides[side_count] = one.number;
      ++side_count;
    }
  }
};

/// Fault of faces that polyMesh cannot hold.
std::string fault_of(const FaceRun& run, const SideNumbers& sides, const MeshFaces& faces) {
  const bool is_folded = run.side_count == 2 && sides.cell_of(run.sides[0]) == sides.cell_of(run.sides[1]);
  if (run.side_count > 0 && run.side_count <= 2 && !is_folded) return {};
  const Cell<4> c = run.side_count == 0 ? faces.corners(run.face) : sides.corners(run.sides[0]);
  const std::string corners =
      fmt::format("{} {} {}{}", c[0], c[1], c[2], c[2] == c[3] ? "" : fmt::format(" {}", c[3]));
  if (run.side_count == 0)
    return fmt::format(
        "OpenFOAM knows no boundary face without a cell, such as that with the points {} (counted from 0); "
        "leave it out",
        corners);
  if (is_folded)
    return fmt::format(
        "two sides of one cell are the face with the points {} (counted from 0); repair the mesh first",
        corners);
  return fmt::format(
      "{} cells share the face with the points {} (counted from 0), two at most may; repair the mesh first",
      run.side_count, corners);
}

/// A side on the outside, or the owner's side of an internal face that the mesh names.
struct NamedSide {
  std::uint32_t side = 0;
  std::uint32_t face = kNone;  ///< Of the mesh.
};

/// How sides meet.
struct SideLinks {
  UninitialisedVector<std::uint32_t> partners;  ///< The other side of every side, or kNone.
  std::vector<NamedSide> named;
};

SideLinks link_sides(const std::filesystem::path& path, const SideNumbers& sides, const MeshFaces& faces,
                     std::size_t points) {
  const parallel::KeyTable<KeyedFace> table(
      sides.size() + faces.size(), points,
      [&](std::size_t i, const auto& take) {
        const FaceCorners corners = i < sides.size() ? sides.corners(i) : faces.corners(i - sides.size());
        take(KeyedFace{key_of(corners), static_cast<std::uint32_t>(i)});
      },
      [](const KeyedFace& face) { return face.key[0]; });
  const auto same = [](const KeyedFace& a, const KeyedFace& b) { return a.key == b.key; };
  const auto faults = table.collect_runs<std::string>(
      same, [&](std::span<const KeyedFace> run, std::vector<std::string>& out) {
        if (std::string fault = fault_of({run, sides.size()}, sides, faces); !fault.empty())
          out.push_back(std::move(fault));
      });
  if (!faults.empty()) fail(path, faults.front());
  SideLinks links;
  links.partners.resize(sides.size());
  // Every side is in one run: no two threads write the same partner.
  links.named =
      table.collect_runs<NamedSide>(same, [&](std::span<const KeyedFace> keyed, std::vector<NamedSide>& out) {
        const FaceRun run(keyed, sides.size());
        const auto [a, b] = run.sides;
        links.partners[a] = b;
        if (b != kNone) links.partners[b] = a;
        if (b == kNone || run.face != kNone) out.push_back({a, run.face});
      });
  return links;
}

/// Whether two cycles of the same corners go the same way round.
bool is_same_sense(const Cell<4>& a, const Cell<4>& b) {
  const std::size_t corners = a[2] == a[3] ? 3 : 4;
  const auto at = static_cast<std::size_t>(std::ranges::find(b, a[0]) - b.begin());
  return b[(at + 1) % corners] == a[1];
}

class PolyMeshBuilder {
 public:
  PolyMeshBuilder(const std::filesystem::path& path, const MeshView& mesh)
      : faces_(mesh), poly_{SideNumbers(mesh), {}, {}, {}, {}} {
    const std::size_t records = poly_.sides.size() + faces_.size();
    if (poly_.sides.size() == 0) fail(path, "the mesh has no cells to write; choose .vtp or .stl");
    if (records > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      fail(path, "too many cells for OpenFOAM's 32-bit labels; choose .vtu");
    links_ = link_sides(path, poly_.sides, faces_, mesh.points.size());
  }

  PolyMesh build() {
    add_internal_faces();
    add_patches();
    add_zones();
    return std::move(poly_);
  }

 private:
  void add_internal_faces() {
    const SideNumbers& sides = poly_.sides;
    first_face_.assign(sides.cell_count() + 1, 0);
    parallel::for_each_index(sides.cell_count(), [&](std::size_t c) {
      first_face_[c + 1] = static_cast<std::uint32_t>(owned_by(c).count);
    });
    std::partial_sum(first_face_.begin(), first_face_.end(), first_face_.begin());
    poly_.faces.resize(first_face_.back());
    poly_.neighbours.resize(first_face_.back());
    parallel::for_each_index(sides.cell_count(), [&](std::size_t c) {
      const Owned owned = owned_by(c);
      for (std::size_t i = 0; i < owned.count; ++i) {
        poly_.faces[first_face_[c] + i] = links_.partners[owned.others[i]];
        poly_.neighbours[first_face_[c] + i] = sides.cell_of(owned.others[i]);
      }
    });
  }

  /// The far sides of the internal faces that a cell owns, ascending, and so the neighbours too.
  struct Owned {
    std::array<std::uint32_t, 6> others = {kNone, kNone, kNone, kNone, kNone, kNone};
    std::size_t count = 0;
  };
  [[nodiscard]] Owned owned_by(std::size_t cell) const {
    Owned owned;
    for (std::size_t s = poly_.sides.first_of(cell); s < poly_.sides.first_of(cell + 1); ++s)
      if (const std::uint32_t other = links_.partners[s]; other != kNone && other > s)
        owned.others[owned.count++] = other;
    std::ranges::sort(owned.others);
    return owned;
  }

  struct PatchSide {
    std::int32_t patch = kNoPatch;
    std::uint32_t side = 0;
    auto operator<=>(const PatchSide&) const = default;
  };

  void add_patches() {
    std::vector<PatchSide> outside;
    for (const NamedSide& named : links_.named)
      if (links_.partners[named.side] == kNone) outside.push_back({faces_.patch(named.face), named.side});
    parallel::sort(outside.begin(), outside.end());
    poly_.faces.reserve(poly_.faces.size() + outside.size());
    for (const auto& [patch, side] : outside) {
      if (poly_.patches.empty() || poly_.patches.back().patch != patch)
        poly_.patches.push_back({patch, poly_.faces.size(), 0});
      ++poly_.patches.back().count;
      poly_.faces.push_back(side);
    }
  }

  struct ZoneFace {
    std::int32_t patch = kNoPatch;
    std::uint32_t number = 0;
    std::uint8_t is_reversed = 0;
    auto operator<=>(const ZoneFace&) const = default;
  };

  void add_zones() {
    std::vector<ZoneFace> inside;
    for (const NamedSide& named : links_.named) {
      const std::int32_t patch = faces_.patch(named.face);
      if (links_.partners[named.side] == kNone || patch == kNoPatch) continue;
      const bool same = is_same_sense(faces_.corners(named.face), poly_.sides.corners(named.side));
      inside.push_back({patch, number_of(named.side), static_cast<std::uint8_t>(same ? 0 : 1)});
    }
    parallel::sort(inside.begin(), inside.end());
    for (const ZoneFace& face : inside) {
      if (poly_.zones.empty() || poly_.zones.back().patch != face.patch)
        poly_.zones.push_back({face.patch, {}, {}});
      poly_.zones.back().faces.push_back(face.number);
      poly_.zones.back().reversed.push_back(face.is_reversed);
    }
  }

  /// Number of the internal face with this side of its owner.
  [[nodiscard]] std::uint32_t number_of(std::uint32_t side) const {
    std::uint32_t face = first_face_[poly_.sides.cell_of(side)];
    while (poly_.faces[face] != side) ++face;
    return face;
  }

  MeshFaces faces_;
  PolyMesh poly_;
  SideLinks links_;
  std::vector<std::uint32_t> first_face_;  ///< Of the internal faces that each cell owns.
};

}  // namespace

PolyMesh build_poly_mesh(const std::filesystem::path& path, const MeshView& mesh) {
  return PolyMeshBuilder(path, mesh).build();
}

}  // namespace lumesh::io
