#pragma once
/// @file The stages of a run, each one function: it changes the state and says in its report what it did.

#include "case_state.hpp"
#include "lumesh/metric/shaping.hpp"
#include "lumesh/report/case_report.hpp"

namespace lumesh::pipeline {

/// Reads the image or surface, or makes the phantom.
void read_input(CaseState& state, report::StageReport& stage);
/// Lines through the vessels of the image or surface.
void make_centerline(CaseState& state, report::StageReport& stage);
/// The first mesh, by the lattice or by Delaunay refinement.
void make_mesh(CaseState& state, report::StageReport& stage);
/// What the case says of sizes for the Delaunay mesher; null if nothing.
[[nodiscard]] std::unique_ptr<Sizing> sizing_of(CaseState& state, const Domain& domain);
/// A tensor for every vertex of the mesh, from all sources that are wanted.
void make_metric(CaseState& state, report::StageReport& stage);
/// Adapts the mesh to the metric that it carries.
void adapt_mesh(CaseState& state, report::StageReport& stage);

/// Grows boundary layers on the mesh, or within it.
void make_layers(CaseState& state, report::StageReport& stage);
/// Refuses layers that cannot be, so far as the input tells. @throws Error{kBadInput}.
void check_layers(CaseState& state);

/// Finds the openings that the case names, before anything is meshed. @throws Error{kBadInput} as
/// with_patches().
void find_named_openings(CaseState& state);
/// Gives the patches of the last mesh their names; returns a line for each name whose patch is not there.
[[nodiscard]] std::vector<std::string> name_patches_of_case(CaseState& state, report::StageReport& last);

/// Reads the points and velocities that the case names, and sees whether they will do, so far as can be said
/// before the centerline is there.
void read_sources(CaseState& state);
/// Sees whether the centerline has enough points for what is to be made of it.
void check_centerline_points(CaseState& state);

/// What sources of the metric that need no mesh, as far as they are wanted, ask for at any places; a list for
/// each.
[[nodiscard]] std::vector<std::vector<SymTensor>> wanted_at(CaseState& state, std::span<const Vec3> places);
/// The limits of the metric.
[[nodiscard]] metric::MetricLimits limits_of(const Case& c);

/// What of a stage's figures stands on its progress line: "316,142 tetrahedra, 63,412 vertices".
[[nodiscard]] std::string counts_line(const report::StageReport& stage);

}  // namespace lumesh::pipeline
