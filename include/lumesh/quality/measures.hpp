#pragma once
/// @file Measures of a mesh: its cells, surfaces and labels, how it fits its metric, and how far it is from
/// its image.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh::quality {

/// Equal bins over [low, high]; what lies outside falls into the first or the last.
struct Histogram {
  double low = 0;
  double high = 1;
  std::vector<std::uint64_t> counts;

  void add(double value);
  /// Adds bin by bin; both have the same range and bins.
  void merge(const Histogram& other);
  [[nodiscard]] double bin_width() const { return (high - low) / static_cast<double>(counts.size()); }
  [[nodiscard]] std::uint64_t total() const;
};

/// An extreme value and the tetrahedron that has it.
struct Extreme {
  double value = 0;
  std::uint32_t tetrahedron = 0;  ///< Index; the lowest among equals.
  Vec3 centre_mm = Vec3::Zero();
};

/// Quality of the tetrahedra. Zero everywhere if there are none.
struct TetrahedronStatistics {
  std::uint64_t count = 0;
  std::uint64_t inverted = 0;  ///< Volume <= 0.
  Extreme smallest_dihedral_deg;
  Extreme largest_dihedral_deg;
  double mean_smallest_dihedral_deg = 0;  ///< Mean over the tetrahedra of each one's smallest angle.
  Histogram dihedral_deg;                 ///< The six angles of each; 180 bins over [0, 180].
  std::uint64_t below_5_deg = 0;          ///< Tetrahedra with an angle below 5 degrees; and so on.
  std::uint64_t below_10_deg = 0;
  std::uint64_t below_15_deg = 0;
  std::uint64_t above_150_deg = 0;
  std::uint64_t above_160_deg = 0;
  std::uint64_t above_165_deg = 0;
  Extreme smallest_mean_ratio;  ///< 12 (3V)^(2/3) / sum of squared edges; 1 for the regular tetrahedron.
  double mean_mean_ratio = 0;
  Histogram mean_ratio;     ///< 50 bins over [0, 1].
  Extreme largest_aspect;   ///< Longest edge / (2 sqrt(6) inradius); infinite for a flat one.
  double mean_aspect = 0;   ///< Over those that are not flat.
  double mean_edge_mm = 0;  ///< Over the six edges of each tetrahedron.
};

struct LabelVolume {
  Label label = kBackground;
  std::uint64_t cells = 0;
  double volume_mm3 = 0;
};

struct MeshStatistics {
  std::uint64_t vertices = 0;
  std::uint64_t pyramids = 0;
  std::uint64_t prisms = 0;
  std::uint64_t hexahedra = 0;
  TetrahedronStatistics tetrahedra;
  double smallest_scaled_jacobian =
      1;  ///< Of the other cells: least over their corners, 1 for a cube; 1 if none.
  std::uint64_t inverted_cells = 0;  ///< Of any shape: volume, or Jacobian at a corner, not positive.
  std::vector<LabelVolume> labels;   ///< By ascending label.
  Vec3 low_mm = Vec3::Zero();        ///< Bounding box of the points.
  Vec3 high_mm = Vec3::Zero();
};

/// Tetrahedra with a mean ratio below this are counted as poor.
inline constexpr double kPoorMeanRatio = 0.1;

/// Some of the edges, by the band [1/sqrt(2), sqrt(2)] of lengths that count as unit.
struct EdgeBand {
  std::uint64_t edges = 0;
  std::uint64_t short_edges = 0;  ///< Below the band.
  std::uint64_t long_edges = 0;   ///< Above it.

  /// Shares of the edges; not a number if there are none.
  [[nodiscard]] double fraction_short() const { return share(short_edges); }
  [[nodiscard]] double fraction_long() const { return share(long_edges); }
  [[nodiscard]] double fraction_in_band() const { return share(edges - short_edges - long_edges); }

 private:
  [[nodiscard]] double share(std::uint64_t count) const {
    return static_cast<double>(count) / static_cast<double>(edges);
  }
};

