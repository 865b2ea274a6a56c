#pragma once
/// @file Wanted edge lengths of a mesh, and those that need no plugin. Lengths in mm; all factories throw
/// Error{kUsage} for a parameter that makes no sense, and Error{kBadInput} for data that make none, in one
/// line that names it.

#include <array>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

class OptionList;

class Domain;
struct Polylines;
class TetMesh;

/// Wanted edge lengths in mm. Const calls from any thread; the same answer to the same question.
class Sizing {
 public:
  Sizing() = default;
  Sizing(const Sizing&) = delete;
  Sizing& operator=(const Sizing&) = delete;
  virtual ~Sizing() = default;

  /// Wanted edge length at a point inside a label, > 0, or infinite where any size will do.
  [[nodiscard]] virtual double size_at(const Vec3& point_mm, Label label) const = 0;
  /// True if the tetrahedron with these corners is too large for a reason that sizes do not express.
  [[nodiscard]] virtual bool wants_finer(const std::array<Vec3, 4>& /*corners_mm*/) const { return false; }
  /// Whether wants_finer() may be true of anything.
  [[nodiscard]] virtual bool has_criterion() const { return false; }
  /// Warnings about the answers so far, one line each. Not while other threads ask.
  [[nodiscard]] virtual std::vector<std::string> warnings() const { return {}; }
};

inline constexpr double kAnySize = std::numeric_limits<double>::infinity();

struct LabelSizeOptions {
  std::map<Label, double> sizes_mm = {};  ///< Sizes > 0 inside labels.
  double elsewhere_mm = kAnySize;         ///< Size inside the labels that are not named.

  void describe(OptionList& list);  ///< Describes the sizes of labels that are named.
};

/// One size per label. Cost of a call: 4 ns.
[[nodiscard]] std::unique_ptr<Sizing> size_per_label(const LabelSizeOptions& options);

struct PointSizeOptions {
  int k = 1;                     ///< Nearest points whose mean distance counts; 0: 1.
  double factor = 1;             ///< Size per that distance, > 0.
  double floor_mm = 0;           ///< Smallest size; > 0 for k = 1, when the points themselves have it.
  double ceiling_mm = kAnySize;  ///< Largest size, >= floor.
  Box3 region_mm = {};  ///< Region where sizes will be asked (Domain::bounds_mm()); answers elsewhere
                        ///< are right, but slow far from the points.

  void describe(OptionList& list);  ///< Describes all but the region.
  void validate() const;            ///< Throws Error{kUsage}, naming the option.
};

/// A size that grows with the distance to points, such as those of centerlines or landmarks: factor *
/// distance, at most 1 % more, held within floor and ceiling. The distance is that to the nearest point, or
/// the mean of those to the k nearest; points at one place count once. Cost of a call: about 60 ns for 5,000
/// points (190 ns if places come in random order), 3 us for k = 30; of the preparation: 0.7 s for k = 1.
[[nodiscard]] std::unique_ptr<Sizing> size_from_points(std::span<const Vec3> points_mm,
                                                       const PointSizeOptions& options);

struct PointCriterionOptions {
  double adapt_const = 2;  ///< Largest metric length of an edge, > 0; 2 is the paper's.
  double floor_mm = 0;     ///< Edges need not be shorter; 0: the criterion alone says how short.
  double bound_mm =
      0;  ///< Taken as the floor, with a warning, where there is none and the criterion has no end.
  Box3 region_mm = {};  ///< As PointSizeOptions::region_mm.

  void describe(OptionList& list);  ///< Describes adapt_const.
};

/// No size, but a criterion for tetrahedra: an edge may be `adapt_const` long in the mean of the tensors of
/// its ends, each the identity over the squared distance to the nearest point. Algorithm 3 of the paper,
/// PODM's Function Approximation. Distances are exact. Cost of a call: 0.3 us.
[[nodiscard]] std::unique_ptr<Sizing> criterion_from_points(std::span<const Vec3> points_mm,
                                                            const PointCriterionOptions& options);

struct BoundarySizeOptions {
  double at_boundary_mm = 0;  ///< Size at the boundary, > 0.
  double growth = 0.2;        ///< Growth of the size per distance from the boundary, >= 0.
  double ceiling_mm = kAnySize;

  void describe(OptionList& list);  ///< Describes all but the ceiling.
};

/// A size that grows with the distance to the nearest boundary between materials, openings included.
/// Distances are those of the domain near the boundary; further in, of a grid of at most two million points,
/// a few per cent off. Reads the domain at construction and later: it has to live as long. Cost of a call:
/// about 140 ns, 320 ns near the boundary.
[[nodiscard]] std::unique_ptr<Sizing> size_from_boundary(const Domain& domain,
                                                         const BoundarySizeOptions& options);

/// Sizes at the centres of voxels; 0 or infinity: any size.
struct SizeImage {
  ImageFrame frame;
  std::vector<float> sizes_mm;  ///< frame.voxel_count(), i runs fastest.
};

/// Trilinear interpolation between the centres of voxels with a size; outside, the size at the border's
/// nearest place. Cost of a call: up to 160 ns, most of it for memory.
[[nodiscard]] std::unique_ptr<Sizing> size_from_image(SizeImage image);

/// Sizes at the vertices of a background mesh, interpolated geometrically, as all metrics here; outside, the
/// size at the mesh's nearest point.
/// @param background  Compact. @param sizes_mm  One per vertex, > 0 and finite.
/// Cost of a call: about 1 us; 1 us more outside the mesh.
[[nodiscard]] std::unique_ptr<Sizing> size_from_mesh(TetMesh background, std::span<const double> sizes_mm);

/// Option of size_from_axes(), which meshers have that make sizes of their own of it, too; 0: not given.
void describe_cells_per_diameter(OptionList& list, double& cells);

/// A given number of edges along the diameter of the vessel: 2 r / cells, with the radius r of the axis that
/// is the fewest of its radii away. A sac has the size of the vessel that it hangs on. Cost of a call: about
/// 1 us.
/// @param axes  With the scalar "radius" in mm, as extract_centerline() makes them; at least one point.
[[nodiscard]] std::unique_ptr<Sizing> size_from_axes(const Polylines& axes, double cells_per_diameter);

/// The smallest of several sizes, finer if any wants it, with the warnings of all. None at all: any size.
[[nodiscard]] std::unique_ptr<Sizing> combined_size(std::vector<std::unique_ptr<Sizing>> parts);

}  // namespace lumesh
