#include <fmt/core.h>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/delaunay/delaunay.hpp"
#include "lumesh/domain/usual_edge.hpp"
#include "spacing.hpp"

namespace lumesh {

void DelaunayOptions::describe(OptionList& list) {
  using delaunay::kEdgePerSpacing;
  list.number("edge_length", edge_length_mm, above(0), "Edges on surfaces, and inside without a size")
      .in("mm")
      .zero(fmt::format("{}; of a surface {}", usual_edge_text(), usual_edge_of_surface_text()))
      .excludes("delta");
  list.number(
          "delta", delta_mm, above(0),
          fmt::format("Instead of the edge length: no place of a surface is farther than this from a point "
                      "of the mesh on it (R1); edges of surfaces are about {:g} times as long. Less where a "
                      "part or a gap is thin, in a vessel a third of its width, but at least a third of "
                      "delta",
                      kEdgePerSpacing))
      .in("mm")
      .zero(fmt::format("edge_length / {:g}", kEdgePerSpacing));
  list.number(
          "size", size_mm, above(0),
          fmt::format("Largest wanted edge length inside (R5). Where it is more than {:g} times the edges of "
                      "surfaces, sizes grow from these by {:g} mm for each mm inwards",
                      delaunay::kMuchLarger, delaunay::kGrowthInwards))
      .in("mm")
      .zero(fmt::format("{:g} delta", kEdgePerSpacing));
  list.number("surface_distance", surface_distance_mm, above(0),
              "How far flat boundary triangles may stand off a bent surface, about: where it bends, points "
              "stand closer than delta says, down to a third of that")
      .in("mm")
      .zero("none");
  list.number("lift", lift, between(0, 1),
              "Where points of bent surfaces stand: over them by this share of the sagitta of the triangles "
              "around. 1 keeps the volume, 0 leaves points on the surface");
  list.choice("seeding", seeding,
              {{"lattice", Seeding::kLattice}, {"surface", Seeding::kSurface}, {"few", Seeding::kFew}},
              "What refinement begins with: points of a lattice inside and of all surfaces; of surfaces "
              "only; or few of them, so that the rules do all the rest");
  list.number("radius_edge", radius_edge, at_least(1.5),
              "Largest circumradius of tetrahedra in units of their shortest edge (R4)");
  list.number("facet_angle", facet_angle_deg, between(0, 30),
              "Smallest angle of boundary triangles, before improvement (R3)")
      .in("degrees");
}

void DelaunayOptions::validate() const {
  require_ranges_of(*this);
  if (max_rounds < 1) throw Error(ErrorKind::kUsage, "there must be at least one round");
}

}  // namespace lumesh
