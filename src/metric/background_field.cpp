#include "lumesh/metric/background_field.hpp"

#include <utility>

#include "lumesh/metric/gradation.hpp"
#include "lumesh/metric/shaping.hpp"

namespace lumesh::metric {

MetricField background_field(const TetMesh& mesh, std::span<const SymTensor> tensors, double gradation) {
  TetMesh background = TetMesh::build(mesh.points(), mesh.tets(), mesh.labels());
  set_metric(background, tensors);
  if (gradation > 0) limit_gradation(background, {.growth = gradation});
  return MetricField::on_background(std::move(background));
}

}  // namespace lumesh::metric
