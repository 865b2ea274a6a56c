#include <fmt/core.h>

#include <algorithm>
#include <unordered_map>

#include "lumesh/core/place_text.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/surface/edges.hpp"
#include "lumesh/surface/rims.hpp"
#include "opening_names.hpp"

namespace lumesh {
namespace {

/// Figures of one patch of openings in a mesh.
struct OpeningPatch {
  AreaSum sum;
  std::vector<Vec3> centres_mm;  // Of its triangles.
  std::vector<Cell<3>> triangles;
  static constexpr double kFlat = 0.99;

  [[nodiscard]] bool is_flat() const { return sum.normal.norm() > kFlat * sum.area; }
  void add(const Cell<3>& corners, std::span<const Vec3> points) {
    const Vec3 &a = points[corners[0]], &b = points[corners[1]], &c = points[corners[2]];
    sum.add(a, b, c);
    centres_mm.push_back(triangle_centre(a, b, c));
    triangles.push_back(corners);
  }
};

std::vector<OpeningPatch> opening_patches(const MeshView& mesh) {
  std::vector<OpeningPatch> patches(mesh.info->patches.size());
  const auto patch_at = [&](std::int32_t p) -> OpeningPatch* {
    const auto at = static_cast<std::size_t>(p);
    return at < patches.size() && is_plane(mesh.info->patches[at].kind) ? &patches[at] : nullptr;
  };
  for_each_patch_triangle(mesh, [&](const Cell<3>& t, std::int32_t p) {
    if (OpeningPatch* patch = patch_at(p)) patch->add(t, mesh.points);
  });
  return patches;
}

/// Triangles of a mesh with points of their own.
TriangleMesh as_surface(std::span<const Vec3> points, std::span<const Cell<3>> triangles) {
  TriangleMesh surface;
  std::unordered_map<std::uint32_t, std::uint32_t> number;
  for (Cell<3> corners : triangles) {
    for (std::uint32_t& v : corners) {
      const auto [at, is_new] = number.try_emplace(v, static_cast<std::uint32_t>(surface.points.size()));
      if (is_new) surface.points.push_back(points[v]);
      v = at->second;
    }
    surface.triangles.push_back(corners);
  }
  return surface;
}

OpeningShape shape_of(TriangleMesh surface, const Opening& opening) {
  OpeningShape shape;
  shape.parts = surfaces::turn_alike(surface).count;
  const std::vector<surfaces::Rim> rims = surfaces::find_rims(surface);
  shape.rims = rims.size();
  double length_mm = 0;
  std::size_t edges = 0;
  for (const surfaces::Rim& rim : rims) {
    const std::size_t count = rim.vertices.size();
    if (shape.edges == 0 || count < shape.edges) shape.edges = count;
    edges += count;
    length_mm += static_cast<double>(count) * rim.mean_edge_mm;
  }
  if (edges > 0) shape.edge_mm = length_mm / static_cast<double>(edges);
  for (const Vec3& x : surface.points) {
    const double off_mm = std::abs(opening.normal.dot(x - opening.centre_mm));
    if (off_mm > shape.off_mm) {
      shape.off_mm = off_mm;
      shape.off_at_mm = x;
    }
  }
  return shape;
}

std::string text_of_area(const OpeningInMesh& o) {
  return fmt::format("{} has {:.4g} mm², {:.1f} % {} than the input's {:.4g} mm² at {}", o.patches,
                     o.mesh_area_mm2, std::abs(o.change_percent()), o.change_percent() < 0 ? "less" : "more",
                     o.opening.area_mm2, place_text(o.opening.centre_mm));
}

/// Text of what is wrong with an opening that is_wrong().
std::string wrong_of(const OpeningInMesh& o) {
  if (o.patches.empty())
    return fmt::format("{}, an opening of {:.4g} mm² at {}, is missing in the mesh", o.opening.name,
                       o.opening.area_mm2, place_text(o.opening.centre_mm));
  const bool is_off = std::abs(o.change_percent()) > kWrongOpeningPercent;
  if (o.shape.parts > 1)
    return fmt::format("{}in {} parts",
                       is_off ? text_of_area(o) + ", "
                              : fmt::format("{} at {} is ", o.patches, place_text(o.opening.centre_mm)),
                       o.shape.parts);
  return text_of_area(o);
}

std::vector<std::string> flaws_of(const OpeningInMesh& o) {
  constexpr double kDoubtfulPercent = 2, kThin = 2;  // From so many voxels in radius on.
  constexpr double kOff = 1e-2, kOffEnd = 1e-6;      // Voxels; of the radius of a surface's end.
  constexpr double kAsBent = 1.1;                    // An end that is bent itself may be as much so.
  constexpr std::size_t kMinEdges = 8;
  std::vector<std::string> lines;
  const Opening& opening = o.opening;
  const double change = std::abs(o.change_percent());
  if (change > kDoubtfulPercent && change <= kWrongOpeningPercent &&
      opening.radius_mm() >= kThin * opening.voxel_mm)
    lines.push_back(text_of_area(o));
  const double flat_mm = opening.is_of_surface ? kAsBent * opening.off_mm + kOffEnd * opening.radius_mm()
                                               : kOff * opening.voxel_mm;
  if ((opening.is_of_surface || opening.squares) && o.shape.off_mm > flat_mm)
    lines.push_back(fmt::format("{} is not flat: {} is {:.2g} mm off its plane", o.patches,
                                place_text(o.shape.off_at_mm), o.shape.off_mm));
  // Ends of surfaces are as round as these are.
  if (opening.is_of_surface || !opening.squares) return lines;
  const double voxel_mm2 = opening.voxel_mm * opening.voxel_mm;
  const std::vector<double> holes_mm2 = opening.squares->hole_areas_mm2();
  const std::size_t most = 1 + holes_mm2.size();
  const auto least = static_cast<std::size_t>(
      1 + std::ranges::count_if(holes_mm2, [&](double mm2) { return mm2 > voxel_mm2; }));
  if (o.shape.parts == 1 && (o.shape.rims < least || o.shape.rims > most))
    lines.push_back(fmt::format("{} at {} has {} rims, not {}", o.patches, place_text(opening.centre_mm),
                                o.shape.rims, least));
  if (o.shape.edges < kMinEdges)
    lines.push_back(fmt::format("{} at {} has {} edges around; a smaller `edge_length` makes more", o.patches,
                                place_text(opening.centre_mm), o.shape.edges));
  return lines;
}

}  // namespace

OpeningsCompared compare_openings(const MeshView& mesh, std::span<const Opening> openings) {
  OpeningsCompared result;
  for (const Opening& opening : openings) result.openings.push_back({opening, "", 0, {}});
  std::vector<std::vector<Cell<3>>> triangles(openings.size());
  const std::vector<OpeningPatch> patches = opening_patches(mesh);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (!(patches[p].sum.area > 0)) continue;
    const Patch& patch = mesh.info->patches[p];
    const bool is_opening = patch.kind == PatchKind::kOpening;
    if (!is_opening && !patches[p].is_flat()) continue;  // What users call symmetry need not be a plane.
    const std::size_t at = opening_of_places(openings, patch.labels[0], patches[p].centres_mm,
                                             patches[p].sum.normal.normalized());
    if (at < openings.size()) {
      OpeningInMesh& found = result.openings[at];
      found.patches += (found.patches.empty() ? "" : " + ") + patch.name;
      found.mesh_area_mm2 += patches[p].sum.area;
      triangles[at].insert(triangles[at].end(), patches[p].triangles.begin(), patches[p].triangles.end());
    } else if (!is_opening) {
      continue;
    } else if (openings.empty() || (!openings[0].is_of_surface && has_label(openings, patch.labels[0]))) {
      result.others.push_back(
          patch.name);  // What grows on the object, as layers do, has openings of its own.
    }
  }
  for (std::size_t o = 0; o < openings.size(); ++o)
    result.openings[o].shape = shape_of(as_surface(mesh.points, triangles[o]), openings[o]);
  return result;
}

bool is_coarse(const OpeningInMesh& opening) {
  // Ends of surfaces that are not flat are so in the surface for the most part.
  return is_wrong(opening) || (!opening.opening.is_of_surface && !flaws_of(opening).empty());
}

std::vector<std::string> faults_of(const OpeningsCompared& compared) {
  std::vector<std::string> lines;
  for (const OpeningInMesh& o : compared.openings)
    if (is_wrong(o)) lines.push_back(wrong_of(o));
  for (const std::string& name : compared.others)
    lines.push_back(name + " is no opening of the image: take it for a piece of wall");
  return lines;
}

std::vector<std::string> doubts_about(const OpeningsCompared& compared) {
  std::vector<std::string> lines = faults_of(compared);
  for (const OpeningInMesh& o : compared.openings) {
    if (o.patches.empty()) continue;
    const std::vector<std::string> flaws = flaws_of(o);
    lines.insert(lines.end(), flaws.begin(), flaws.end());
  }
  return lines;
}

}  // namespace lumesh
