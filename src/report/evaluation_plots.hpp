#pragma once
/// @file Cards with the histograms of an evaluation: of one mesh, or of several one over the other.

#include <span>
#include <string>

#include "lumesh/quality/evaluation.hpp"

namespace lumesh::report {

/// Dihedral angles, all of them and those at both ends enlarged; mean ratios with counts as they are and in
/// powers of ten; the same of lengths and mean ratios in the metric, if the mesh has one.
[[nodiscard]] std::string plots_html(const quality::Evaluation& evaluation);

/// A mesh among others.
struct NamedEvaluation {
  std::string name;  ///< Plain text.
  const quality::Evaluation* evaluation;
};

/// The same of several meshes as lines; metric plots of those that have a metric, if at least two do.
[[nodiscard]] std::string comparison_plots_html(std::span<const NamedEvaluation> meshes);

}  // namespace lumesh::report
