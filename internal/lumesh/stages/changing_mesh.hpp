#pragma once
/// @file Meshes of files while a stage changes them, wholly or but for cells that stay as they are.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lumesh/adapt/keep.hpp"
#include "lumesh/core/assert.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {

/// Points of a mesh in the frame and unit of its file, while it is in LPS and mm: there and back again is off
/// by roundings.
class OwnPoints {
 public:
  /// Brings the mesh to LPS and mm; it outlives this, and keeps its points.
  explicit OwnPoints(MixedMesh& mesh);

  [[nodiscard]] const MeshInfo& frame() const { return frame_; }  ///< And unit of the file.
  /// A place in the frame of the file: bitwise what it was where nothing has moved it.
  [[nodiscard]] Vec3 place(const Vec3& point_mm) const;
  /// Brings a mesh, in LPS and mm, back to the frame of the file.
  void bring_back(MixedMesh& mesh) const;
  void bring_back(TetMesh& mesh) const;

 private:
  const MixedMesh* mesh_;
  MeshInfo frame_;
  Vec3 factors_ = Vec3::Ones();       // From LPS and mm.
  std::vector<Vec3> own_;             // Empty where the file is in LPS and mm.
  std::vector<std::uint32_t> order_;  // Of the mesh's points by precedes().
};

/// In LPS and mm, in which all options are, until it is finished; then in the frame and unit of its file.
class ChangingMesh {
 public:
  /// @param input  Where cells are kept and it lists no faces, it gets them.
  /// @param keep  Names or numbers of labels whose cells stay as they are.
  /// @throws Error{kBadInput} that names the file, as KeptCells and tetrahedra_of() do.
  ChangingMesh(MixedMesh input, const std::vector<std::string>& keep, const std::string& name,
               Context& context);

  /// The mesh as it was before, in LPS and mm.
  [[nodiscard]] const MixedMesh& input() const { return *input_; }
  /// The input, or its part that is free to change.
  [[nodiscard]] const MixedMesh& given() const { return kept_ ? kept_->free_part() : *input_; }
  /// The metric of that: of a file, which is in the unit of the mesh's own one, or without a name the one
  /// that it carries. @throws Error{kBadInput} as metric_of() does.
  [[nodiscard]] std::vector<SymTensor> given_metric(const std::string& name, const std::string& file) const;
  /// The tetrahedra of that, which change.
  [[nodiscard]] TetMesh& changing() { return changing_; }
  [[nodiscard]] const TetMesh& changing() const { return changing_; }
  [[nodiscard]] bool has_kept() const { return kept_.has_value(); }
  [[nodiscard]] std::size_t kept_count() const { return kept_ ? kept_->kept_count() : 0; }
  /// Patches of the changing part that stand against kept cells; none where no cells are kept.
  [[nodiscard]] std::vector<PatchId> frozen_patches() const;

  /// Ends the changes: kept cells come back. Afterwards nothing may change.
  /// @param provenance  Of the mesh as it has become.
  void finish(const std::map<std::string, std::string>& provenance, Context& context);
  /// The same where nothing but the metric has changed: kept cells have the one they carry, or that of their
  /// own edges, and points and cells have the numbers that they had.
  void finish_metric(const std::map<std::string, std::string>& provenance);
  /// The whole mesh, once it is finished: asserted, as its frame and unit would be wrong before.
  [[nodiscard]] MeshView view() const {
    LUMESH_ASSERT(is_finished_);
    return kept_ ? whole_.view() : changing_.view(faces_);
  }
  /// Boundary faces of the changing part, once it is finished.
  [[nodiscard]] const BoundaryFaces& faces() const { return faces_; }

 private:
  std::unique_ptr<MixedMesh> input_;
  OwnPoints own_;  // Of the input.
  std::optional<KeptCells> kept_;
  TetMesh changing_;
  BoundaryFaces faces_;
  MixedMesh whole_;  // Where cells are kept.
  bool is_finished_ = false;
};

}  // namespace lumesh
