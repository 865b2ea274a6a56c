#pragma once
/// @file Vessels that touch in an image, and other thin places: where they are, and voxels changed for them.
///
/// All labels count as one object. It is parted into chunks, about as long as it is thick, by flooding its
/// distance from the background from the middles of balls (Meyer 1994, doi:10.1016/0165-1684(94)90060-4).
/// Where the way from one chunk to the next is much thinner than both is a neck. Vessels touch at a neck, or
/// a voxel apart, where those on both sides of it go on in two directions, seen from the wall or from the
/// axis; ends and narrowings do not, nor do parts of one section that is nowhere narrower between them.

#include <cstdint>
#include <vector>

#include "lumesh/image/label_image.hpp"

namespace lumesh {

/// A place where the object is thin, or nearly joined.
struct ThinPlace {
  enum class Kind : std::uint8_t {
    kTouching,  ///< Vessels side by side share voxel faces there.
    kNear,      ///< Vessels a voxel apart, or with edges and corners only.
    kBridge,    ///< One or two voxels thick between thicker parts.
  };
  Kind kind = Kind::kTouching;
  Index3 voxel = Index3::Zero();  ///< In its middle.
  std::size_t size = 0;           ///< Voxel faces that are shared, or voxels between.
};

/// Largest first, within each kind. Threads: same result for every number of them. Cost: O(n log n) in the
/// object's voxels. Memory: 14 bytes a voxel of the object's box, 12 for each of the object.
[[nodiscard]] std::vector<ThinPlace> find_thin_places(const LabelImage& image);

/// Voxels that got another label.
struct VoxelsChanged {
  std::size_t voxels = 0, places = 0;
  double volume_mm3 = 0;          ///< Volume of the voxels.
  Index3 first = Index3::Zero();  ///< The first in memory.
};

/// Separates the vessels that touch: a layer of voxels between them becomes background, two where they share
/// a broad area and are not thin.
VoxelsChanged separate_touching(LabelImage& image);
/// Joins the vessels that touch or are near. They keep their labels; voxels between them get the label that
/// most voxels around them have.
VoxelsChanged join_touching(LabelImage& image);

/// A piece of background, 26-connected, that the object encloses: it reaches neither the border of the image
/// nor that of the object's box.
struct Cavity {
  std::size_t voxel_count = 0;
  Index3 first = Index3::Zero();  ///< The voxel that comes first in memory.
};
/// Cavities of an image, in no particular order. Any number of threads may call it at the same time.
[[nodiscard]] std::vector<Cavity> find_cavities(const LabelImage& image);

/// Cavities filled: each as find_cavities() tells them gets the label that most voxels beside it have, the
/// smallest such label where several have as many.
/// @return Counts of the voxels filled and of the cavities, and their volume in mm^3. One thread; no other
/// may use the image meanwhile.
VoxelsChanged fill_cavities(LabelImage& image);

/// Makes background of components of all labels together that have fewer voxels.
VoxelsChanged drop_small_components(LabelImage& image, std::size_t below);

/// A place where a label that another encloses comes to the background.
struct WallHole {
  Label inside = kBackground, wall = kBackground;
  std::size_t faces = 0;  ///< Between the inside and the background, joined through their corners.
  Index3 voxel = Index3::Zero();
};

/// Holes in the walls of enclosed labels, the one with the most voxel faces first. A label counts as enclosed
/// if nine in ten of its faces to anything else, but for the image's border, are the wall's.
/// Threads: any number at the same time.
[[nodiscard]] std::vector<WallHole> find_wall_holes(const LabelImage& image);

}  // namespace lumesh
