#include "lumesh/stages/input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "lumesh/core/enumerated.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/point_data_file.hpp"
#include "lumesh/io/points_file.hpp"
#include "lumesh/io/unit_doubt.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/stages/input_parts.hpp"

namespace lumesh {
namespace {

void append_line(Polylines& lines, const std::vector<Vec3>& points) {
  std::vector<std::uint32_t>& line = lines.lines.emplace_back();
  for (const Vec3& point : points) {
    line.push_back(static_cast<std::uint32_t>(lines.points.size()));
    lines.points.push_back(point);
  }
}

}  // namespace

LabelImage read_selected_image(const std::filesystem::path& path, const ImageSelection& selection,
                               Context& context) {
  LabelImage image = read_image(path, selection.read_options(), context);
  naming(path.string(), [&] { edit_image(selection, context, image); });
  return image;
}

Vec3 frame_factors(const MeshInfo& from, const MeshInfo& to) {
  const auto to_lps_mm = [](const MeshInfo& info) {
    const double known = unit_in_mm(info.unit), scale = known > 0 ? known : 1;
    return info.frame == "RAS" ? Vec3(-scale, -scale, scale) : Vec3(scale, scale, scale);
  };
  return to_lps_mm(from).cwiseQuotient(to_lps_mm(to));
}

SymTensor in_frame(const SymTensor& m, const Vec3& factors) {
  const Vec3 f = factors.cwiseInverse();
  return {m.xx * f[0] * f[0], m.xy * f[0] * f[1], m.xz * f[0] * f[2],
          m.yy * f[1] * f[1], m.yz * f[1] * f[2], m.zz * f[2] * f[2]};
}

MeshInfo bring_to_lps_mm(MixedMesh& mesh) {
  MeshInfo own;
  own.frame = mesh.info.frame;
  own.unit = mesh.info.unit;
  bring_to(mesh, MeshInfo());
  return own;
}

void bring_to(MixedMesh& mesh, const MeshInfo& frame) {
  const Vec3 factors = frame_factors(mesh.info, frame);
  if (factors == Vec3::Ones()) return;
  for (Vec3& p : mesh.points) p = p.cwiseProduct(factors);
  for (SymTensor& m : mesh.metric) m = in_frame(m, factors);
  mesh.info.frame = frame.frame;
  mesh.info.unit = frame.unit;
}

std::vector<Vec3> read_points_in(const MeshInfo& frame, const std::filesystem::path& path) {
  MixedMesh cloud = read_points(path);
  const Vec3 factors = frame_factors(cloud.info, frame);
  for (Vec3& p : cloud.points) p = p.cwiseProduct(factors);
  return std::move(cloud.points);
}

metric::Flow read_flow_in(const MeshInfo& frame, const std::filesystem::path& path, const std::string& array,
                          const std::string& unit) {
  PointData data = read_point_data(path);
  if (!unit.empty()) data.info.unit = unit;
  metric::Flow flow;
  flow.velocities = naming(path.string(), [&] { return vectors_named(data, array, "velocity"); });
  flow.points = std::move(data.points);
  const Vec3 factors = frame_factors(data.info, frame);
  for (Vec3& p : flow.points) p = p.cwiseProduct(factors);
  for (Vec3& u : flow.velocities) u = u.cwiseProduct(factors.cwiseSign());  // Directions turn with the frame.
  return flow;
}

MixedMesh read_mesh_in(const std::filesystem::path& path, const std::string& unit, const Context& context) {
  MixedMesh mesh = read_mesh(path);
  if (!unit.empty()) mesh.info.unit = unit;
  warn_of_unknown_words(mesh.info, path, option_name("unit"), context);
  return mesh;
}

MixedMesh read_told_mesh(const std::filesystem::path& path, const Context& context) {
  MixedMesh mesh = read_mesh(path);
  warn_of_unknown_words(mesh.info, path, kConvertSaysUnit, context);
  return mesh;
}

std::string unit_doubt(const MixedMesh& surface, std::span<const Opening> openings, const Box3& given_mm) {
  if (given_mm.isEmpty()) return "";
  ModelSizes sizes{given_mm.sizes().maxCoeff()};
  for (const Opening& opening : openings)
    sizes.widest_radius_mm = std::max(sizes.widest_radius_mm, opening.lumen_radius_mm());
  sizes.has_numbered_faces = has_numbered_faces(surface.info.patches);
  return unit_doubt(sizes);
}

std::string unit_doubt(const MixedMesh& surface, std::span<const Opening> openings) {
  return unit_doubt(surface, openings, bounding_box(surface.points));
}

void warn_of_unknown_words(const MeshInfo& info, const std::filesystem::path& path, const std::string& remedy,
                           const Context& context) {
  if (unit_in_mm(info.unit) == 0) context.warn(path.string() + ": " + unknown_unit_text(info.unit, remedy));
  if (info.frame != "LPS" && info.frame != "RAS")
    context.warn(fmt::format(
        "{}: its frame is \"{}\", which is not known: its coordinates are taken as LPS; turn them to "
        "LPS or RAS before",
        path.string(), info.frame));
}

void warn_of_found_patches(const std::string& path, std::span<const Patch> found, const Context& context) {
  constexpr std::size_t kMax = 8;
  if (found.size() < 2) return;
  context.warn(
      fmt::format("{}: has no faces: its boundary, and interfaces of labels, are found from the cells and "
                  "called {}; ends of vessels are part of the walls",
                  path, enumerated(names_of(found), kMax)));
}

void warn_of_ras(const MeshInfo& info, const std::filesystem::path& path, const Context& context) {
  if (info.frame == "RAS")
    context.warn(
        fmt::format("{}: its coordinates are RAS; places are told, and options of places taken, in "
                    "LPS: x and y have the other sign",
                    path.string()));
}

void warn_of_unit(const SurfaceInput& surface, std::span<const Opening> openings, const std::string& unit,
                  const std::filesystem::path& path, const Context& context) {
  if (!unit.empty()) return;
  const std::string doubt = unit_doubt(surface.mesh, openings, surface.given_box_mm);
  if (!doubt.empty()) context.warn(path.string() + ": " + doubt);
}

SurfaceView surface_view(const MixedMesh& surface, double resolution_mm) {
  return {surface.points, surface.triangles, surface.triangle_patches, surface.info.patches, resolution_mm};
}

Polylines centerline_of(const Phantom& phantom) {
  Polylines lines;
  for (const PhantomCurve& curve : phantom.centerline()) {
    append_line(lines, curve.points_mm);
    std::vector<double>& radius = lines.scalars["radius"];
    radius.insert(radius.end(), curve.radius_mm.begin(), curve.radius_mm.end());
    lines.scalars["branch"].resize(lines.points.size(), curve.branch);
  }
  return lines;
}

Polylines velocity_of(const Phantom& phantom) {
  Polylines lines;
  for (const PhantomStreamline& streamline : phantom.velocity_streamlines()) {
    append_line(lines, streamline.points_mm);
    std::vector<Vec3>& velocity = lines.vectors["velocity"];
    velocity.insert(velocity.end(), streamline.velocity_m_s.begin(), streamline.velocity_m_s.end());
  }
  return lines;
}

metric::Flow flow_of(const Phantom& phantom) {
  Polylines lines = velocity_of(phantom);
  return {std::move(lines.points), std::move(lines.vectors["velocity"])};
}

}  // namespace lumesh