/// Statistics of the tetrahedra only. Metric lengths have no unit; an edge as long as the metric asks for
/// has 1.
struct MetricStatistics : EdgeBand {  // Distinct edges: one of many tetrahedra counts once, as below.
  /// Edges with an end that is on no boundary face of the view: what an adaptation that keeps the surface can
  /// change. None if the view has no boundary faces.
  std::optional<EdgeBand> free_edges;
  double shortest_edge = 0;
  double longest_edge = 0;
  double mean_edge = 0;
  Histogram edge_length;  ///< 80 bins over [0, 2 sqrt(2)]: 1/sqrt(2) and sqrt(2) are borders of bins.
  Extreme
      smallest_mean_ratio;  ///< 1 for a tetrahedron that is regular in its metric; -1 if flat or inverted.
  double mean_mean_ratio = 0;
  std::uint64_t poor_tetrahedra = 0;  ///< With a mean ratio below kPoorMeanRatio.
  Histogram mean_ratio;               ///< 50 bins over [0, 1].
  double complexity = 0;
  std::uint64_t vertices = 0;  ///< Vertices of tetrahedra.
  std::uint64_t tetrahedra = 0;

  [[nodiscard]] double vertices_per_complexity() const { return static_cast<double>(vertices) / complexity; }
  [[nodiscard]] double tetrahedra_per_complexity() const {
    return static_cast<double>(tetrahedra) / complexity;
  }
};

/// Shapes of the cells of layers: tetrahedra, pyramids and prisms alike. Zero everywhere if there are none.
struct FlatCellShapes {
  std::uint64_t cells = 0;
  double smallest_dihedral_deg = 0;  ///< Between two faces; where one is bent, between their edges' planes.
  double largest_dihedral_deg = 0;
  double mean_aspect = 0;  ///< Longest edge through least height; over cells of positive volume.
  double largest_aspect = 0;
};

/// One connected piece of a surface (connected through edges).
struct SurfaceComponent {
  std::uint64_t triangles = 0;
  double area_mm2 = 0;
  double enclosed_volume_mm3 = 0;  ///< Signed: negative for the wall of a hollow.
  std::int64_t euler = 0;          ///< V - E + F of this piece.
  std::int64_t genus = 0;  ///< (2 - euler) / 2: handles; only if the piece is closed and manifold, else -1.
};

struct SurfaceTopology {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t open_edges = 0;  ///< Edges with one triangle.
  std::uint64_t non_manifold_edges =
      0;  ///< Edges with more than two triangles, or two that disagree on sides.
  std::uint64_t non_manifold_vertices = 0;   ///< Vertices whose triangles do not form one ring.
  std::vector<SurfaceComponent> components;  ///< By descending area.

  [[nodiscard]] bool closed() const { return open_edges == 0; }
  [[nodiscard]] bool manifold() const {
    return open_edges == 0 && non_manifold_edges == 0 && non_manifold_vertices == 0;
  }
  [[nodiscard]] std::int64_t genus() const;  ///< Sum over the components; -1 if one has none.
};

/// Figures of a named patch.
struct PatchSummary {
  std::string name;
  PatchKind kind = PatchKind::kWall;
  FlowSide flow = FlowSide::kUnknown;
  std::uint64_t faces = 0;
  double area_mm2 = 0;
  Vec3 centre_mm = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< Area-weighted mean, unit length; zero if the patch closes on itself.
  double smallest_angle_deg =
      180;                 ///< Smallest angle of its triangles; 0 if one has two corners in one place.
  double flatness_mm = 0;  ///< Largest distance of a vertex to the best plane (meaningful for openings).
};

/// Measures weighted by area.
struct CurvatureSummary {
  std::uint64_t vertices = 0;  ///< With a curvature.
  double root_mean_square_per_mm = 0;
  double mean_per_mm = 0;
  double p2_per_mm = 0;  ///< 2 % of the area have less.
  double p98_per_mm = 0;
};

/// Distances of one set of samples.
struct DistanceSummary {
  double max = 0;
  double mean = 0;  ///< Weighted by area.
  double p95 = 0;   ///< 95 % of the area is nearer.
  std::uint64_t samples = 0;
  Vec3 worst_mm = Vec3::Zero();  ///< Place of the maximum.
};

/// Distances of one label, or of the union of all.
struct SurfaceDistances {
  /// From the mesh surface to the squares between voxels of different labels; exact from points on every
  /// triangle: its corners, and the centres of n^2 equal parts, n >= 2 and so many that no part has an edge
  /// above half a voxel.
  DistanceSummary mesh_to_image_mm;
  /// From those squares (their centres; for the maximum also their corners) to the triangles of the mesh
  /// surface; exact.
  DistanceSummary image_to_mesh_mm;
  /// Two-sided Hausdorff distance between the vertices of the mesh surface and the centres of the boundary
  /// voxels (those with one of six neighbours in another label): the measure of the paper. Half a voxel's
  /// diagonal and half the distance of the vertices are in it by nature.
  double vertex_to_voxel_two_sided_mm = 0;
  double vertices_to_voxels_mm = 0;  ///< One side of it.
  double voxels_to_vertices_mm = 0;  ///< The other.
};

