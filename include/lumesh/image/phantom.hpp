#pragma once
/// @file Synthetic images of which the truth is known: vessels and bodies given by exact distance functions.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/core/types.hpp"
#include "lumesh/image/label_image.hpp"

namespace lumesh {

class OptionList;

enum class PhantomKind : std::uint8_t {
  kCarotid,      ///< Siphon with a sac and three tapering branches, cut by the image border. Label 1.
  kBifurcation,  ///< Middle cerebral artery: parent, two daughters, dome at the apex, cut by the border.
                 ///< Label 1.
  kLayered,  ///< Ball (1), thin wall around it (2), block (3) whose top face cuts the wall's ball in halves.
  kSphere,   ///< Label 1, at the centre of the image.
  kTorus,    ///< Label 1, at the centre, in the plane of i and j.
};

/// "carotid", "bifurcation", …
[[nodiscard]] std::string_view phantom_kind_name(PhantomKind kind);
/// @throws Error{kUsage} for an unknown name; the message lists the known ones.
[[nodiscard]] PhantomKind phantom_kind_from_name(std::string_view name);

/// A phantom to make. A zero in a size, spacing, radius or wall stands for the kind's default; default radii
/// scale with the extent of the image, so that the same shape fills images of every resolution.
struct PhantomSpec {
  PhantomKind kind = PhantomKind::kSphere;
  Index3 size = Index3::Zero();      ///< Voxels, each 8 to 2048.
  Vec3 spacing_mm = Vec3::Zero();    ///< > 0.
  double radius_mm = 0;              ///< Vessel at the inlet; ball; tube of the torus.
  double end_radius_mm = 0;          ///< Smallest outlet of a vessel; <= radius_mm.
  double sac_radius_mm = 0;          ///< Sac or dome of a vessel.
  double ring_radius_mm = 0;         ///< Torus: radius of its core circle.
  double wall_mm = 0;                ///< Layered: thickness of the wall; default 2 voxels.
  double noise_voxels = 0;           ///< The boundary moves by at most this, 0 to 2 voxels (largest spacing).
  std::size_t seed = 1;              ///< Seed of the noise; its lowest 32 bits count.
  Vec3 rotation_deg = Vec3::Zero();  ///< Turns of the direction cosines about x, then y, then z.
  Vec3 origin_mm = Vec3::Zero();     ///< Centre of voxel (0, 0, 0).

  /// Describes every field but the kind.
  void describe(OptionList& list);
  /// Size, spacing and noise alone. @param prefix  Of the names, where options of other things are beside.
  void describe_image(OptionList& list, const std::string& prefix = "");
};

/// The spec with every default filled in.
/// @throws Error{kUsage}, naming the field, if a value is out of range or parts would graze each other or the
/// border.
[[nodiscard]] PhantomSpec resolve(const PhantomSpec& spec);

/// JSON text of a spec, numbers in full precision.
[[nodiscard]] std::string to_json_text(const PhantomSpec& spec);
/// The spec that a text of to_json_text() holds, lengths in mm; fields that it leaves out have their
/// defaults. Values are checked by resolve(), not here. Threads: any number at the same time.
/// @throws Error{kBadInput} that names the key, if the text is not JSON or not a phantom.
[[nodiscard]] PhantomSpec phantom_spec_from_json(std::string_view text);

/// Topology of a label in the continuum, which its voxels share as long as every radius is at least 3 voxels.
struct PhantomTruth {
  Label label = kBackground;
  int component_count = 0;
  int euler_number = 0;  ///< See image/topology.hpp.
};

/// The axis of one vessel from its first point to where it leaves the image.
struct PhantomCurve {
  std::vector<Vec3> points_mm;
  std::vector<double> radius_mm;
  int branch = 0;  ///< 0 = parent.
};

struct PhantomStreamline {
  std::vector<Vec3> points_mm;
  std::vector<Vec3> velocity_m_s;
};

/// A phantom made from a spec. Immutable, cheap to copy; const calls from any thread.
///
/// Exactness of distances (without noise): vessels are unions of round cones between points of the axis at
/// most half a voxel apart, and that union *is* the truth. Outside a label distances are exact. Inside they
/// are exact except where the nearest point of a part's own surface lies inside another part (near the groove
/// between a branch or sac and its parent): there they are a lower bound. The same holds outside label 3 of
/// the layered phantom near its sharp edge. Zero sets are exact everywhere. With noise, distances are those
/// of the smooth shape plus the noise: zero sets are exact, values are off by a factor within 1 +- 0.65
/// noise_voxels.
class Phantom {
 public:
  /// A phantom of the spec, with every default filled in. @throws Error{kUsage} as resolve().
  explicit Phantom(const PhantomSpec& spec);

  /// With every default filled in.
  [[nodiscard]] const PhantomSpec& spec() const;
  [[nodiscard]] const ImageFrame& frame() const;
  /// Labels, ascending, without the background.
  [[nodiscard]] std::vector<Label> labels() const;

  /// Label at a physical point; points outside the image see the shape as it goes on there.
  [[nodiscard]] Label label_at(const Vec3& point_mm) const;
  /// Distance to the label's surface, not cut by the image; negative inside.
  /// @throws Error{kBadInput} if the phantom has no such label (so do the functions below).
  [[nodiscard]] double signed_distance_mm(const Vec3& point_mm, Label label) const;
  /// Distance (>= 0) to the surface of the label cut flat at the outer faces of the image's border voxels.
  /// Exact where the shape meets the border at right angles, as all phantoms do; otherwise a lower bound.
  [[nodiscard]] double surface_distance_mm(const Vec3& point_mm, Label label) const;
  /// Volume of the label inside the image's outer voxel faces: a closed formula where there is one, else line
  /// integrals through the exact surface (relative error about 1e-4 for default sizes).
  [[nodiscard]] double volume_mm3(Label label) const;
  [[nodiscard]] PhantomTruth truth(Label label) const;

  /// Each voxel has the label at its centre. Threads: parallel, same result for every number of threads.
  /// Cost: the boundary's area in voxels; empty space is skipped by its distance.
  [[nodiscard]] LabelImage rasterise() const;

  /// Axes of the vessels inside the image; empty for shapes without one. The torus has its closed core
  /// circle.
  [[nodiscard]] std::vector<PhantomCurve> centerline() const;
  /// Paths from the inlet to every outlet, several per vessel, with Poiseuille's profile and flow split by
  /// the cube of the outlets' radii (Murray 1926, doi:10.1073/pnas.12.3.207), mean inlet speed 0.25 m/s; slow
  /// circles in the sac. Plausible, not a solution of the flow equations. Empty for shapes that are no
  /// vessels.
  [[nodiscard]] std::vector<PhantomStreamline> velocity_streamlines() const;

  struct Impl;  ///< Private to the module.

 private:
  std::shared_ptr<const Impl> impl_;
};

}  // namespace lumesh
