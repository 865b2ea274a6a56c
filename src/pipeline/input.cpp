#include "lumesh/pipeline/input.hpp"

#include "lumesh/core/error.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh {
namespace {

/// Two triangles for each quadrilateral.
void split_quadrilaterals(MixedMesh& mesh) {
  for (std::size_t q = 0; q < mesh.quadrilaterals.size(); ++q) {
    const Cell<4>& c = mesh.quadrilaterals[q];
    mesh.triangles.push_back({c[0], c[1], c[2]});
    mesh.triangles.push_back({c[0], c[2], c[3]});
    mesh.triangle_patches.insert(mesh.triangle_patches.end(), 2, mesh.quadrilateral_patches[q]);
  }
  mesh.quadrilaterals.clear();
  mesh.quadrilateral_patches.clear();
}

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
  LabelImage image = read_image(path, {selection.labels, selection.threshold}, context);
  if (selection.largest_component > 0) keep_largest_component(image, ComponentScope::kUnion);
  return image;
}

void bring_to_lps_mm(MixedMesh& mesh) {
  const bool ras = mesh.info.frame == "RAS";
  const double scale = mesh.info.unit == "m" ? 1000 : mesh.info.unit == "cm" ? 10 : 1;
  if (!ras && scale == 1) return;
  const Vec3 factors = ras ? Vec3(-scale, -scale, scale) : Vec3(scale, scale, scale);
  for (Vec3& p : mesh.points) p = p.cwiseProduct(factors);
  // Lengths in the metric stay as they are; it is per square of the coordinates' unit.
  for (SymTensor& m : mesh.metric) {
    const Vec3 f = factors.cwiseInverse();
    m = {m.xx * f[0] * f[0], m.xy * f[0] * f[1], m.xz * f[0] * f[2],
         m.yy * f[1] * f[1], m.yz * f[1] * f[2], m.zz * f[2] * f[2]};
  }
  mesh.info.frame = "LPS";
  mesh.info.unit = "mm";
}
std::unique_ptr<SurfaceDomain> read_surface_domain(const std::filesystem::path& path,
                                                   const SurfaceDomainOptions& options, Context& context) {
  MixedMesh mesh = context.phase("read", [&] { return read_mesh(path); });
  if (mesh.view().cell_count() > 0)
    throw Error(
        ErrorKind::kBadInput,
        path.string() + ": is a mesh of a volume; give its closed surface alone, such as a .stl or .vtp");
  bring_to_lps_mm(mesh);
  split_quadrilaterals(mesh);
  return context.phase("domain", [&] {
    return naming(path.string(), [&] {
      return std::make_unique<SurfaceDomain>(
          SurfaceView{mesh.points, mesh.triangles, mesh.triangle_patches, mesh.info.patches}, options);
    });
  });
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

}  // namespace lumesh
