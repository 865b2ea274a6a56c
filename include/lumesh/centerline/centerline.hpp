#pragma once
/// @file The axes of a vessel tree with the radius of the vessel around them, without clicks.
///
/// Lines run from opening to opening. An opening is where the object leaves the image or is cut, or a patch
/// of a mesh that is an opening; vessels that end inside count as well. A tree of paths with a centring cost
/// through the voxels says which vessels there are; then a tube is fitted to the wall around each of them,
/// robustly, so that a side sac or the mouth of a branch, which the tube does not explain, leaves its line
/// where the vessel is.

#include <span>

#include "lumesh/core/context.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"

namespace lumesh {

class OptionList;

/// Options of extract_centerline(); describe() says what each means and which values it takes.
struct CenterlineOptions {
  double spacing_mm = 0;
  double shortest_tip = 2;
  double voxel_mm = 0;

  void describe(OptionList& list);
  void validate() const;  ///< Throws Error{kUsage}, naming the field.
};

/// The lines of everything in the image that is not background, of its largest piece of voxels joined by
/// faces.
///
/// @return Lines in the image's physical millimetres (LPS) with the scalars "radius" (mm: of the tube,
/// without sacs)
///         and "branch" (0: the main vessel, from the widest opening on; the line's number else). A branch
///         begins on a point of the line that it leaves. Ends at openings lie on the outer faces of the
///         border voxels; other ends at the centre of the last ball that fits. A ring that nothing leaves is
///         a line whose last point is its first.
/// @throws Error{kBadInput} if no voxel is foreground, or nothing is longer than wide. Warns if pieces are
/// left out. Threads: parallel, bitwise identical for every thread count. Cost: a scan of the image, then
/// linear (but for a logarithm) in the voxels of the object. Memory: about 60 bytes for each of those.
/// Sources: Sato et al. 2000, doi:10.1109/PCCGA.2000.883951 (paths, TEASAR); Antiga et al. 2003,
/// doi:10.1109/TMI.2003.812261 (cost by the inscribed radius); Geman and McClure 1987 (weights).
[[nodiscard]] Polylines extract_centerline(const LabelImage& image, const CenterlineOptions& options,
                                           Context& context);

/// The lines of the part of an image that lies before all planes; the sections in these are openings, too,
/// and lines end in the planes. Return, errors, threads and cost are those of the function above.
///
/// @param cuts  Planes that cut the image, as cut_off() and ImageDomain::cut_planes() have them.
[[nodiscard]] Polylines extract_centerline(const LabelImage& image, std::span<const CutPlane> cuts,
                                           const CenterlineOptions& options, Context& context);

/// The lines of the volume inside a mesh's boundary triangles and quadrilaterals; where there are none, of
/// its tetrahedra. Patches of kind kOpening, or with names that begin with "inlet" or "outlet", are openings,
/// and ends lie on their planes; interfaces do not count. Coordinates of the mesh in mm.
///
/// @return As for images, in the mesh's coordinates.
/// @throws Error{kBadInput} if the mesh has neither, or its boundary encloses nothing. Threads: parallel,
/// bitwise identical for every thread count. Cost: the volume is cut into voxels first (voxel_mm), then as
/// for an image of them.
[[nodiscard]] Polylines extract_centerline(const MeshView& mesh, const CenterlineOptions& options,
                                           Context& context);

}  // namespace lumesh
