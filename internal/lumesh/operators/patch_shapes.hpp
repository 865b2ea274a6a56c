#pragma once
/// @file Shapes of patches: the changes allowed to the vertices and faces of each.

#include <memory>
#include <utility>
#include <vector>

#include "lumesh/domain/surface.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {
class ImageDomain;
}

namespace lumesh::operators {

enum class PatchFreedom : std::uint8_t {
  kFrozen,  ///< The patch's faces, edges and vertices stay as they are.
  kPlane,   ///< A part of a plane: vertices may move, come and go within it.
  kCurved,  ///< A part of a smooth surface: as kPlane, and every vertex that comes or moves is put on it.
};

struct PatchShape {
  PatchFreedom freedom = PatchFreedom::kFrozen;
  Vec3 normal = Vec3::Zero();                ///< Unit normal of a plane.
  double offset = 0;                         ///< Offset of a plane: normal . point for its points.
  std::shared_ptr<const Surface> surface{};  ///< Surface of a curved patch.
  /// Whether the vertices of a curved patch stand over the surface in the end, by the sagitta of the
  /// triangles around, so that these have the volume that the surface encloses (settling.hpp).
  bool keeps_volume = false;
  /// Curves where it meets other patches, where their surfaces do not say so by themselves.
  std::vector<std::pair<PatchId, std::shared_ptr<const MeshCurve>>> curves{};
};

/// One shape per patch of the mesh.
using PatchShapes = std::vector<PatchShape>;

/// A plane for every patch whose faces lie in one to within `tolerance` times the size of the mesh's box; the
/// others are frozen. Where every face lies along a coordinate plane, the normal is exactly an axis.
[[nodiscard]] PatchShapes planes_where_flat(const TetMesh& mesh, double tolerance = 1e-10);

/// The property of a mesh that the smooth surface of a patch keeps.
enum class SurfaceKeeps : std::uint8_t {
  kVertices,  ///< Vertices: the surface goes through them, as where the input was sampled from a surface.
  kVolume,    ///< Volume: the surface encloses that of the triangles, and passes between their corners:
              ///< whatever the edges become, the mesh keeps its volume.
};

/// planes_where_flat(); of the other patches on the outside, a cylinder for every one whose vertices lie on
/// one to within the tolerance, and for the rest a smooth surface (MeshSurface) along the vertices as they
/// are now. Patches between labels that are not flat are frozen.
[[nodiscard]] PatchShapes shapes_of_patches(const TetMesh& mesh, double tolerance = 1e-10,
                                            SurfaceKeeps keeps = SurfaceKeeps::kVertices);

/// Has the patches of the outside that follow the smooth surface of the mesh follow the boundary of its image
/// instead, where that is within 1.5 voxels, moved outwards by as much as the mesh's triangles, or its
/// vertices if that is less, lie outside it on average: the mesh keeps its volume. Curves where patches meet
/// stay as they are. Patches of several labels keep the surface of the mesh.
/// @return the number of patches that follow the image.
/// @throws Error{kBadInput} if the image lacks a label, or the mesh lies off its boundary for the most part;
/// the text speaks of the image: the caller adds the file name.
std::size_t follow_image(const TetMesh& mesh, const std::shared_ptr<const ImageDomain>& domain,
                         PatchShapes& shapes);

/// Height, in the metric, of the arc of a curved patch over edge (corner i, corner j) of t; estimated from
/// the normals at its ends. 0 where no face of t with that edge belongs to a curved patch.
[[nodiscard]] double arc_height(const TetMesh& mesh, TetId t, int i, int j, const PatchShapes& shapes);

/// Shapes of patches that are all frozen.
[[nodiscard]] PatchShapes all_frozen(const TetMesh& mesh);

}  // namespace lumesh::operators
