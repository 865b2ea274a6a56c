#pragma once
/// @file The stages that make a first mesh of a file, by the lattice or by Delaunay refinement: what they
/// read, the mesh with the names that users give, and what it is compared with; for every front end.

#include <memory>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/lattice/lattice.hpp"
#include "lumesh/stages/delaunay_stage.hpp"
#include "lumesh/stages/domain_read.hpp"
#include "lumesh/stages/opening_request.hpp"
#include "lumesh/stages/provenance.hpp"

namespace lumesh {

struct LatticeRequest {
  DomainInput input;  ///< An image.
  OpeningRequest openings;
  LatticeOptions options;
  double cells_per_diameter = 0;  ///< 0: as the options' fidelity says.
};

struct DelaunayFileRequest {
  DomainInput input;
  OpeningRequest openings;
  DelaunayRequest mesher;
};

/// Input of a first mesh as read, with its notes.
struct FirstMeshInput {
  DomainRead given;
  std::string closed_vessels = {};             ///< See DomainRead::closed_vessels().
  std::vector<std::string> without_name = {};  ///< A line for each name whose patch the mesh lacks.
};

struct LatticeMesh {
  FirstMeshInput input;
  LatticeResult made;
  bool is_mixed = false;  ///< Whether hexahedra were asked for.
};

struct DelaunayFileMesh {
  FirstMeshInput input;
  std::unique_ptr<Sizing> sizing;  ///< Null: no sizes from place to place.
  DelaunayMesh made;
  BoundaryFaces faces;

  /// The mesh without the metric that improvement works with, which says nothing.
  [[nodiscard]] MeshView view() const;
};

/// @param making  For the provenance. @throws Error that names the file or the option.
[[nodiscard]] LatticeMesh make_lattice_mesh(const LatticeRequest& request, const Making& making,
                                            Context& context);
[[nodiscard]] DelaunayFileMesh make_delaunay_mesh(const DelaunayFileRequest& request, const Making& making,
                                                  Context& context);

struct FirstMeshRemarks {
  std::vector<std::string> differences;  ///< Lines on differences from the image or surface.
  std::vector<std::string> warnings;     ///< Notes of the mesher and its sizes, these lines, sealed pieces.
};
/// Remarks on a first mesh, for those who made it to warn of.
[[nodiscard]] FirstMeshRemarks remarks_on(const LatticeResult& made, DomainRead& given);
/// @param sizing  Null: no sizes from place to place.
[[nodiscard]] FirstMeshRemarks remarks_on(const DelaunayMesh& made, const BoundaryFaces& faces,
                                          const Sizing* sizing, DomainRead& given);

/// Comparison of a first mesh with its input.
struct FirstMeshComparison {
  std::vector<std::string> differences;  ///< Lines on differences from the image or surface.
  OpeningsCompared openings;
};
/// Compares; warns of what the mesher notes, of these differences, and of openings that are wrong.
[[nodiscard]] FirstMeshComparison compare_with_input(LatticeMesh& mesh, Context& context);
[[nodiscard]] FirstMeshComparison compare_with_input(DelaunayFileMesh& mesh, Context& context);

}  // namespace lumesh
