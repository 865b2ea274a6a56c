#pragma once
/// @file What the stages of a run work on and hand on to each other.

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lumesh/mesh/patch_renaming.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/pipeline/pipeline.hpp"
#include "lumesh/quality/evaluation.hpp"
#include "lumesh/stages/domain_read.hpp"

namespace lumesh::pipeline {

struct CaseState {
  CaseState(const Case& of, Context& in);

  const Case& c;
  Context& context;

  DomainRead given;
  std::string input_sha256;
  std::optional<Phantom> phantom;
  Polylines centerline;
  std::optional<SizeData> sizes = {};  ///< Of the Delaunay mesher, read; taken by sizing_of().
  std::map<std::string, std::vector<Vec3>> points_read = {};                    ///< By file.
  std::map<std::pair<std::string, std::string>, metric::Flow> flows_read = {};  ///< By file and array.
  TetMesh mesh;                    ///< The first mesh, then the same with its metric, then the adapted one.
  std::optional<MixedMesh> mixed;  ///< Instead of `mesh`: one of mixed cells, or with its boundary layers.
  std::vector<PatchRenaming> renamings;  ///< What patches are to be called; none once they are.
  bool has_metric = false;               ///< Whether the metric of the mesh means anything.
  bool is_complete = true;               ///< False once a stage ended early.
  bool has_earlier_results = false;      ///< Whether the case's folder held results when the run began.

  [[nodiscard]] int threads() const;
  /// Boundary faces of `mesh`; none of `mixed`, which has them itself.
  [[nodiscard]] BoundaryFaces boundary_faces() const;
  /// The mesh with these faces of its own, and with its metric if that means anything.
  [[nodiscard]] MeshView view(const BoundaryFaces& faces) const;
  [[nodiscard]] const MeshInfo& mesh_info() const { return mixed ? mixed->info : mesh.info(); }
  [[nodiscard]] MeshInfo& mesh_info() { return mixed ? mixed->info : mesh.info(); }
  /// Description of its making that every file holds.
  [[nodiscard]] MeshInfo info() const;
};

}  // namespace lumesh::pipeline
