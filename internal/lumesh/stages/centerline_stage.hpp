#pragma once
/// @file Axes of vessels of an image, a mesh or a surface from a file, for every front end.

#include <map>
#include <set>
#include <string>
#include <vector>

#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {

struct CenterlineRequest {
  std::string path;          ///< Image, mesh or surface.
  ImageSelection selection;  ///< Voxels of an image that count; its labels and unit are those of meshes, too.
  CenterlineOptions options;
  SurfaceInputOptions surface;  ///< How open ends of a surface are closed.
};

struct CenterlineMade {
  Polylines lines;
  std::map<std::string, std::string> provenance;  ///< Notes of a mesh.
  std::vector<surfaces::ClosedRim> closed;        ///< Rims closed of a surface.
  std::set<Label> labels;  ///< Labels that count together as the vessel; none of a surface.
};

/// @throws Error{kBadInput} that names the file.
[[nodiscard]] CenterlineMade find_centerline(const CenterlineRequest& request, Context& context);

}  // namespace lumesh
