#include "poly_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "file_fault.hpp"
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
    const Cell<3>& t = mesh_.triangles[face];
    return {t[0], t[1], t[2], t[2]};
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

/// A face under a key that does not depend on who looks at it. Without initialisers: there are millions.
struct KeyedFace {
  std::uint64_t high, low;  // the corners, ascending; a triangle's fourth is the largest number
  std::uint32_t number;     // of a side, or behind all sides that of a face of the mesh

  [[nodiscard]] bool is_same_face(const KeyedFace& other) const {
    return high == other.high && low == other.low;
  }
  friend bool operator<(const KeyedFace& a, const KeyedFace& b) {
    return std::tie(a.high, a.low, a.number) < std::tie(b.high, b.low, b.number);
  }
};

KeyedFace keyed(Cell<4> c, std::size_t number) {
  if (c[2] == c[3]) c[3] = kNone;
  std::sort(c.begin(), c.end());
  return {std::uint64_t{c[0]} << 32 | c[1], std::uint64_t{c[2]} << 32 | c[3],
          static_cast<std::uint32_t>(number)};
}

/// All sides and faces of the mesh, so sorted that those of one face stand in a run, its sides first.
class FaceRuns {
 public:
  FaceRuns(const CellSides& sides, const MeshFaces& faces)
      : sides_(sides), faces_(faces), all_(sides.size() + faces.size()) {
    parallel::for_each_index(all_.size(), [&](std::size_t i) {
      all_[i] = keyed(i < sides.size() ? sides.corners(i) : faces.corners(i - sides.size()), i);
    });
    parallel::sort(all_.begin(), all_.end());
  }

  struct Run {
    std::size_t side_count = 0;
    std::array<std::uint32_t, 2> sides = {kNone, kNone};  ///< The first two.
    std::uint32_t face = kNone;                           ///< The first face of the mesh.
  };

  [[nodiscard]] std::size_t size() const { return all_.size(); }
  [[nodiscard]] bool begins_at(std::size_t i) const { return i == 0 || !all_[i].is_same_face(all_[i - 1]); }
  [[nodiscard]] Run run_at(std::size_t begin) const {
    Run run;
    for (std::size_t i = begin; i < all_.size() && all_[i].is_same_face(all_[begin]); ++i) {
      const std::uint32_t number = all_[i].number;
      if (number >= sides_.size()) {
        run.face = number - static_cast<std::uint32_t>(sides_.size());
        break;
      }
      if (run.side_count < 2) run.sides[run.side_count] = number;
      ++run.side_count;
    }
    return run;
  }

  /// What polyMesh cannot say is refused before anything is made of it.
  void check(const std::filesystem::path& path) const {
    const auto is_bad = [&](const Run& run) {
      return run.side_count == 0 || run.side_count > 2 ||
             (run.side_count == 2 && sides_.cell_of(run.sides[0]) == sides_.cell_of(run.sides[1]));
    };
    const std::size_t bad = parallel::reduce_blocks(
        all_.size(), 4096, all_.size(),
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i)
            if (begins_at(i) && is_bad(run_at(i))) return i;
          return all_.size();
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (bad < all_.size()) refuse(path, run_at(bad));
  }

 private:
  [[noreturn]] void refuse(const std::filesystem::path& path, const Run& run) const {
    const Cell<4> c = run.side_count == 0 ? faces_.corners(run.face) : sides_.corners(run.sides[0]);
    const std::string corners =
        fmt::format("{} {} {}{}", c[0], c[1], c[2], c[2] == c[3] ? "" : fmt::format(" {}", c[3]));
    if (run.side_count == 0)
      fail(path,
           fmt::format("OpenFOAM knows no boundary face without a cell, such as that with the points {} "
                       "(counted from 0); leave it out",
                       corners));
    if (run.side_count == 2)
      fail(path, fmt::format("two sides of one cell are the face with the points {} (counted from 0); repair "
                             "the mesh first",
                             corners));
    fail(path,
         fmt::format("{} cells share the face with the points {} (counted from 0), two at most may; repair "
                     "the mesh first",
                     run.side_count, corners));
  }

  const CellSides& sides_;
  const MeshFaces& faces_;
  UninitialisedVector<KeyedFace> all_;
};

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

SideLinks link_sides(const std::filesystem::path& path, const CellSides& sides, const MeshFaces& faces) {
  const FaceRuns runs(sides, faces);
  runs.check(path);
  SideLinks links;
  links.partners.resize(sides.size());
  // Every side is in one run: no two threads write the same partner.
  links.named = parallel::collect<NamedSide>(runs.size(), [&](std::size_t i, std::vector<NamedSide>& out) {
    if (!runs.begins_at(i)) return;
    const FaceRuns::Run run = runs.run_at(i);
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
  const auto at = static_cast<std::size_t>(std::find(b.begin(), b.end(), a[0]) - b.begin());
  return b[(at + 1) % corners] == a[1];
}

class PolyMeshBuilder {
 public:
  PolyMeshBuilder(const std::filesystem::path& path, const MeshView& mesh)
      : faces_(mesh), poly_{CellSides(mesh), {}, {}, {}, {}} {
    const std::size_t records = poly_.sides.size() + faces_.size();
    if (poly_.sides.size() == 0) fail(path, "the mesh has no cells to write; choose .vtp or .stl");
    if (records > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      fail(path, "too many cells for OpenFOAM's 32-bit labels; choose .vtu");
    links_ = link_sides(path, poly_.sides, faces_);
  }

  PolyMesh build() {
    add_internal_faces();
    add_patches();
    add_zones();
    return std::move(poly_);
  }

 private:
  void add_internal_faces() {
    const CellSides& sides = poly_.sides;
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
    std::sort(owned.others.begin(), owned.others.end());
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

  /// Of the internal face with this side of its owner.
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
