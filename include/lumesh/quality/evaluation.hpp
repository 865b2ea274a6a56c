#pragma once
/// @file Everything that is said about one mesh.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/core/types.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/quality/measures.hpp"

namespace lumesh {
class ImageDomain;
class Phantom;
class TetMesh;
struct Polylines;
}  // namespace lumesh

namespace lumesh::quality {

struct LabelEvaluation {
  Label label = kBackground;
  std::string name;         ///< May be empty.
  std::uint64_t cells = 0;  ///< 0 if the mesh does not have the label.
  double volume_mm3 = 0;
  std::uint64_t components = 0;
  std::int64_t euler = 0;
  SurfaceTopology surface;
  /// If there is an image. The volume is that on the kept side of the cut planes; all else is of the uncut
  /// image.
  std::optional<LabelTopology> image;
  std::optional<KeptVoxels> voxels_kept;      ///< If the image has the label.
  std::optional<SurfaceDistances> distances;  ///< If there is an image and the mesh has the label.
  std::optional<LabelReference> reference;    ///< If there is a phantom.

  /// True if the mesh does not have the label although its image has voxels of it that no plane cut off.
  [[nodiscard]] bool lost() const { return cells == 0 && !(image && image->volume_mm3 <= 0); }
  /// Hollows inside the label's cells, and tunnels through them; none unless their surface is a closed
  /// manifold.
  [[nodiscard]] std::optional<std::int64_t> cavities() const;
  [[nodiscard]] std::optional<std::int64_t> handles() const;
  /// Relative error of the volume in per cent against the image's voxels; against the exact volume, which no
  /// plane cuts. Only if there.
  [[nodiscard]] double image_volume_error_percent() const;
  [[nodiscard]] double reference_volume_error_percent() const;
};

/// Measures of the mesh as a whole against the image.
struct ImageEvaluation {
  ImageFrame frame;
  double voxel_size_mm = 1;
  LabelTopology all;                          ///< Topology of the union of its labels, as of each label.
  KeptVoxels background_kept;                 ///< Background voxels near the object that no cell holds.
  KeptVoxels voxels_kept;                     ///< Voxels kept of all labels and the background.
  std::optional<SurfaceDistances> distances;  ///< Distances of the union; none if the mesh has no surface.
};

struct Evaluation {
  MeshInfo info;
  std::vector<std::string>
      warnings;  ///< Reasons that make figures doubtful or leave some out; a caller may add.
  std::size_t cut_planes = 0;
  std::vector<std::string> problems;  ///< Faults that make the mesh invalid, the first ones; empty if valid.
  std::uint64_t problem_count = 0;
  MeshStatistics statistics;
  bool has_metric = false;                 ///< The mesh carries a metric and has tetrahedra.
  std::optional<MetricStatistics> metric;  ///< None without a metric, or with a bad one (see warnings).
  std::vector<LabelEvaluation> labels;     ///< Labels of the mesh and of the image, ascending.
  SurfaceTopology boundary;      ///< Topology of the mesh's whole boundary, without the interfaces inside.
  std::uint64_t components = 0;  ///< Components of the mesh as a whole.
  std::int64_t euler = 0;
  std::uint64_t interface_triangles = 0;
  std::vector<PatchSummary> patches;
  CurvatureSummary curvature;  ///< Curvature of the outer surface without openings.
  std::optional<ImageEvaluation> image;
  /// Narrowest section of each branch; none without an image or without axes.
  std::optional<std::vector<NarrowestSection>> sections;
  /// Where the mesh is cut off, against the image's boundary; none without an image, or where the mesh says
  /// nothing of patches.
  std::optional<OpeningsCompared> openings;
  /// Differences of the labels' topology from their voxels', in words; empty with cuts, which voxels do
  /// not know of.
  std::vector<std::string> topology_differences;
  std::vector<TopologyPlace> topology_places;  ///< Places of that.
  std::optional<double> reference_voxel_mm;    ///< Voxel size of the phantom, if there is one.

  [[nodiscard]] bool valid() const { return problem_count == 0; }
  /// Volume of all labels together, mm^3, and its relative error in per cent against the image's voxels, if
  /// there.
  [[nodiscard]] double volume_mm3() const;
  [[nodiscard]] double image_volume_error_percent() const;
};

struct EvaluationInput {
  const LabelImage* image = nullptr;  ///< Optional: the image the mesh was made from.
  /// Optional: where the image was extended, its frame before, in which voxels are numbered.
  const ImageFrame* given_frame = nullptr;
  const ImageDomain* domain =
      nullptr;  ///< Optional: the image's with the cut planes; else made, by default options.
  const Phantom* phantom = nullptr;  ///< Optional: the truth behind the image.
  std::vector<CutPlane> cut_planes;  ///< Cut planes that the mesh was made with.
  /// Optional: axes of the image's vessels with the scalar "radius", as extract_centerline() makes them.
  const Polylines* axes = nullptr;
  /// Optional: the mesh whose view is measured, with all its boundary faces. Its adjacency spares finding all
  /// faces anew: half of the time, and 200 bytes per tetrahedron.
  const TetMesh* kernel = nullptr;
};

/// @param mesh  In mm (LPS) as the image. A metric that is not positive definite is warned of, in the
///              context and in `warnings`; all other figures are there.
/// @throws Error{kBadInput} if the mesh has no cells.
/// Threads: parallel inside, bitwise identical for every thread count. Phases are timed in the context.
[[nodiscard]] Evaluation evaluate(const MeshView& mesh, const EvaluationInput& input, Context& context);

}  // namespace lumesh::quality
