#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/stages/mesh_output.hpp"

namespace lumesh {
namespace {

struct MeshPiece {
  std::size_t cells = 0;
  std::size_t first_cell = 0;
  double volume = 0;
  std::set<std::int32_t> openings = {};  // Patches.
};

/// One for each vertex; those without cells are of no piece. Pieces that only a vertex or an edge joins are
/// one here: find_faults() tells of these.
std::vector<MeshPiece> pieces_of(const MeshView& mesh) {
  DisjointSets sets(mesh.points.size());
  const AllCells cells(mesh);
  for (std::size_t c = 0; c < cells.size(); ++c)
    cells.visit(c, [&](const auto& corners, Label) {
      for (const std::uint32_t v : corners) sets.merge(corners[0], v);
    });
  std::vector<MeshPiece> pieces(mesh.points.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    MeshPiece& piece =
        pieces[cells.visit(c, [&](const auto& corners, Label) { return sets.find(corners[0]); })];
    if (piece.cells++ == 0) piece.first_cell = c;
    piece.volume += cells.volume(c);
  }
  for_each_patch_face(mesh, [&](const auto& corners, std::int32_t patch) {
    const auto p = static_cast<std::size_t>(patch);
    if (patch >= 0 && p < mesh.info->patches.size() && mesh.info->patches[p].kind == PatchKind::kOpening)
      pieces[sets.find(corners[0])].openings.insert(patch);
  });
  std::erase_if(pieces, [](const MeshPiece& piece) { return piece.cells == 0; });
  return pieces;
}

Vec3 middle_of(const MeshView& mesh, std::size_t cell) {
  return AllCells(mesh).visit(cell, [&](const auto& corners, Label) {
    Vec3 sum = Vec3::Zero();
    for (const std::uint32_t v : corners) sum += mesh.points[v];
    return Vec3(sum / static_cast<double>(corners.size()));
  });
}

/// A line if one of several pieces has a single opening; else empty.
std::string one_opening_warning(const MeshView& mesh, std::span<const MeshPiece> pieces) {
  const auto has_one = [](const MeshPiece& piece) { return piece.openings.size() == 1; };
  const auto first = std::ranges::find_if(pieces, has_one);
  if (first == pieces.end()) return "";
  const auto count = static_cast<std::uint64_t>(std::ranges::count_if(pieces, has_one));
  const auto patch = static_cast<std::size_t>(*first->openings.begin());
  return fmt::format(
      "{} one opening alone, as that of {}, and nothing flows through: is the vessel interrupted, as by a "
      "missing slice (lumesh check lists pieces and gaps), or to be cut open with {}?",
      counted(count, "piece of the mesh has", "pieces of the mesh have"), mesh.info->patches[patch].name,
      option_name("cut_at"));
}

}  // namespace

std::string sealed_pieces_warning(const MeshView& mesh, double least_share) {
  if (mesh.info == nullptr) return "";
  std::vector<MeshPiece> pieces = pieces_of(mesh);
  const bool has_any =
      std::ranges::any_of(pieces, [](const MeshPiece& piece) { return !piece.openings.empty(); });
  if (pieces.size() < 2 || !has_any) return "";
  double volume = 0, most = 0;
  for (const MeshPiece& piece : pieces) volume += piece.volume, most = std::max(most, piece.volume);
  std::erase_if(pieces, [&](const MeshPiece& piece) {
    return piece.openings.size() > 1 || piece.volume < least_share * most;
  });
  const std::string of_one_opening = one_opening_warning(mesh, pieces);
  std::erase_if(pieces, [](const MeshPiece& piece) { return !piece.openings.empty(); });
  if (pieces.empty()) return of_one_opening;
  const MeshPiece& largest = *std::ranges::max_element(pieces, {}, &MeshPiece::volume);
  const std::string size =
      fmt::format("{}, {:.2g} % of the volume, at {}", counted(largest.cells, "cell"),
                  100 * largest.volume / volume, decimals_text(middle_of(mesh, largest.first_cell), 1));
  return fmt::format(
      "{} no opening, and no face joins {} to what has one{}{}: nothing flows there, and the pressure has no "
      "level; leave out such a piece of the image with {} or {}, cut its vessel open with {}, or join it in "
      "the segmentation",
      counted(pieces.size(), "piece of the mesh has", "pieces of the mesh have"),
      pieces.size() == 1 ? "it" : "them", pieces.size() == 1 ? ", " : "; the largest: ", size,
      option_name("largest_component"), option_name("drop_below"), option_name("cut_at"));
}

}  // namespace lumesh
