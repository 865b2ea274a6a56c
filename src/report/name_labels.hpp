#pragma once
/// @file Names of openings around a picture of a surface.

#include <string>
#include <vector>

#include "camera.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/quality/surface.hpp"
#include "lumesh/report/picture.hpp"
#include "raster.hpp"

namespace lumesh::report {

/// An opening of the surface.
struct OpeningMark {
  std::string name;
  Vec3 centre_mm = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< Out of the object; zero if it has none.
};

/// The openings with the largest areas, up to 40, largest first. The centre of one that is not in its middle,
/// such as a ring, is that of its triangle nearest to the middle.
[[nodiscard]] std::vector<OpeningMark> opening_marks(const MeshView& mesh,
                                                     const quality::MeshSurface& surface);

/// Height of a line such that it is legible where a report shows the picture.
[[nodiscard]] double letter_pixels(const Camera& camera);

/// Room for the names around the object.
[[nodiscard]] Margins margins_for(const std::vector<OpeningMark>& marks, double letter_pixels);

/// Whether a triangle is in front of a place, by more than a number of pixels.
[[nodiscard]] bool is_behind(const Camera& camera, const Vec3& place, double margin_pixels,
                             const std::vector<ScreenTriangle>& triangles);

/// Puts the names beside the object: outward along the normals where there is room, no two texts over each
/// other and none beyond the picture. Names for which there is no place are left out.
/// @param triangles  That the picture was made of.
/// @param letter     Height of a line, in pixels.
[[nodiscard]] PictureLabels place_names(const std::vector<OpeningMark>& marks, const Camera& camera,
                                        const Picture& picture, const std::vector<ScreenTriangle>& triangles,
                                        double letter);

}  // namespace lumesh::report
