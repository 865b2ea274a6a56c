#pragma once
/// @file Parts of a report on a run: notes to be kept beside meshes, and pictures of stages.

#include <optional>
#include <string>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/report/case_report.hpp"
#include "lumesh/report/picture.hpp"

namespace lumesh::report {

/// What draw_surface(), draw_surface_with_lines() or draw_cut() drew, with a caption.
[[nodiscard]] NamedPicture captioned(SurfacePicture drawn, std::string caption);
[[nodiscard]] NamedPicture captioned(CutPicture drawn, std::string caption);

/// Notes of a stage in words and numbers (what, figures, warnings, what layers achieved), to be
/// kept beside its mesh.
[[nodiscard]] std::string stage_notes_json(const StageReport& stage);
/// Puts such notes into a report. @throws Error{kBadInput} if the text is none of these.
void take_stage_notes(const std::string& json, StageReport& stage);

/// Pictures of the mesh that a stage left, with captions: its surface, a cut, and the fullest part of the cut
/// enlarged until single elements can be seen. Colours of the cuts are mean ratios, in the metric where the
/// mesh carries one. Cost: about 1.5 s for 300k tetrahedra on two cores.
/// @param window  Which part to enlarge instead, such as that of another mesh's last picture.
[[nodiscard]] std::vector<NamedPicture> draw_stage_pictures(
    const MeshView& mesh, const std::optional<CutWindow>& window = std::nullopt,
    const PictureOptions& options = {.width = 1000});

}  // namespace lumesh::report
