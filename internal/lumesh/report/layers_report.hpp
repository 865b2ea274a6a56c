#pragma once
/// @file What boundary layers achieved, for people and for programs.

#include <map>
#include <optional>
#include <string>

#include "lumesh/core/context.hpp"
#include "lumesh/layers/layers.hpp"
#include "lumesh/report/case_report.hpp"
#include "lumesh/report/command_notes.hpp"
#include "lumesh/report/picture.hpp"
#include "lumesh/stages/layers_stage.hpp"

namespace lumesh::report {

/// Dihedral angles below this are few in good meshes, and solvers may fail at them.
inline constexpr double kFlatDihedralDeg = 5;

/// @param mesh    LayerResult::mesh, or what was read of a file of it.
/// @param report  LayerResult::report.
/// @param min_before_deg  Smallest dihedral angle of the mesh without layers, if that is known.
[[nodiscard]] LayersOfMesh measure_layers(const MeshView& mesh, LayerReport report,
                                          double min_before_deg = 180);

/// A mesh with layers, extensions of its openings, or both.
struct LayeredMesh {
  MixedMesh mesh;
  std::optional<LayersOfMesh> layers;  ///< Without the extensions.
  std::size_t extension_cells = 0;
};

/// Makes what the request asks for: layers, measured before extensions change the mesh, and those.
/// @param name  Of the mesh, for messages and warnings. @throws what grow_layers_on() and extend_mesh()
/// throw.
[[nodiscard]] LayeredMesh layer_mesh(const MixedMesh& mesh, const std::string& name,
                                     const LayersAndExtension& request, Context& context);

/// A table with a row for each patch, reasons and worst places below it; lines of at most 100 columns.
[[nodiscard]] std::string coverage_text(const LayerReport& report);

/// The same, and a line on the whole mesh. @param path  Name of the mesh.
[[nodiscard]] std::string layers_text(const std::string& path, const LayersOfMesh& layers);

/// The same of what was made of a mesh, and a line on extensions; either alone where there is but one.
[[nodiscard]] std::string layered_mesh_text(const std::string& path, const LayeredMesh& made);

/// The same numbers and those of the parts as JSON; docs/stages/layers.md describes the fields.
[[nodiscard]] std::string layers_json(const LayersOfMesh& layers, const CommandNotes& notes);

/// The surface from two sides.
struct LayerPictures {
  SurfacePicture front;  ///< From where it spreads most.
  SurfacePicture back;   ///< From the opposite side.
};

/// The surface that layers grew on, coloured by the share of the thickness wanted that they reached, from 0
/// to 1; grey where one looks through an opening at its inner side. Threads: parallel inside, same pixels for
/// every thread count.
[[nodiscard]] LayerPictures draw_layer_shares(const LayerShares& surface,
                                              const PictureOptions& options = {.width = 1000});

/// A page of its own, self-contained as report_html() is: table, pictures, how the shares are distributed.
/// @param title  Such as the file name of the mesh.
[[nodiscard]] std::string layers_html(const std::string& title, const LayersOfMesh& layers,
                                      const LayerPictures& pictures,
                                      const std::map<std::string, std::string>& provenance);

}  // namespace lumesh::report
