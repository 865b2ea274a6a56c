#pragma once
/// @file Boundary layers on meshes of every shape of cell, for every front end.

#include <map>
#include <set>
#include <string>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/extension.hpp"
#include "lumesh/layers/layers.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

class OptionList;

/// Boundary layers as front ends ask for them: labels by name or number.
struct LayerRequest {
  LayerOptions options;  ///< Without the label that is deformed.
  std::string into;      ///< Name or number of the label that is deformed; empty: all at the patches.

  [[nodiscard]] bool is_wanted() const { return options.first_height > 0; }
  void describe(OptionList& list);
  /// @throws Error{kBadInput} or Error{kUsage} that names the option.
  void validate() const;
  /// The options with the label that is deformed. @param present, names  Labels of the mesh that gets the
  /// layers, and their names. @throws Error{kBadInput} that names the option, for a label that is not present
  /// and for a name that several have.
  [[nodiscard]] LayerOptions resolved(const std::set<Label>& present,
                                      const std::map<Label, std::string>& names) const;
};

/// Additions to a finished mesh at its surface: layers, extensions of its openings, or both.
struct LayersAndExtension {
  LayerRequest layers;
  ExtensionOptions extension;  ///< The lengths alone.

  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the option, also where neither is wanted.
  void validate() const;
  /// @throws Error{kUsage} if the mesh may have prisms, and files of this name hold tetrahedra only.
  void require_held_by(const std::string& path) const;
};

/// As grow_layers(). Outwards the mesh may have hexahedra, pyramids and prisms, which stay as they are:
/// layers see its triangles and its volume alone. @param name  Of the mesh, for messages.
/// @throws what grow_layers() and tetrahedra_of() throw, and Error{kBadInput} for such cells inwards, for
/// quadrilaterals on the boundary, and for cells so warped that they cannot be split into tetrahedra.
[[nodiscard]] LayerResult grow_layers_on(const MixedMesh& mesh, const std::string& name,
                                         const LayerOptions& options, Context& context);

/// The layers as a request has them, whose labels are those of the mesh.
[[nodiscard]] LayerResult grow_layers_on(const MixedMesh& mesh, const std::string& name,
                                         const LayerRequest& request, Context& context);

/// Sweeps the openings of a mesh on, as extrude_openings(), in place; warns of those that are not as asked
/// for. Nothing where no extension is wanted.
void extend_mesh(MixedMesh& mesh, const std::string& name, const ExtensionOptions& extension,
                 LayerCells cells, Context& context);

}  // namespace lumesh
