#include "lumesh/stages/metric_input.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/geometry/metric_fault.hpp"
#include "lumesh/io/metric_file.hpp"
#include "lumesh/metric/tensor.hpp"

namespace lumesh {

TetMesh tetrahedra_of(const MixedMesh& mesh, const std::string& path) {
  if (mesh.tetrahedra.empty())
    throw Error(
        ErrorKind::kBadInput,
        path +
            ": has no tetrahedra; give a mesh of the volume (lumesh delaunay makes one of a closed surface)");
  const std::size_t cells = mesh.view().cell_count(), others = cells - mesh.tetrahedra.size();
  if (others > 0)
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("{}: {} of its {} cells are hexahedra, prisms or pyramids, and this takes tetrahedra "
                    "only; mesh without `mixed`, or keep the labels of those cells, where the command "
                    "has `keep`",
                    path, others, cells));
  return naming(path, [&] {
    TetMesh built = TetMesh::build(mesh.view());
    for (std::uint32_t v = 0; v < built.vertex_count(); ++v)
      if (!built.incident_tet(VertexId(v)).valid())
        throw Error(ErrorKind::kBadInput, fmt::format("point {}, counted from 0, belongs to no tetrahedron; "
                                                      "remove such points",
                                                      v));
    return built;
  });
}

Error without_metric(const std::string& mesh_path, const std::string& way) {
  return {ErrorKind::kBadInput, fmt::format("{}: carries no metric; {}", mesh_path, way)};
}

std::vector<SymTensor> metric_of(const MixedMesh& mesh, const std::string& mesh_path,
                                 const std::string& metric_path) {
  std::vector<SymTensor> tensors =
      metric_path.empty() ? mesh.metric : read_metric(metric_path, mesh.points.size());
  if (tensors.empty())
    throw without_metric(mesh_path, "make one with `lumesh metric`, or give " + option_name("metric") +
                                        " or " + option_name("analytic"));
  for (std::size_t i = 0; i < tensors.size(); ++i)
    if (!is_metric(tensors[i]))
      throw Error(ErrorKind::kBadInput, fmt::format("{}: the tensor of vertex {}, counted from 0, is no "
                                                    "metric; its eigenvalues must be finite, above 0 "
                                                    "and within a factor of 1e30 of each other",
                                                    metric_path.empty() ? mesh_path : metric_path, i));
  return tensors;
}

bool are_isotropic(const std::vector<SymTensor>& tensors) {
  constexpr double kSame = 1.02;  // Of eigenvalues, which are inverse squares of sizes.
  return std::ranges::all_of(tensors, [](const SymTensor& tensor) {
    const Vec3 values = metric::eigen_system(tensor).values;
    return values.maxCoeff() <= kSame * values.minCoeff();
  });
}

}  // namespace lumesh
