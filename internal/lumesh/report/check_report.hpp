#pragma once
/// @file What a check of a file found, as a page with pictures of the places.

#include <span>
#include <string>
#include <vector>

#include "lumesh/core/finding.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/report/picture.hpp"

namespace lumesh::report {

/// What the page says of a file in words and numbers; plain texts.
struct CheckedFile {
  std::string title;              ///< Such as the file name.
  std::string what;               ///< "surface", "mesh" or "image".
  std::string size;               ///< In words: "6532 triangles, 3268 points".
  bool is_fit = true;             ///< For meshing as it is.
  std::vector<Finding> findings;  ///< In the order of the page.
};

/// A picture of a place, and what it shows of the file.
struct CloseUp {
  SurfacePicture drawn;
  double width_mm = 0;       ///< From left to right.
  bool is_cut_open = false;  ///< What is in front of the place is left out, since it hides it from all sides.
};

/// Where a finding is; without pixels if it has no places.
struct FindingPictures {
  SurfacePicture overview;   ///< The whole file, with a numbered ring around each place.
  bool from_behind = false;  ///< The overview is seen from the side opposite to the usual one.
  CloseUp close_up;          ///< The first place.
};

struct CheckPictures {
  SurfacePicture whole;  ///< The file where no finding has a place; else without pixels.
  std::vector<FindingPictures> of_findings;
};

/// Draws a surface, or the outside of a mesh, in grey; its inner side is blue-grey, edges of one triangle are
/// blue and those of three triangles or more orange. Rings around places are drawn over everything, dashed
/// where something is in front. A close-up shows about 20 edges from left to right (no more than all; three
/// times the way from the place to the surface if that is more), from where the place can be seen; the
/// triangles that touch the place are red. Nothing is drawn where a coordinate is not finite.
/// @param mesh      In mm; of one without cells its triangles are drawn.
/// Threads: parallel inside, same pixels for every thread count. Cost: about 1 us per triangle and 0.1 s per
/// picture.
[[nodiscard]] CheckPictures draw_check_pictures(const MeshView& mesh, std::span<const Finding> findings,
                                                const PictureOptions& options = {.width = 1000});

/// The same of an image: faces of voxels against background, in the overview of blocks of voxels if there are
/// more than 256 in a row. A close-up shows about 20 voxels from left to right; the voxel of the place is
/// red.
[[nodiscard]] CheckPictures draw_check_pictures(const LabelImage& image, std::span<const Finding> findings,
                                                const PictureOptions& options = {.width = 1000});

/// The page: fit or not, a table of the findings, and a section with pictures for each that has places.
/// Self-contained as report_html() is, and looks like it.
[[nodiscard]] std::string check_html(const CheckedFile& file, const CheckPictures& pictures);

}  // namespace lumesh::report
