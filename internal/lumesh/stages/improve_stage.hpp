#pragma once
/// @file The stage that raises the worst dihedral angles of a finished mesh, for every front end.

#include <string>
#include <vector>

#include "lumesh/adapt/improve.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/stages/changing_mesh.hpp"
#include "lumesh/stages/mesh_cut.hpp"
#include "lumesh/stages/provenance.hpp"

namespace lumesh {

struct ImproveRequest {
  std::string mesh;                  ///< Path.
  ImproveOptions options;            ///< Without sizes and frozen patches, which the stage finds.
  std::vector<CutPlane> cut_planes;  ///< Cut the mesh off before.
  std::vector<std::string> keep;     ///< Labels whose cells stay as they are.
  std::string metric;                ///< File of sizes that edges keep to; empty: the mesh's own.
  bool ignores_sizes = false;        ///< Even those that the mesh carries.

  void validate() const { options.validate(); }
};

struct ImprovedMesh {
  CutMesh cut;
  ChangingMesh mesh;
  ImproveReport report;
  bool keeps_sizes = false;

  /// The whole mesh, once it is finished; with its metric only where edges kept to it.
  [[nodiscard]] MeshView view() const;
};

/// Cuts a mesh off and improves it, as improve(). Warns of cuts that meet the wall in sharp edges, and of
/// sizes that differ by direction, which only those of a mesh may.
/// @param input  The request's mesh, as read. @throws Error{kBadInput} as cut_mesh(), ChangingMesh and
/// metric_of() do. Parallel inside.
[[nodiscard]] ImprovedMesh improve_mesh(MixedMesh input, const ImproveRequest& request, Context& context);
/// The mesh of the file, improved and finished, with its cuts in the provenance.
/// @param making  For the provenance. @throws Error as above, and what read_mesh() throws.
[[nodiscard]] ImprovedMesh improve_mesh(const ImproveRequest& request, const Making& making,
                                        Context& context);

}  // namespace lumesh
