#pragma once
/// @file Measures, pictures and files of a run.

#include "case_state.hpp"
#include "lumesh/report/case_report.hpp"

namespace lumesh::pipeline {

/// Puts measures of the mesh into the report of the stage that left it, and pictures if a page is wanted.
void describe_mesh(const CaseState& state, report::StageReport& stage);

/// The same of the mesh with its boundary layers, core and layers apart, and what they achieved. The image is
/// not asked: the surface that was made of it is that of the mesh before. Warns of cells that they left flat.
/// @param before  Of the mesh before, if it was looked at.
void describe_layers(const CaseState& state, const std::optional<quality::Evaluation>& before,
                     report::StageReport& stage);

/// The centerline in the surface of the mesh.
[[nodiscard]] report::NamedPicture picture_of_centerline(const CaseState& state);

/// Where the files of a case go.
[[nodiscard]] std::filesystem::path folder_of(const Case& c);
/// Whether files are there that the case writes.
[[nodiscard]] bool has_results(const Case& c);
/// Where results go: that folder, but one named "partial" in it if the run did not end and results of another
/// one are there.
[[nodiscard]] std::filesystem::path folder_of_results(const CaseState& state);

/// All names of files that a case writes.
[[nodiscard]] std::vector<std::string> names_of_files(const Case& c);

/// Refuses points and velocities that are not there. @throws Error{kBadInput}.
void check_inputs(const Case& c);

/// The same, and refuses a folder that cannot be made or written to, and names that would replace an input.
/// Leaves no new folder: the first file makes it, so that none stays empty however a run ends.
/// @throws Error{kBadInput}.
void check_outputs(const Case& c);

/// The mesh in all formats that are wanted, its surface, and the case as it was run; each with what it is.
[[nodiscard]] std::vector<report::OutputFile> write_meshes(const CaseState& state,
                                                           const std::filesystem::path& folder);
/// Faults of the mesh that write_meshes() writes.
[[nodiscard]] std::vector<std::string> faults_of_written(const CaseState& state);
/// The centerline, if files of the stages are wanted; into the folder "partial" while nobody knows whether
/// the run ends and those of another one are there.
void write_centerline(const CaseState& state, std::vector<report::OutputFile>& files);
/// The same of the first mesh.
void write_first_mesh(const CaseState& state, std::vector<report::OutputFile>& files);
/// Puts these into the place of those of another run, once the run has ended.
void settle_stage_files(const CaseState& state, const std::vector<report::OutputFile>& files);

/// The page and the numbers. Not of themselves: times of what is written here are not in them.
void write_report(const Case& c, const std::filesystem::path& folder, const report::CaseReport& report);

}  // namespace lumesh::pipeline
