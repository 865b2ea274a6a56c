#pragma once
/// @file A report on one mesh as a single HTML file.

#include <string>

#include "lumesh/quality/evaluation.hpp"
#include "lumesh/report/picture.hpp"

namespace lumesh::report {

/// Pictures of a report; one without pixels is left out.
struct ReportPictures {
  SurfacePicture surface;
  CutPicture front;
  CutPicture side;
  CutPicture enlarged;  ///< The fullest part of the front cut.
  SurfacePicture curvature;
};

/// Draws them; cuts in the colours of the metric if the mesh has one; surfaces are drawn 1.4 times as wide.
/// Cost: about 1.5 s for 300k tetrahedra on two cores.
[[nodiscard]] ReportPictures draw_report_pictures(const MeshView& mesh,
                                                  const PictureOptions& options = {.width = 1000});

/// The page: head figures, pictures, histograms, tables and provenance. Self-contained: style, plots (SVG)
/// and pictures (PNG) are inside; no script, no network. Follows the reader's light or dark setting and
/// prints on A4.
/// @param title  Such as the file name of the mesh.
[[nodiscard]] std::string report_html(const std::string& title, const quality::Evaluation& evaluation,
                                      const ReportPictures& pictures);

}  // namespace lumesh::report
