#include <cmath>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/stages/image_cuts.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {
namespace {

std::vector<std::vector<double>> rows_of(const std::vector<CutPlane>& planes) {
  std::vector<std::vector<double>> rows;
  for (const CutPlane& plane : planes) {
    const Vec3 &p = plane.point_mm, &n = plane.normal;
    rows.push_back({p[0], p[1], p[2], n[0], n[1], n[2]});
  }
  return rows;
}

std::vector<CutPlane> planes_from(const std::vector<std::vector<double>>& rows) {
  std::vector<CutPlane> planes;
  for (const std::vector<double>& n : rows) {
    planes.push_back({Vec3(n[0], n[1], n[2]), Vec3(n[3], n[4], n[5])});
    if (planes.back().normal.isZero(0)) throw Error(ErrorKind::kUsage, "has a plane whose normal is zero");
  }
  return planes;
}

}  // namespace

void ImageSelection::describe(OptionList& list, bool has_probabilities) {
  list.integers("labels", labels, "Labels of the image to take; none: all");
  list.number("threshold", threshold, any_number(),
              "Voxels at or above become label 1, the rest background; their values place the boundary "
              "between voxels")
      .in("image value")
      .excludes("below");
  list.number("below", below, any_number(), "The same for voxels at or below, where the object is dark")
      .in("image value");
  if (has_probabilities)
    list.path("probabilities", probabilities,
              "Image of the object's probability, 0 to 1, on the label image's grid, which places the "
              "boundary between "
              "voxels")
        .excludes("threshold")
        .excludes("below");
  list.flag("largest_component", largest_component,
            "Only the largest connected piece of all labels together");
}

void ImageCuts::describe(OptionList& list) {
  list.rows("cut_planes",
            {6, "0,0,10,0,0,-1", false, [this] { return rows_of(planes); },
             [this](const auto& rows) { planes = planes_from(rows); }},
            "Planes x, y, z, nx, ny, nz, through everything: what lies on the normal's side is cut off")
      .in("mm")
      .alias("cut_plane");
  list.rows("cut_at",
            {3, "12.5,-40,8", false,
             [this] {
               std::vector<std::vector<double>> rows;
               for (const Vec3& p : places_mm) rows.push_back({p[0], p[1], p[2]});
               return rows;
             },
             [this](const auto& rows) {
               places_mm.clear();
               for (const std::vector<double>& p : rows) places_mm.emplace_back(p[0], p[1], p[2]);
             }},
            "Places x, y, z: the vessel there, and no other, is cut square to its axis, and its smaller part "
            "goes")
      .in("mm");
}

}  // namespace lumesh
