#include "lumesh/mesh/merge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "contacts.hpp"
#include "joined_points.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/core/spoken_number.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/parallel/loops.hpp"
#include "merged_names.hpp"

namespace lumesh {

void MergeOptions::describe(OptionList& list) {
  list.number("tolerance", tolerance, {.min = 0},
              "Points of the surfaces no farther apart are one, in the mesh's unit; 0: equal to the last bit")
      .by_default(fmt::format("{} of the largest coordinate, at most {} of the shortest edge",
                              spoken(detail::kUsualOfCoordinate), spoken(detail::kUsualOfEdge)));
  list.choice("equal_labels", equal_labels,
              {{"by-name", EqualLabels::kByName}, {"apart", EqualLabels::kApart}},
              "Labels of one number in several files: by-name: one material unless their names differ; "
              "apart: another material in each file");
  list.flag("allow_gaps", surfaces_match,
            "Take surfaces that nearly lie on each other, but differ, for thin gaps between the meshes");
}

namespace {

using namespace detail;

PartSurface surface_of(const MergePart& part) {
  const CellSides sides(part.mesh->view());
  naming(part.name, [&] { sides.check(); });
  PartSurface surface{part.mesh, part.name, {}, {}, {}};
  for (const CellSide& side : sides.outer()) {
    const FaceCorners face = sides.outward(side);
    surface.faces.push_back(face);
    surface.labels.push_back(sides.label(side));
    surface.points.insert(surface.points.end(), face.begin(), face.end());
  }
  parallel::sort_unique(surface.points);
  return surface;
}

void check_merge_parts(std::span<const MergePart> parts) {
  if (parts.size() < 2) throw Error(ErrorKind::kBadInput, "give at least two meshes to merge");
  const MeshInfo& first = parts.front().mesh->info;
  for (const MergePart& part : parts) {
    if (part.mesh->view().cell_count() == 0)
      throw Error(ErrorKind::kBadInput, part.name + ": has no cells; give a mesh of a volume");
    if (part.mesh->info.unit != first.unit || part.mesh->info.frame != first.frame)
      throw Error(ErrorKind::kBadInput, part.name + ": has another unit or frame than " + parts.front().name);
  }
}

void append_cells_of(const MixedMesh& part, const std::vector<std::uint32_t>& points,
                     const std::map<Label, Label>& numbers, MixedMesh& mesh) {
  const auto append = [&](const auto& cells, auto& all, const auto& labels, auto& all_labels) {
    const std::size_t first = all.size();
    all.resize(first + cells.size());
    all_labels.resize(first + cells.size());
    parallel::for_each_index(cells.size(), [&](std::size_t c) {
      for (std::size_t i = 0; i < cells[c].size(); ++i) all[first + c][i] = points[cells[c][i]];
      all_labels[first + c] = numbers.at(labels[c]);
    });
  };
  for_each_cell_list(append, part, mesh);
}

/// What all parts have one of per point, for joined points; empty where a part has none.
template <class Value>
std::vector<Value> values_of(std::span<const MergePart> parts, const JoinedPoints& joined,
                             std::vector<Value> MixedMesh::*values) {
  if (std::ranges::any_of(parts, [&](const MergePart& p) { return (p.mesh->*values).empty(); })) return {};
  std::vector<Value> all(joined.points.size());
  for (std::size_t p = parts.size(); p-- > 0;)  // The first part last: it has the last word.
    for (std::size_t v = 0; v < joined.numbers[p].size(); ++v)
      all[joined.numbers[p][v]] = (parts[p].mesh->*values)[v];
  return all;
}

/// Tetrahedra may turn over where points move to those of another part.
void check_no_turning(std::span<const MergePart> parts, const JoinedPoints& joined) {
  if (joined.farthest == 0) return;
  for (std::size_t p = 1; p < parts.size(); ++p) {
    const std::vector<Cell<4>>& tets = parts[p].mesh->tetrahedra;
    const std::vector<Vec3>& points = parts[p].mesh->points;
    const std::vector<std::uint32_t>& numbers = joined.numbers[p];
    const auto is_upright = [&](const Cell<4>& t, const auto& at) {
      return orient3d(at(t[0]), at(t[1]), at(t[2]), at(t[3])) > 0;
    };
    const std::vector<std::size_t> faults =
        parallel::collect<std::size_t>(tets.size(), [&](std::size_t i, std::vector<std::size_t>& out) {
          const bool now = is_upright(tets[i], [&](std::uint32_t v) { return joined.points[numbers[v]]; });
          if (!now && is_upright(tets[i], [&](std::uint32_t v) { return points[v]; })) out.push_back(i);
        });
    if (!faults.empty())
      throw Error(
          ErrorKind::kBadInput,
          fmt::format("{}: {} tetrahedra turn over as their points join those of another mesh, such as "
                      "that at {}; give a smaller tolerance",
                      parts[p].name, faults.size(), coordinates_text(points[tets[faults.front()][0]])));
  }
}

MergeReport report_of(const JoinedPoints& joined, std::span<const Contact> contacts) {
  MergeReport report;
  report.tolerance = joined.tolerance;
  report.farthest = joined.farthest;
  report.shared_points = static_cast<std::uint64_t>(std::ranges::count(joined.is_shared, 1));
  report.shared_faces = contacts.size();
  const std::span<const Vec3> points = joined.points;
  for (const Contact& contact : contacts) {
    const FaceCorners& face = contact.outward[0];
    report.shared_area += triangle_area(points[face[0]], points[face[1]], points[face[2]]);
    if (!is_triangle(face))
      report.shared_area += triangle_area(points[face[0]], points[face[2]], points[face[3]]);
  }
  return report;
}

/// The mesh of all parts but for the places of its points.
MixedMesh mesh_of(std::span<const MergePart> parts, const MergedLabels& labels, const JoinedPoints& joined,
                  std::span<const Contact> contacts) {
  MixedMesh mesh;
  mesh.info = parts.front().mesh->info;
  mesh.info.patches.clear();
  mesh.info.label_names = labels.names;
  for (std::size_t p = 0; p < parts.size(); ++p)
    append_cells_of(*parts[p].mesh, joined.numbers[p], labels.numbers[p], mesh);
  merge_faces(parts, labels, joined, contacts, mesh);
  mesh.metric = values_of(parts, joined, &MixedMesh::metric);
  mesh.sizes_mm = values_of(parts, joined, &MixedMesh::sizes_mm);
  return mesh;
}

}  // namespace

MergeResult merge_meshes(std::span<const MergePart> parts, const MergeOptions& options) {
  check_merge_parts(parts);
  std::vector<PartSurface> surfaces;
  for (const MergePart& part : parts) surfaces.push_back(surface_of(part));
  JoinedPoints joined = join_points(surfaces, options.tolerance);
  std::vector<Contact> contacts = find_contacts(surfaces, joined);
  if (!options.surfaces_match) check_surfaces_match(surfaces, joined, contacts);
  if (!options.allows_apart) check_parts_touch(surfaces, joined, contacts);
  check_no_turning(parts, joined);

  const MergedLabels labels = merge_labels(parts, options.equal_labels);
  for (Contact& contact : contacts)
    for (std::size_t side = 0; side < 2; ++side)
      contact.labels[side] = labels.numbers[contact.parts[side]].at(contact.labels[side]);
  MergeResult result{mesh_of(parts, labels, joined, contacts), report_of(joined, contacts)};
  result.report.renumbered = labels.renumbered;
  result.mesh.points = std::move(joined.points);
  return result;
}

}  // namespace lumesh
