#pragma once
// The adaptive lattice: red refinement where a size function asks for it, closed by green elements.

#include "bcc.hpp"
#include "lumesh/core/types.hpp"
#include "size_grid.hpp"

namespace lumesh {

/// How far from its centre a lattice tetrahedron looks for boundaries, in its spacings.
inline constexpr double kRefinementReach = 0.40;

/// Where the whole-number lattice lies in space.
struct LatticeFrame {
  Vec3 origin_mm = Vec3::Zero();
  Mat3 axes = Mat3::Identity();   ///< Proper rotation: the image's axes.
  double unit_mm = 1;             ///< One step of the whole-number coordinates.
  Index3 cells = Index3::Zero();  ///< Cubes of level 0 along each axis.
  int levels = 0;                 ///< Finest level.

  [[nodiscard]] Vec3 position_mm(bcc::Key key) const {
    return origin_mm + axes * (unit_mm * bcc::unpack(key).cast<double>());
  }
  [[nodiscard]] double spacing_mm(int level) const { return unit_mm * static_cast<double>(2 * step(level)); }
  /// Half the spacing of a level in units.
  [[nodiscard]] int step(int level) const { return 1 << (levels + 1 - level); }
};

/// Lays the lattice over the object: its spacing and the image's axes.
[[nodiscard]] LatticeFrame make_lattice_frame(const ImageDomain& domain, double coarsest_mm, int levels);

/// Lattice tetrahedra around the object, refined to what `sizes` wants, conforming; lattice order, positively
/// oriented.
[[nodiscard]] bcc::Lattice refined_lattice(const LatticeFrame& frame, const ImageDomain& domain,
                                           const SizeGrid& sizes);

}  // namespace lumesh