/// A voxel whose centre is not where its label is in the mesh.
struct MissedVoxel {
  double distance_mm = 0;  ///< From its centre to the boundary of its label in the mesh.
  Vec3 centre_mm = Vec3::Zero();
  std::optional<Index3>
      voxel;  ///< Index in the image that was given; none beyond it, as where it is extended.
};

/// Voxels of one label, of the background, or of all, by their centres.
struct KeptVoxels {
  std::uint64_t counted = 0;
  std::uint64_t kept = 0;            ///< Voxels of these in a cell of their label, or, background, in none.
  std::optional<MissedVoxel> worst;  ///< The farthest; of equals the first in memory. None if nothing is
                                     ///< missed, or the mesh does not have the label.

  /// Not a number if no voxel is counted.
  [[nodiscard]] double share() const { return static_cast<double>(kept) / static_cast<double>(counted); }
};

/// Truth about one label, and how far the mesh is from it.
struct LabelReference {
  Label label = kBackground;
  double volume_mm3 = 0;  ///< Exact.
  int components = 0;
  int euler = 0;
  /// Distances of points on the mesh surface to the exact one (corners and centres of equal parts of each
  /// triangle, no part's edge above one voxel). None if the mesh does not have the label.
  std::optional<DistanceSummary> surface_distance_mm;
  /// The other way: from places of the exact surface, one for each square between voxels of the phantom's
  /// image, to the mesh. What the mesh lacks shows here.
  std::optional<DistanceSummary> truth_to_mesh_mm;
  /// Angles between each triangle's normal and that of the exact surface at the point nearest to its centre;
  /// flat cuts are left out.
  std::optional<DistanceSummary> normal_angle_deg;
};

/// A branch counts as tightened if its mesh is narrower than its voxels by more than this, as widened if it
/// is wider by more than that: the least area of voxels' stairs is some per cent too small.
inline constexpr double kTightenedPercent = 3, kWidenedPercent = 10;

/// The section of one branch with the least area in the mesh, on a plane square to the branch's axis.
struct NarrowestSection {
  std::size_t branch = 0;          ///< Number of the line.
  Vec3 centre_mm = Vec3::Zero();   ///< On the axis.
  Vec3 direction = Vec3::UnitZ();  ///< Direction of the axis: the plane's unit normal.
  double mesh_area_mm2 = 0;        ///< Mean over five parallel planes within one voxel; 0 if the mesh is not
                                   ///< there.
  double voxel_area_mm2 = 0;       ///< On the same planes.

  /// Excess of the mesh's area over that of the voxels; negative: it is narrower.
  [[nodiscard]] double change_percent() const { return 100 * (mesh_area_mm2 / voxel_area_mm2 - 1); }
  [[nodiscard]] bool tightened() const { return change_percent() < -kTightenedPercent; }
  [[nodiscard]] bool widened() const { return change_percent() > kWidenedPercent; }
};

/// A way in which the topology of a label differs from that of its voxels.
enum class TopologyChange : std::uint8_t {
  kExtraPiece,    ///< A piece of the label's cells that holds no centre of its voxels.
  kMissingPiece,  ///< A piece of the voxels with no centre in the label's cells.
  kJoined,        ///< Two pieces of voxels are one in the mesh.
  kSplit,         ///< One piece of voxels is two in the mesh.
  kFilled,        ///< A handle or cavity changes where the mesh is and the voxels are not.
  kCut,           ///< One changes where the voxels are and the mesh is not.
};

/// One change of one label.
struct TopologyPlace {
  Label label = kBackground;
  TopologyChange change = TopologyChange::kExtraPiece;
  Vec3 centre_mm =
      Vec3::Zero();  ///< Middle of the piece; where the parts meet; middle of what is cut or filled.
  VoxelBox box;  ///< Around the piece; the place alone of kJoined and kSplit; around what is cut or filled.
  std::uint64_t cells = 0;   ///< Cells of the extra piece, or of the smaller one that was split off.
  std::uint64_t voxels = 0;  ///< Voxels of the missing piece, or of the smaller one that was joined.
  double volume_mm3 = 0;     ///< Volume of these, or of what is cut or filled.
  std::int64_t handles = 0,
               cavities = 0;  ///< More than in the voxels; one of the two only, where both can be.
};

}  // namespace lumesh::quality
