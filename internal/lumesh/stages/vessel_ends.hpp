#pragma once
/// @file Vessels that end inside an image, and surfaces without ends, where no mesh will have an opening.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"

namespace lumesh {

struct VesselEnd {
  double radius_mm = 0;
  Vec3 place_mm = Vec3::Zero();       ///< The centre of the last ball that fits into the vessel.
  std::vector<Vec3> farther_mm = {};  ///< On the axis, one radius and two up the vessel, where it is as long.
  std::optional<Vec3> cut_mm = {};    ///< Where it can be cut: the first of these; none if nobody has tried.
  std::string refusal = {};           ///< Why it cannot be, if it was tried.
};

/// Ends of centerlines that lie at no opening, by falling radius: vessels that were segmented so far only,
/// and bulges; of lines more than twice as long as their largest radius.
/// @param lines  With the scalar "radius" in mm. @param min_radius_mm  Thinner ones are left out.
[[nodiscard]] std::vector<VesselEnd> vessel_ends(const Polylines& lines, double min_radius_mm,
                                                 std::span<const Opening> openings);
/// Tries where the ends can be cut, one alone at a time.
/// @param lines  Those of the ends. @param cuts  Of the image so far. @param enough  No more than so many
/// that can be. Cost: up to three times refusal_of_cut() for each end.
void try_cuts(const LabelImage& image, const Polylines& lines, std::span<const CutPlane> cuts,
              std::size_t enough, std::vector<VesselEnd>& ends);

/// The same of the largest piece of an image, but for ends less than a voxel in radius; none where there is
/// no centerline. Cuts are tried at `enough` of them. Cost and threads: as extract_centerline() and
/// try_cuts().
[[nodiscard]] std::vector<VesselEnd> vessel_ends(const LabelImage& image, std::span<const CutPlane> cuts,
                                                 std::span<const Opening> openings, std::size_t enough,
                                                 Context& context);

/// "x,y,z", as the option `cut_at` takes it.
[[nodiscard]] std::string cut_place_text(const Vec3& place_mm);

/// A line that says how to open the widest one that can be cut; empty without any.
[[nodiscard]] std::string dead_end_warning(std::span<const VesselEnd> ends);

/// A line for an image whose vessels have one opening or none, but which has vessel ends; empty otherwise.
/// @param cuts  That were made of it.
[[nodiscard]] std::string closed_vessel_warning(const LabelImage& image, std::span<const CutPlane> cuts,
                                                std::span<const Opening> openings, Context& context);

/// A line for a closed surface with one flat end or none, through which nothing flows; empty otherwise.
/// @param patches  Of the surface.
/// @param ends  Its flat ends.
[[nodiscard]] std::string closed_surface_warning(std::span<const Patch> patches,
                                                 std::span<const FlatEnd> ends);
/// The same of the surface's domain.
[[nodiscard]] std::string closed_surface_warning(const Domain& domain);

/// A line for a mesh none of whose patches is an opening or a plane of symmetry, though it has flat ends, as
/// files that keep names alone leave it; empty otherwise. Cost: linear in the boundary.
[[nodiscard]] std::string walled_ends_warning(const MixedMesh& mesh);
/// Warns of that. @param path  Of the mesh.
void warn_of_walled_ends(const std::string& path, const MixedMesh& mesh, Context& context);

}  // namespace lumesh
