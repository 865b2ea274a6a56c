#include "lumesh/mesh/parts.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/mesh/cell_sides.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

/// Takes the cells of some labels out of a mesh.
class PartBuilder {
 public:
  PartBuilder(const MixedMesh& mesh, const std::set<Label>& labels)
      : mesh_(mesh), labels_(labels), sides_(mesh.view()), numbers_(mesh.points.size(), VertexId::kNone) {
    sides_.check();
  }

  LabelPart build() {
    part_.info = mesh_.info;
    part_.info.patches.clear();
    std::erase_if(part_.info.label_names, [&](const auto& entry) { return !labels_.contains(entry.first); });
    number_points();
    for_each_cell_list([&](auto&... lists) { take_cells(lists...); }, mesh_, part_);
    number_patches();
    for_each_face([&](const FaceCorners& face, std::int32_t patch) { take_face(face, patch); });
    add_unlisted_faces();
    result_.mesh = std::move(part_);
    return std::move(result_);
  }

 private:
  [[nodiscard]] bool stays(Label label) const { return labels_.contains(label); }
  template <class Visit>
  void for_each_face(const Visit& visit) const {
    for_each_patch_face(mesh_, [&](const auto& face, std::int32_t patch) { visit(face_of(face), patch); });
  }

  void number_points() {
    std::vector<std::uint8_t> used(mesh_.points.size(), 0);
    const auto mark = [&](const auto& cells, const std::vector<Label>& labels) {
      for (std::size_t c = 0; c < cells.size(); ++c)
        if (stays(labels[c]))
          for (const std::uint32_t v : cells[c]) used[v] = 1;
    };
    for_each_cell_list(mark, mesh_);
    for (std::size_t v = 0; v < used.size(); ++v) {
      if (used[v] == 0) continue;
      numbers_[v] = static_cast<std::uint32_t>(part_.points.size());
      part_.points.push_back(mesh_.points[v]);
      result_.points.push_back(static_cast<std::uint32_t>(v));
      if (!mesh_.metric.empty()) part_.metric.push_back(mesh_.metric[v]);
      if (!mesh_.sizes_mm.empty()) part_.sizes_mm.push_back(mesh_.sizes_mm[v]);
    }
  }
  template <std::size_t N>
  void take_cells(const std::vector<Cell<N>>& cells, std::vector<Cell<N>>& taken,
                  const std::vector<Label>& labels, std::vector<Label>& taken_labels) const {
    for (std::size_t c = 0; c < cells.size(); ++c) {
      if (!stays(labels[c])) continue;
      Cell<N>& cell = taken.emplace_back(cells[c]);
      for (std::uint32_t& v : cell) v = numbers_[v];
      taken_labels.push_back(labels[c]);
    }
  }

  /// The cells beside a face that stay, of those there are.
  struct Beside {
    std::vector<CellSide> staying;
    bool is_cut = false;  ///< A cell on the other side goes.
  };
  [[nodiscard]] Beside beside(const FaceCorners& face) const {
    Beside found;
    for (const CellSide& side : sides_.find(face))
      if (stays(sides_.label(side)))
        found.staying.push_back(side);
      else
        found.is_cut = true;
    return found;
  }
  /// A wall of its own where the rest was.
  std::int32_t add_cut_patch(const std::string& name, Label inside, std::int32_t of_whole) {
    result_.patches.push_back(of_whole);
    part_.info.patches.push_back(
        {free_patch_name(part_.info.patches, name), PatchKind::kWall, {inside, kBackground}});
    result_.cut.emplace_back(static_cast<std::uint32_t>(part_.info.patches.size()) - 1);
    return static_cast<std::int32_t>(result_.cut.back().value);
  }
  [[nodiscard]] bool is_listed(std::int32_t patch) const {
    return patch >= 0 && static_cast<std::size_t>(patch) < mesh_.info.patches.size();
  }
  /// Patches that stay, in their order; a patch that is cut in part is two.
  void number_patches() {
    std::vector<std::array<Label, 2>> uses(mesh_.info.patches.size(), {-1, -1});  // As it was, and cut.
    for_each_face([&](const FaceCorners& face, std::int32_t patch) {
      const Beside found = beside(face);
      if (found.staying.empty() || !is_listed(patch)) return;
      uses[static_cast<std::size_t>(patch)][found.is_cut ? 1 : 0] = sides_.label(found.staying.front());
    });
    for (std::size_t p = 0; p < uses.size(); ++p) {
      const auto [whole, cut] = uses[p];
      const Patch& patch = mesh_.info.patches[p];
      patch_numbers_.push_back({-1, -1});
      if (whole >= 0) {
        patch_numbers_.back()[0] = static_cast<std::int32_t>(part_.info.patches.size());
        part_.info.patches.push_back(patch);
        result_.patches.push_back(static_cast<std::int32_t>(p));
      }
      if (cut >= 0) patch_numbers_.back()[1] = add_cut_patch(patch.name, cut, static_cast<std::int32_t>(p));
    }
  }
  void take_face(const FaceCorners& face, std::int32_t patch) {
    const Beside found = beside(face);
    if (found.staying.empty()) return;
    const std::int32_t number =
        is_listed(patch) ? patch_numbers_[static_cast<std::size_t>(patch)][found.is_cut ? 1 : 0] : patch;
    add_face(found.is_cut ? sides_.outward(found.staying.front()) : face, number);
  }
  void add_face(const FaceCorners& face, std::int32_t patch) {
    append_face({numbers_[face[0]], numbers_[face[1]], numbers_[face[2]], numbers_[face[3]]}, patch, part_);
  }
  /// Faces between cells that stay and cells that go, where no patch lists them.
  void add_unlisted_faces() {
    std::vector<Cell<4>> listed;
    for_each_face([&](const FaceCorners& face, std::int32_t) { listed.push_back(key_of(face)); });
    parallel::sort(listed.begin(), listed.end());
    using Pair = std::array<CellSide, 2>;  // The one that stays first.
    const auto cut = sides_.collect<Pair>([&](std::span<const CellSide> run, std::vector<Pair>& out) {
      if (run.size() < 2 || std::ranges::binary_search(listed, run[0].key)) return;
      const bool first_stays = stays(sides_.label(run[0]));
      if (first_stays != stays(sides_.label(run[1])))
        out.push_back(first_stays ? Pair{run[0], run[1]} : Pair{run[1], run[0]});
    });
    std::map<std::array<Label, 2>, std::int32_t> patches;  // By the labels that stay and go.
    for (const auto& [side, behind] : cut) {
      const Label inside = sides_.label(side), outside = sides_.label(behind);
      const auto [place, is_new] = patches.try_emplace({inside, outside}, -1);
      if (is_new) place->second = add_cut_patch(name_between(inside, outside), inside, -1);
      add_face(sides_.outward(side), place->second);
    }
  }

