#pragma once
/// @file Collects what a Gmsh or Medit file holds, checks it, and turns face tags into patches.

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "cell_blocks.hpp"
#include "file_fault.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/patch_list.hpp"

namespace lumesh::io {

/// Points and cells in any order; finish() checks that they fit together. Prisms come in Gmsh's and Medit's
/// order.
class MeshBuilder {
 public:
  explicit MeshBuilder(std::filesystem::path path) : path_(std::move(path)) {}

  [[noreturn]] void fail(std::string_view what) const {
    io::fail(path_, fmt::format("{}; write the file again", what));
  }

  void add_point(const Vec3& point) {
    if (!point.allFinite())
      fail(fmt::format("the coordinates of point {}, counted from 0, are not finite", mesh_.points.size()));
    mesh_.points.push_back(point);
  }

  /// Adds a cell or a boundary face with its label or face tag. Corners count from 0.
  void add_cell(CellShape shape, std::span<const std::int64_t> corners, std::int64_t tag) {
    if (tag < std::numeric_limits<std::int32_t>::min() || tag > std::numeric_limits<std::int32_t>::max())
      fail(fmt::format("tag {} does not fit into 32 bits", tag));
    const auto small_tag = static_cast<std::int32_t>(tag);
    visit_cells(mesh_, static_cast<std::int64_t>(shape),
                [&](auto& cells, auto& tags) { add(corners, small_tag, cells, tags); });
  }

  /// Adds a face of three corners or more: a quadrilateral as it is, others as a fan of triangles.
  void add_polygon(std::span<const std::int64_t> corners, std::int64_t tag) {
    if (corners.size() == 4) return add_cell(CellShape::kQuadrilateral, corners, tag);
    for (std::size_t k = 2; k < corners.size(); ++k)
      add_cell(CellShape::kTriangle, {{corners[0], corners[k - 1], corners[k]}}, tag);
  }

  void name_patch(std::int64_t tag, std::string name) { patch_names_[tag] = std::move(name); }
  void name_label(Label label, std::string name) { label_names_[label] = std::move(name); }
  /// What a comment of ours says; its patches hold where the face tags are patch id + 1.
  void set_info(MeshInfo info) { mesh_.info = std::move(info); }

  MixedMesh finish() {
    check_corners();
    number_patches();
    give_default_label();
    if (mesh_.info.label_names.empty()) mesh_.info.label_names = std::move(label_names_);
    return std::move(mesh_);
  }

 private:
  template <std::size_t N>
  void add(std::span<const std::int64_t> corners, std::int32_t tag, std::vector<Cell<N>>& cells,
           std::vector<std::int32_t>& tags) {
    if (corners.size() != N) fail(kWrongCorners);
    Cell<N> cell;
    for (std::size_t i = 0; i < N; ++i) {
      const std::int64_t corner = corners[N == kPrismOrder.size() ? kPrismOrder[i] : i];
      if (corner < 0 || corner > std::numeric_limits<std::uint32_t>::max() - 1)
        fail(fmt::format("a cell refers to point {}, counted from 0, which is not there", corner));
      cell[i] = static_cast<std::uint32_t>(corner);
    }
    cells.push_back(cell);
    tags.push_back(tag);
  }

  void check_corners() const {
    const MeshView mesh = mesh_.view();
    const auto check = [&](const CellBlock& block) {
      for (const std::uint32_t v : block.vertices)
        if (v >= mesh.points.size())
          fail(fmt::format("a cell refers to point {}, counted from 0, which is not there", v));
    };
    for (const CellBlock& block : volume_blocks(mesh)) check(block);
    for (const CellBlock& block : face_blocks(mesh)) check(block);
  }

  /// Face tags become patch ids: tag - 1 under our own list of patches, else in ascending order of the tags.
  void number_patches() {
    std::set<std::int32_t> tags;
    for (const auto* faces : {&mesh_.triangle_patches, &mesh_.quadrilateral_patches})
      for (const std::int32_t tag : *faces)
        if (tags.empty() || tag != *tags.rbegin()) tags.insert(tag);
    const auto known = static_cast<std::int32_t>(std::min<std::size_t>(mesh_.info.patches.size(), 1U << 30));
    std::map<std::int32_t, std::int32_t> patch_of;
    if (known > 0 && (tags.empty() || (*tags.begin() >= 1 && *tags.rbegin() <= known))) {
      for (std::int32_t tag = 1; tag <= known; ++tag) patch_of[tag] = tag - 1;
    } else {
      mesh_.info.patches.clear();
      for (const auto& [tag, name] : patch_names_) tags.insert(static_cast<std::int32_t>(tag));
      for (const std::int32_t tag : tags) {
        patch_of[tag] = static_cast<std::int32_t>(mesh_.info.patches.size());
        const auto found = patch_names_.find(tag);
        const std::string name = found == patch_names_.end() ? fmt::format("patch_{}", tag) : found->second;
        mesh_.info.patches.push_back({name, kind_of_name(name), {}});
      }
    }
    for (auto* faces : {&mesh_.triangle_patches, &mesh_.quadrilateral_patches})
      for (std::int32_t& tag : *faces) tag = patch_of.at(tag);
  }

  /// Files without labels say 0 everywhere.
  void give_default_label() {
    const std::array<std::vector<Label>*, 4> all = {&mesh_.tetrahedron_labels, &mesh_.pyramid_labels,
                                                    &mesh_.prism_labels, &mesh_.hexahedron_labels};
    for (const auto* labels : all)
      for (const Label label : *labels)
        if (label != 0) return;
    for (auto* labels : all) std::fill(labels->begin(), labels->end(), 1);
  }

  std::filesystem::path path_;
  MixedMesh mesh_;
  std::map<std::int64_t, std::string> patch_names_;
  std::map<Label, std::string> label_names_;
};

}  // namespace lumesh::io
