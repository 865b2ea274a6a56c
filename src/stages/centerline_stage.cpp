#include "lumesh/stages/centerline_stage.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/domain/patched_surface.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/mesh/edge_loops.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/surface_input.hpp"
#include "lumesh/surface/rims.hpp"
#include "surface_cuts.hpp"

namespace lumesh {
namespace {

void require_closed(const MixedMesh& surface) {
  const std::vector<surfaces::Rim> rims =
      surfaces::find_rims({surface.points, surface.triangles, surface.triangle_patches});
  if (rims.empty()) return;
  throw Error(
      ErrorKind::kBadInput,
      fmt::format("the surface is open: it ends in {}, such as that around {}; leave out {}, and its "
                  "ends are capped and its holes filled",
                  counted(rims.size(), "rim"), place_text(rims.front().centre_mm), option_name("keep_open")));
}

/// Faces of openings that share vertices, whichever patches they belong to.
struct OpenSection {
  std::set<std::uint64_t> rim;  ///< Edges of one face.
  Vec3 place_mm = Vec3::Zero();
};

std::vector<OpenSection> open_sections(const MixedMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> faces;
  DisjointSets joined(mesh.points.size());
  for_each_patch_face(mesh, [&](std::span<const std::uint32_t> face, std::int32_t p) {
    const auto patch = static_cast<std::size_t>(p);
    if (patch >= mesh.info.patches.size() || mesh.info.patches[patch].kind != PatchKind::kOpening) return;
    faces.emplace_back(face.begin(), face.end());
    for (const std::uint32_t v : face) joined.merge(face[0], v);
  });
  std::map<std::uint32_t, OpenSection> by_root;
  for (const std::vector<std::uint32_t>& face : faces) {
    OpenSection& section = by_root[joined.find(face[0])];
    toggle_edges(face, section.rim);
    section.place_mm = mesh.points[face[0]];
  }
  std::vector<OpenSection> sections;
  for (auto& [root, section] : by_root) sections.push_back(std::move(section));
  return sections;
}

/// A lumen's openings have one rim each.
void require_lumen(const MixedMesh& mesh) {
  const std::vector<OpenSection> sections = open_sections(mesh);
  const auto is_ring = [](const OpenSection& section) { return loop_count(section.rim) > 1; };
  if (sections.empty() || !std::ranges::all_of(sections, is_ring)) return;
  throw Error(
      ErrorKind::kBadInput,
      fmt::format("every opening is a ring, such as that at {}: a hollow wall, in which axes would run "
                  "round; give the surface of its lumen, its inner skin alone",
                  place_text(sections.front().place_mm)));
}

/// Flat ends of a closed surface that names no opening are openings: walls across a vessel would let axes
/// end beside them, with radii of the way to them. Nothing where the surface crosses itself.
void open_flat_ends(MixedMesh& surface) {
  const auto is_opening = [](const Patch& patch) { return patch.kind == PatchKind::kOpening; };
  if (std::ranges::any_of(surface.info.patches, is_opening)) return;
  try {
    const PatchedSurface patched(surface_view(surface));
    if (!patched.flat_ends().empty()) take_patches_of(patched, surface);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kBadInput) throw;
  }
}

/// Warnings of a surface whose axes may be wrong.
void warn_of_surface(const MixedMesh& surface, const CenterlineRequest& request, const Context& context) {
  const std::string unit = request.selection.unit.empty() ? unit_doubt(surface) : "";
  if (!unit.empty()) context.warn(request.path + ": " + unit);
  const std::vector<SelfCrossing> crossings = find_self_crossings(surface.points, surface.triangles);
  if (!crossings.empty())
    context.warn(fmt::format(
        "{}: the surface crosses or touches itself in {} of triangles, such as at {}; what it "
        "encloses is not clear there, and axes may be wrong: lumesh repair",
        request.path, counted(crossings.size(), "pair", "pairs"), place_text(crossings.front().place)));
}

/// Leaves the cells of the labels that are wanted.
void take_labels(const CenterlineRequest& request, MixedMesh& mesh) {
  if (request.selection.labels.empty()) return;
  if (mesh.view().cell_count() == 0)
    throw Error(ErrorKind::kUsage, fmt::format("{} is for images and volume meshes, and {} is a surface",
                                               option_name("labels"), request.path));
  naming(request.path, [&] { mesh = part_of(mesh, labels_called(request.selection.labels, mesh)).mesh; });
}

CenterlineMade centerline_of_mesh(const CenterlineRequest& request, Context& context) {
  CenterlineMade made;
  MixedMesh mesh =
      context.phase("read", [&] { return read_mesh_in(request.path, request.selection.unit, context); });
  warn_of_ras(mesh.info, request.path, context);
  bring_to_lps_mm(mesh);
  const bool is_surface = mesh.view().cell_count() == 0;
  take_labels(request, mesh);
  if (is_surface)
    made.closed = context.phase("close", [&] {
      std::vector<surfaces::ClosedRim> closed =
          naming(request.path, [&] { return close_open_ends(mesh, request.surface, context); });
      warn_of_filled_ends(closed, context);
      return closed;
    });
  else if (mesh.triangles.empty() && mesh.quadrilaterals.empty())
    extract_boundary(mesh);
  naming(request.path, [&] {
    if (is_surface && request.surface.keeps_open) require_closed(mesh);
    require_lumen(mesh);
  });
  if (is_surface) {
    context.phase("crossings", [&] { warn_of_surface(mesh, request, context); });
    context.phase("ends", [&] { open_flat_ends(mesh); });
  }
  made.provenance = mesh.info.provenance;
  made.labels = labels_of(mesh);
  made.lines =
      naming(request.path, [&] { return extract_centerline(mesh.view(), request.options, context); });
  return made;
}

}  // namespace

CenterlineMade find_centerline(const CenterlineRequest& request, Context& context) {
  if (is_mesh_file(request.path)) return centerline_of_mesh(request, context);
  const LabelImage image =
      context.phase("read", [&] { return read_selected_image(request.path, request.selection, context); });
  CenterlineMade made;
  made.lines = naming(request.path, [&] { return extract_centerline(image, request.options, context); });
  std::vector<bool> has_voxel(image.values().size());
  for (const LabelImage::Index voxel : image.voxels()) has_voxel[voxel] = true;
  for (std::size_t i = 1; i < has_voxel.size(); ++i)
    if (has_voxel[i]) made.labels.insert(image.values()[i]);
  return made;
}

}  // namespace lumesh