  const MixedMesh& mesh_;
  const std::set<Label>& labels_;
  CellSides sides_;
  std::vector<std::uint32_t> numbers_;                      // Of the points; kNone for those that go.
  std::vector<std::array<std::int32_t, 2>> patch_numbers_;  // Of each patch as it was, and where it is cut.
  MixedMesh part_;
  LabelPart result_;
};

}  // namespace

MixedMesh copy_of(const MeshView& view) {
  const auto copy = [](const auto& from, auto& to) { to.assign(from.begin(), from.end()); };
  MixedMesh mesh;
  copy(view.points, mesh.points);
  const auto copy_cells = [&](const auto& cells, auto& to, const auto& labels, auto& to_labels) {
    copy(cells, to);
    copy(labels, to_labels);
  };
  for_each_cell_list(copy_cells, view, mesh);
  copy(view.triangles, mesh.triangles);
  copy(view.triangle_patches, mesh.triangle_patches);
  copy(view.quadrilaterals, mesh.quadrilaterals);
  copy(view.quadrilateral_patches, mesh.quadrilateral_patches);
  copy(view.metric, mesh.metric);
  mesh.info = *view.info;
  return mesh;
}

std::set<Label> labels_of(const MixedMesh& mesh) {
  std::set<Label> labels;
  const MeshView view = mesh.view();
  const AllCells cells(view);
  for (std::size_t c = 0; c < cells.size(); ++c)
    if (c == 0 || cells.label(c) != cells.label(c - 1)) labels.insert(cells.label(c));
  return labels;
}

std::string label_list(const std::set<Label>& labels, const std::map<Label, std::string>& names) {
  std::string list;
  for (const Label label : labels) {
    list += (list.empty() ? "" : ", ") + std::to_string(label);
    const auto name = names.find(label);
    if (name != names.end() && !name->second.empty()) list += " (" + name->second + ")";
  }
  return list;
}

std::set<Label> labels_called(std::span<const std::string> wanted, const std::set<Label>& present,
                              const std::map<Label, std::string>& names) {
  std::set<Label> found;
  for (const std::string& word : wanted) {
    bool known = false;
    for (const auto& [label, name] : names)
      if (name == word && present.contains(label)) known = true, found.insert(label);
    const std::optional<Label> number = parse_number<Label>(word);
    if (!known && number && present.contains(*number)) known = true, found.insert(*number);
    if (!known)
      throw Error(ErrorKind::kBadInput,
                  "there is no label " + word + "; labels present: " + label_list(present, names));
  }
  return found;
}

std::set<Label> labels_called(std::span<const std::string> wanted, const MixedMesh& mesh) {
  return labels_called(wanted, labels_of(mesh), mesh.info.label_names);
}

LabelPart part_of(const MixedMesh& mesh, const std::set<Label>& labels) {
  return PartBuilder(mesh, labels).build();
}

}  // namespace lumesh
