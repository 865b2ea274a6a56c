// Construction of a TetMesh from plain arrays: check, copy, link, patch, classify.

#include <algorithm>
#include <limits>
#include <string>

#include "lumesh/core/error.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/mesh/mesh_walks.hpp"
#include "lumesh/mesh/patch_naming.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/mesh/validate.hpp"
#include "lumesh/parallel/key_table.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

constexpr std::size_t kBlock = 16384;
constexpr std::size_t kNothing = std::numeric_limits<std::size_t>::max();

/// Lowest index below `count` that `fails`, or kNothing.
template <class Fails>
std::size_t first_failing(std::size_t count, const Fails& fails) {
  return parallel::reduce_blocks(
      count, kBlock, kNothing,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
          if (fails(i)) return i;
        return kNothing;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

[[noreturn]] void throw_bad_mesh(const std::string& message) {
  throw Error(ErrorKind::kBadInput, "mesh: " + message);
}

void check_input(std::span<const Vec3> points, std::span<const Cell<4>> tets, std::span<const Label> labels) {
  if (labels.size() != tets.size())
    throw_bad_mesh(std::to_string(tets.size()) + " tetrahedra but " + std::to_string(labels.size()) +
                   " labels");
  if (points.size() > TetMesh::kMaxVertices || tets.size() > TetMesh::kMaxTets)
    throw_bad_mesh("too large: at most 2^30 vertices and 10^9 tetrahedra; choose a coarser mesh");
  const std::size_t bad_point =
      first_failing(points.size(), [&](std::size_t i) { return !points[i].allFinite(); });
  if (bad_point != kNothing) throw_bad_mesh("vertex " + std::to_string(bad_point) + kNotFinite);
  const std::size_t bad_label = first_failing(labels.size(), [&](std::size_t t) { return labels[t] < 0; });
  if (bad_label != kNothing)
    throw_bad_mesh("tetrahedron " + std::to_string(bad_label) + " has a negative label");
  const auto out_of_range = [&](std::size_t t) {
    return std::ranges::any_of(tets[t], [&](std::uint32_t v) { return v >= points.size(); });
  };
  const std::size_t bad_index = first_failing(tets.size(), out_of_range);
  if (bad_index != kNothing)
    throw_bad_mesh("tetrahedron " + std::to_string(bad_index) + " " + corners_text(tets[bad_index]) +
                   " names a vertex that is not there; there are " + std::to_string(points.size()));
  const std::size_t inverted = first_failing(tets.size(), [&](std::size_t t) {
    const auto& [a, b, c, d] = tets[t];
    return orient3d(points[a], points[b], points[c], points[d]) <= 0;
  });
  if (inverted != kNothing)
    throw_bad_mesh("tetrahedron " + std::to_string(inverted) + " " + corners_text(tets[inverted]) +
                   " is inverted or flat; exchange two of its vertices or repair the mesh");
}

/// A face of a tetrahedron.
struct TetFace {
  Cell<3> corners;    // Ascending.
  std::uint32_t ref;  // tetrahedron << 2 | face
  auto operator<=>(const TetFace&) const = default;
};

/// A table of patches, sorted for search, that remembers which of its triangles were asked for.
class PatchSearch {
 public:
  explicit PatchSearch(const PatchTable& table)
      : entries_(table.triangles.size()), used_(table.triangles.size(), 0) {
    if (table.patches.size() != table.triangles.size())
      throw_bad_mesh(std::to_string(table.triangles.size()) + " boundary triangles but " +
                     std::to_string(table.patches.size()) + " patches");
    parallel::for_each_index(entries_.size(), [&](std::size_t i) {
      entries_[i] = {sorted_corners(table.triangles[i]), table.patches[i], static_cast<std::uint32_t>(i)};
    });
    parallel::sort(entries_.begin(), entries_.end());
    for (std::size_t i = 1; i < entries_.size(); ++i)
      if (entries_[i].corners == entries_[i - 1].corners && entries_[i].patch != entries_[i - 1].patch)
        throw_bad_mesh("boundary triangle " + corners_text(entries_[i].corners) +
                       " stands twice with different patches");
  }

  /// Patch of a face, or -1. Different faces may be asked for at the same time.
  [[nodiscard]] std::int32_t patch_of(const Cell<3>& corners) {
    const Cell<3> key = sorted_corners(corners);
    auto entry = std::ranges::lower_bound(entries_, key, {}, &Entry::corners);
    if (entry == entries_.end() || entry->corners != key) return -1;
    const std::int32_t patch = entry->patch;
    for (; entry != entries_.end() && entry->corners == key; ++entry)
      used_[static_cast<std::size_t>(entry - entries_.begin())] = 1;
    return patch;
  }

  void require_all_used() const {
    for (std::size_t i = 0; i < entries_.size(); ++i)
      if (used_[i] == 0)
        throw_bad_mesh("boundary triangle " + std::to_string(entries_[i].index) + " " +
                       corners_text(entries_[i].corners) +
                       " is neither on the outside of the tetrahedra nor between two labels; remove it");
  }

 private:
  struct Entry {
    Cell<3> corners;
    std::int32_t patch;
    std::uint32_t index;
    auto operator<=>(const Entry&) const = default;
  };
  std::vector<Entry> entries_;
  std::vector<char> used_;
};

}  // namespace

struct TetMesh::Assembly {
  /// A face on the outside or between labels, named by the tetrahedron of the lower label.
  struct OpenFace {
    TetId tet;
    int face;
    Label inside, outside;
    std::int32_t patch = -1;
  };

  TetMesh mesh;
  std::vector<OpenFace> open_faces;

  Assembly(std::span<const Vec3> points, std::span<const Cell<4>> tets, std::span<const Label> labels,
           MeshInfo info) {
    check_input(points, tets, labels);
    const auto vertex_count = static_cast<std::uint32_t>(points.size());
    const auto tet_count = static_cast<std::uint32_t>(tets.size());
    mesh.commit_vertices(vertex_count);
    mesh.commit_tets(tet_count);
    mesh.vertex_pool_ = parallel::SlotPool(vertex_count, 1, 1);
    mesh.tet_pool_ = parallel::SlotPool(tet_count, 1, 1);
    mesh.info_ = std::move(info);
    parallel::for_each_index(vertex_count, [&](std::size_t v) {
      mesh.points_[v] = points[v];
      mesh.incident_[v] = TetId();
      mesh.dimensions_[v] = VertexDimension::kVolume;
    });
    parallel::for_each_index(tet_count, [&](std::size_t t) {
      mesh.tets_[t] = tets[t];
      mesh.labels_[t] = labels[t];
      mesh.links_[t] = {};
    });
    // The lowest tetrahedron of each vertex: backwards, the last writer wins.
    for (std::uint32_t t = tet_count; t-- > 0;)
      for (const std::uint32_t v : tets[t]) mesh.incident_[v] = TetId(t);
    link_faces();
    find_open_faces();
  }

  void link_faces() {
    const parallel::KeyTable<TetFace> faces(
        mesh.tet_slots(), mesh.vertex_slots(),
        [&](std::size_t t, const auto& take) {
          for (int f = 0; f < 4; ++f)
            take(TetFace{sorted_corners(mesh.face_corners(TetId(static_cast<std::uint32_t>(t)), f)),
                         static_cast<std::uint32_t>(t << 2 | static_cast<std::size_t>(f))});
        },
        [](const TetFace& face) { return face.corners[0]; });
    const auto same = [](const TetFace& a, const TetFace& b) { return a.corners == b.corners; };
    const auto problems = faces.collect_runs<std::string>(same, [&](std::span<const TetFace> run,
                                                                    std::vector<std::string>& out) {
      if (run.size() == 1) return;
      const TetId t(run[0].ref >> 2), u(run[1].ref >> 2);
      const int f = static_cast<int>(run[0].ref & 3u), g = static_cast<int>(run[1].ref & 3u);
      if (run.size() > 2)
        out.push_back("face " + corners_text(run[0].corners) + " belongs to " + std::to_string(run.size()) +
                      " tetrahedra, such as " + std::to_string(t.value) + " and " + std::to_string(u.value));
      else if (!are_opposite_sides(mesh.face_corners(t, f), mesh.face_corners(u, g)))
        out.push_back("tetrahedra " + std::to_string(t.value) + " and " + std::to_string(u.value) +
                      " lie on the same side of their common face " + corners_text(run[0].corners));
      mesh.set_link(t, f, FaceLink::to(u, g));
      mesh.set_link(u, g, FaceLink::to(t, f));
    });
    if (!problems.empty()) throw_bad_mesh(problems.front());
  }

  void find_open_faces() {
    open_faces = collect_from_tets<OpenFace>(mesh, [&](TetId t, std::vector<OpenFace>& out) {
      const Label mine = mesh.label(t);
      for (int f = 0; f < 4; ++f) {
        const FaceLink behind = mesh.link(t, f);
        if (behind.is_boundary())
          out.push_back({t, f, mine, kBackground});
        else if (mine < mesh.label(behind.tet()))
          out.push_back({t, f, mine, mesh.label(behind.tet())});
      }
    });
  }

  /// Asks `choose` for every open face and stores the answers.
  void assign_patches(const PatchChooser& choose) {
    parallel::for_each_index(open_faces.size(), [&](std::size_t i) {
      OpenFace& open = open_faces[i];
      open.patch = choose(open.inside, open.outside, mesh.face_corners(open.tet, open.face));
    });
    const std::size_t patches = std::min<std::size_t>(mesh.info_.patches.size(), kMaxPatches);
    const auto unknown = [&](std::size_t i) {
      return open_faces[i].patch < 0 || static_cast<std::size_t>(open_faces[i].patch) >= patches;
    };
    const std::size_t missing = first_failing(open_faces.size(), unknown);
    if (missing != kNothing) {
      const OpenFace& open = open_faces[missing];
      const std::string face = "face " + corners_text(mesh.face_corners(open.tet, open.face)) +
                               " of tetrahedron " + std::to_string(open.tet.value);
      if (open.patch < 0)
        throw_bad_mesh(face + " is on the boundary but has no patch; add a boundary triangle there");
      throw_bad_mesh(face + " has patch " + std::to_string(open.patch) + " but there are " +
                     std::to_string(patches));
    }
    const auto is_interface = [&](const OpenFace& open) {
      return !mesh.link(open.tet, open.face).is_boundary();
    };
    if (std::ranges::any_of(open_faces, is_interface)) mesh.enable_interfaces();
    parallel::for_each_index(open_faces.size(), [&](std::size_t i) {
      const OpenFace& open = open_faces[i];
      const PatchId patch(static_cast<std::uint32_t>(open.patch));
      const FaceLink behind = mesh.link(open.tet, open.face);
      if (behind.is_boundary()) {
        mesh.set_link(open.tet, open.face, FaceLink::boundary(patch));
      } else {
        mesh.set_interface_patch(open.tet, open.face, patch);
        mesh.set_interface_patch(behind.tet(), behind.face(), patch);
      }
    });
  }

  /// Makes one patch per pair of labels that meet and returns the chooser for them.
  [[nodiscard]] PatchChooser make_patches_by_labels() {
    // Labels ascend on an interface, so that its outside is never the background and the pair tells it from a
    // wall.
    using Pair = std::array<Label, 2>;  // Outside, inside: walls come first.
    std::vector<Pair> pairs(open_faces.size());
    std::transform(open_faces.begin(), open_faces.end(), pairs.begin(), [](const OpenFace& open) {
      return Pair{open.outside, open.inside};
    });
    parallel::sort_unique(pairs);
    const auto walls = std::ranges::count_if(pairs, [](const Pair& p) { return p[0] == kBackground; });
    const PatchNaming naming(mesh.info_.label_names);
    mesh.info_.patches.clear();
    for (const auto& [outside, inside] : pairs) {
      const bool wall = outside == kBackground;
      mesh.info_.patches.push_back({wall ? naming.wall(inside, walls == 1) : naming.between(inside, outside),
                                    wall ? PatchKind::kWall : PatchKind::kInterface,
                                    {inside, outside}});
    }
    return [pairs = std::move(pairs)](Label inside, Label outside, const Cell<3>&) {
      const Pair key = {outside, inside};
      return static_cast<std::int32_t>(rank_in(pairs, key));
    };
  }

  void classify_vertices() {
    std::vector<Cell<3>> triangles(open_faces.size());
    std::vector<std::int32_t> patches(open_faces.size());
    parallel::for_each_index(open_faces.size(), [&](std::size_t i) {
      triangles[i] = mesh.face_corners(open_faces[i].tet, open_faces[i].face);
      patches[i] = open_faces[i].patch;
    });
    mesh.classify_vertices({triangles, patches});
  }
};

void TetMesh::classify_vertices(const PatchTable& faces) {
  parallel::for_each_index(vertex_slots(), [&](std::size_t v) {
    if (dimensions_[v] != VertexDimension::kFreed) dimensions_[v] = VertexDimension::kVolume;
  });
  std::vector<std::uint32_t> ends;  // Both ends of every feature edge.
  for_each_edge(sorted_sides(faces.triangles), [&](std::span<const TriangleSide> edge) {
    const auto patch_of = [&](std::size_t i) { return faces.patches[edge[i].triangle]; };
    const std::array<std::uint32_t, 2> both = {edge[0].low, edge[0].high};
    for (const std::uint32_t v : both) dimensions_[v] = VertexDimension::kSurface;
    if (edge.size() != 2 || patch_of(0) != patch_of(1)) ends.insert(ends.end(), both.begin(), both.end());
  });
  parallel::sort(ends.begin(), ends.end());
  parallel::for_each_run(ends, std::equal_to<>(), [&](std::span<const std::uint32_t> run) {
    dimensions_[run[0]] = run.size() == 2 ? VertexDimension::kCurve : VertexDimension::kCorner;
  });
}

TetMesh TetMesh::build(std::span<const Vec3> points, std::span<const Cell<4>> tets,
                       std::span<const Label> labels, const PatchTable& patches, MeshInfo info) {
  PatchSearch search(patches);
  Assembly assembly(points, tets, labels, std::move(info));
  assembly.assign_patches([&](Label, Label, const Cell<3>& corners) { return search.patch_of(corners); });
  search.require_all_used();
  assembly.classify_vertices();
  return std::move(assembly.mesh);
}

TetMesh TetMesh::build(std::span<const Vec3> points, std::span<const Cell<4>> tets,
                       std::span<const Label> labels, const PatchChooser& patches, MeshInfo info) {
  Assembly assembly(points, tets, labels, std::move(info));
  assembly.assign_patches(patches);
  assembly.classify_vertices();
  return std::move(assembly.mesh);
}

TetMesh TetMesh::build(std::span<const Vec3> points, std::span<const Cell<4>> tets,
                       std::span<const Label> labels, MeshInfo info) {
  Assembly assembly(points, tets, labels, std::move(info));
  assembly.assign_patches(assembly.make_patches_by_labels());
  assembly.classify_vertices();
  return std::move(assembly.mesh);
}

TetMesh TetMesh::build(const MeshView& view) {
  if (view.cell_count() != view.tetrahedra.size() || !view.quadrilaterals.empty())
    throw_bad_mesh("has cells other than tetrahedra; this step needs tetrahedra only");
  MeshInfo info = view.info != nullptr ? *view.info : MeshInfo();
  if (view.triangles.empty())
    return build(view.points, view.tetrahedra, view.tetrahedron_labels, std::move(info));
  return build(view.points, view.tetrahedra, view.tetrahedron_labels,
               PatchTable{view.triangles, view.triangle_patches}, std::move(info));
}

}  // namespace lumesh
