#include "lumesh/adapt/keep.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <string>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/mesh/cell_faces.hpp"
#include "lumesh/mesh/merge.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

std::set<Label> labels_besides(const MixedMesh& mesh, const std::set<Label>& kept) {
  std::set<Label> others;
  for (const Label label : labels_of(mesh))
    if (!kept.contains(label)) others.insert(label);
  if (others.empty())
    throw Error(ErrorKind::kBadInput, "all labels are kept, nothing is left to change; keep fewer");
  return others;
}

/// A label that has cells other than tetrahedra; kBackground if none has.
Label label_of_other_cells(const MixedMesh& mesh) {
  for (const auto* labels : {&mesh.pyramid_labels, &mesh.prism_labels, &mesh.hexahedron_labels})
    if (!labels->empty()) return labels->front();
  return kBackground;
}

/// Gives patches the numbers they have in a list; those that are not in it stand behind it.
void number_patches_as(const std::vector<Patch>& list, MixedMesh& mesh) {
  std::vector<Patch> patches = list;
  std::vector<std::int32_t> numbers;
  for (const Patch& patch : mesh.info.patches) {
    const auto same = std::ranges::find_if(
        list, [&](const Patch& other) { return other.name == patch.name && other.kind == patch.kind; });
    numbers.push_back(
        static_cast<std::int32_t>(same == list.end() ? patches.size() : std::size_t(same - list.begin())));
    if (same == list.end())
      patches.push_back(patch);
    else
      patches[static_cast<std::size_t>(numbers.back())] = patch;
  }
  for (auto* faces : {&mesh.triangle_patches, &mesh.quadrilateral_patches})
    for (std::int32_t& patch : *faces)
      if (patch >= 0 && static_cast<std::size_t>(patch) < numbers.size())
        patch = numbers[static_cast<std::size_t>(patch)];
  mesh.info.patches = std::move(patches);
}

/// Edges of cells, once for each cell.
template <std::size_t N, class Visit>
void for_each_side_of_faces(const std::vector<Cell<N>>& cells, const Visit& visit) {
  for (const Cell<N>& cell : cells)
    for (const LocalFace& face : faces_of_cell(N))
      for (std::size_t i = 0; i < face.size(); ++i)
        if (const std::uint32_t a = cell[face[i]], b = cell[face[(i + 1) % 4]]; a < b) visit(a, b);
}

}  // namespace

KeptCells::KeptCells(const MixedMesh& mesh, const std::set<Label>& kept) : patches_(mesh.info.patches) {
  const std::set<Label> others = labels_besides(mesh, kept);
  free_ = part_of(mesh, others);
  if (const Label other = label_of_other_cells(free_.mesh); other != kBackground)
    throw Error(ErrorKind::kBadInput,
                "label " + std::to_string(other) +
                    " has cells other than tetrahedra, which cannot be changed; keep it, too");
  kept_ = part_of(mesh, kept);
}

MixedMesh KeptCells::put_back(const TetMesh& changed) const {
  const BoundaryFaces faces = changed.boundary_faces();
  const MixedMesh free = copy_of(changed.view(faces));
  MixedMesh kept = kept_.mesh;
  if (free.metric.empty())
    kept.metric.clear();
  else if (kept.metric.empty())
    kept.metric = own_metric(kept);
  const std::vector<MergePart> parts = {{&free, "the changed part"}, {&kept, "the kept cells"}};
  MixedMesh whole = merge_meshes(parts, MergeOptions::of_one_mesh()).mesh;
  number_patches_as(patches_, whole);
  return whole;
}

std::vector<SymTensor> own_metric(const MixedMesh& mesh) {
  std::vector<Mat3> sums(mesh.points.size(), Mat3::Zero());
  std::vector<double> counts(mesh.points.size(), 0);
  const auto add = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 edge = mesh.points[b] - mesh.points[a];
    const Mat3 square = edge * edge.transpose();
    for (const std::uint32_t v : {a, b}) {
      sums[v] += square;
      ++counts[v];
    }
  };
  for_each_side_of_faces(mesh.tetrahedra, add);
  for_each_side_of_faces(mesh.pyramids, add);
  for_each_side_of_faces(mesh.prisms, add);
  for_each_side_of_faces(mesh.hexahedra, add);
  std::vector<SymTensor> metric(mesh.points.size(), SymTensor{1, 0, 0, 1, 0, 1});
  parallel::for_each_index(metric.size(), [&](std::size_t v) {
    if (counts[v] > 0) metric[v] = SymTensor::from((sums[v] / counts[v]).inverse() / 3);
  });
  return metric;
}

}  // namespace lumesh
