#include "validity.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/mesh/validate.hpp"

namespace lumesh::quality {

namespace {

void add_problem(Evaluation& evaluation, std::uint64_t count, const std::string& what) {
  if (count == 0) return;
  evaluation.problems.push_back(std::to_string(count) + " " + what);
  evaluation.problem_count += count;
}

void find_cell_problems(const MeshView& mesh, const TetMesh* kernel, const MeshSurface& surface,
                        Evaluation& evaluation) {
  if (mesh.cell_count() == mesh.tetrahedra.size()) {
    const ValidationReport report = kernel != nullptr ? validate(*kernel) : validate(mesh);
    evaluation.problems = report.problems;
    evaluation.problem_count = report.problem_count;
    return;
  }
  add_problem(evaluation, evaluation.statistics.inverted_cells,
              "cells whose volume, or Jacobian at a corner, is not positive");
  add_problem(evaluation, surface.overfull_faces, "faces with more than two cells");
  add_problem(evaluation, find_self_crossings(mesh.points, surface.outer()).size(),
              "pairs of triangles with which the outside crosses or touches itself");
  for (const LabelEvaluation& label : evaluation.labels) {
    const std::string of_label = " on the surface of label " + std::to_string(label.label);
    add_problem(evaluation, label.surface.non_manifold_edges, "non-manifold edges" + of_label);
    add_problem(evaluation, label.surface.non_manifold_vertices, "non-manifold vertices" + of_label);
  }
}

}  // namespace

void find_problems(const MeshView& mesh, const TetMesh* kernel, const MeshSurface& surface,
                   Evaluation& evaluation) {
  find_cell_problems(mesh, kernel, surface, evaluation);
  const auto far =
      std::ranges::count_if(mesh.points, [](const Vec3& x) { return x.allFinite() && !is_place(x); });
  add_problem(evaluation, static_cast<std::uint64_t>(far),
              fmt::format("points beyond {:g}, where volumes and angles are hardly numbers", kFarthest));
}

}  // namespace lumesh::quality
