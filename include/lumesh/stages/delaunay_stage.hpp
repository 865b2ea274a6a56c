#pragma once
/// @file The stage that meshes a domain by Delaunay refinement and improves its angles, for every front end.

#include <optional>

#include "lumesh/adapt/improve.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/stages/size_request.hpp"

namespace lumesh {

struct DelaunayRequest {
  DelaunayOptions delaunay;
  SizeRequest sizes;
  bool improves = true;
  ImproveOptions improvement;  ///< Its execution and team are those of the whole stage.

  /// Without cells_per_diameter and the execution.
  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the option.
  void validate() const;
};

struct DelaunayMesh {
  TetMesh mesh;
  DelaunayReport report;
  std::optional<ImproveReport> improved;
  bool is_complete = true;  ///< False if it was cancelled before the end.
};

/// @param sizing  SizeData::on(); null: none. @throws what mesh_delaunay() and improve() throw.
[[nodiscard]] DelaunayMesh make_delaunay_mesh(const Domain& domain, const DelaunayRequest& request,
                                              const Sizing* sizing, Context& context);

}  // namespace lumesh
