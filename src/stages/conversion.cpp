#include "lumesh/stages/conversion.hpp"

#include <sstream>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/write_results.hpp"
#include "lumesh/io/surface_file.hpp"
#include "lumesh/mesh/parts.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/vessel_ends.hpp"

namespace lumesh {
namespace {

/// @param remedy  Who says the right unit where that of the file is not known.
MixedMesh read_with_boundary(const std::string& path, const std::string& unit, const std::string& remedy,
                             Context& context) {
  MixedMesh mesh = context.phase("read", [&] { return read_surface_file(path, "", context); });
  if (!unit.empty()) mesh.info.unit = unit;
  warn_of_unknown_words(mesh.info, path, remedy, context);
  if (mesh.triangles.empty() && mesh.quadrilaterals.empty()) {
    extract_boundary(mesh);
    warn_of_found_patches(path, mesh.info.patches, context);
  }
  return mesh;
}

std::vector<std::string> separate(const std::vector<std::string>& texts) {
  std::vector<std::string> words;
  for (const std::string& text : texts) {
    std::istringstream stream(text);
    for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
  }
  return words;
}

}  // namespace

void ConversionRequest::describe(OptionList& list) {
  list.texts(
      "only_labels", only_labels,
      "Take the cells of these labels only, by names or numbers, such as 1,wall; what lay between them and "
      "others is on the outside then");
  describe_surface_output(list, output.surface);
  output.options.describe(list);
  describe_unit(list, unit);
  describe_out_unit(list, output.unit, true);
}

MixedMesh convert_mesh(const ConversionRequest& request, Context& context) {
  MixedMesh mesh = read_with_boundary(request.from, request.unit, option_name("unit"), context);
  if (!request.only_labels.empty())
    mesh = context.phase("labels", [&] {
      return naming(request.from,
                    [&] { return part_of(mesh, labels_called(separate(request.only_labels), mesh)).mesh; });
    });
  write_mesh(request.output, mesh.view(), context);
  warn_of_names(request.output.mesh, mesh.view(), context);
  if (mesh.view().cell_count() > 0) {
    warn_of_walled_ends(request.from, mesh, context);
    warn_of_faults(request.from, mesh.view(), context);
    warn_of_sealed_pieces(mesh.view(), context);
  }
  return mesh;
}

namespace {

/// Openings with their places in mm (LPS), of a mesh that stays in its own frame and unit.
std::vector<NamedOpening> openings_in_mm(const MixedMesh& mesh) {
  if (frame_factors(mesh.info, MeshInfo()) == Vec3::Ones()) return named_openings(mesh.view());
  MixedMesh in_mm = mesh;
  bring_to_lps_mm(in_mm);
  return named_openings(in_mm.view());
}

}  // namespace

RenamedMesh rename_mesh(const RenamingRequest& request, Context& context) {
  RenamedMesh made{read_with_boundary(request.from, "", kConvertSaysUnit, context), {}};
  naming(request.from, [&] {
    made.renamings = with_patches(renamings_from(request.names), openings_in_mm(made.mesh));
    rename_patches(made.mesh.info, made.renamings);
  });
  write_results(context, [&] { write_mesh(request.to, made.mesh.view()); });
  warn_of_names(request.to, made.mesh.view(), context);
  if (made.mesh.view().cell_count() > 0) warn_of_walled_ends(request.to, made.mesh, context);
  warn_of_faults(request.from, made.mesh.view(), context);
  return made;
}

}  // namespace lumesh
