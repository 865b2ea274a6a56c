#pragma once
/// @file A closed surface in regions, each with the patch that it is, and the flat ends among them.

#include <span>
#include <string>
#include <vector>

#include "closed_surface.hpp"
#include "feature_regions.hpp"
#include "flat_regions.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "room_behind.hpp"

namespace lumesh::surfaces {

struct NamedRegions {
  /// @throws Error{kBadInput}, Error{kUsage} as SurfaceDomain.
  NamedRegions(const SurfaceView& view, const SurfaceDomainOptions& options);

  ClosedSurface surface;
  FeatureRegions regions;
  Box3 box;
  double mean_edge_mm;
  double resolution_mm;
  bool has_named_patches = false;  ///< Several, without caps.
  std::vector<Patch> of_region;
  std::vector<FlatEnd> ends;
  std::vector<std::string> notes;  ///< Lines on patches of the file that are hardly what they were meant for,
                                   ///< and on steps that are no ends.

 private:
  void name_regions();
  void leave_out_steps(std::vector<RegionShape>& shapes);
  void leave_out_sides(std::vector<RegionShape>& shapes);
  [[nodiscard]] static bool is_facet(const RegionShape& shape, double largest_mm2, const RoomBehind& room,
                                     std::span<const std::uint32_t> triangles);
  void note_left_out(std::vector<RegionShape>& shapes, std::span<const std::uint32_t> pieces,
                     const char* why);
  void note_pieces(std::span<const RegionShape> shapes);
  void note_missed_ends();
  void note_bent_ends();
  void note_doubts(std::span<const RegionShape> shapes);
  [[nodiscard]] const Patch* patch_of_file(std::int32_t number) const;
  [[nodiscard]] bool is_cap_of_file(std::int32_t number) const;
  [[nodiscard]] bool is_end_of_vessel(std::uint32_t region, const RegionShape& shape) const;
  [[nodiscard]] std::string name_of_file(std::uint32_t region) const;
  [[nodiscard]] std::vector<std::array<Vec3, 3>> triangles_of(std::uint32_t region) const;
  [[nodiscard]] std::string free_opening_name();
  void keep_kind_of_file(std::uint32_t region, Patch& patch) const;

  std::vector<Patch> patches_;
  std::size_t named_openings_ = 0;
};

}  // namespace lumesh::surfaces
