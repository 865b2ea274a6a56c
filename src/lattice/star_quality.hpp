#pragma once
// Quality of the tetrahedra around one vertex as a function of the vertex's place.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "work_mesh.hpp"

namespace lumesh {

/// The angle quality of a tetrahedron is min(4 (1 - cos smallest), 1 + cos largest) of its dihedral angles:
/// 4/3 for the regular one, 0 for a flat one. It weighs 10 deg like 160, 15 like 150, 20 like 140 and 30 like
/// 120 deg. This is the least quality that keeps both limits.
inline double angle_floor(double smallest_deg, double largest_deg) {
  constexpr double kRadian = std::numbers::pi / 180;
  return std::max(4 * (1 - std::cos(smallest_deg * kRadian)), 1 + std::cos(largest_deg * kRadian));
}

/// The star of a vertex, gathered once so that many places can be tried.
class StarQuality {
 public:
  static constexpr std::size_t kMaxTets = 256;  // twice the largest star seen
  static constexpr double kInverted = -1;

  StarQuality(const WorkMesh& mesh, std::uint32_t vertex) {
    for (const std::uint32_t t : mesh.star(vertex)) {
      const Corner4& c = mesh.tets[t];
      std::size_t at = 0;
      while (c[at] != vertex) ++at;
      // The face opposite to corner `at`, seen from outside the tetrahedron.
      constexpr std::size_t kFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
      order_[size_] = static_cast<std::uint8_t>(size_);
      Face& face = faces_[size_++];
      for (std::size_t i = 0; i < 3; ++i) face.p[i] = mesh.positions[c[kFace[at][i]]];
      const Vec3 n = (face.p[1] - face.p[0]).cross(face.p[2] - face.p[0]);
      face.unit_normal = n / n.norm();
      if (size_ == kMaxTets) break;
    }
  }

  /// Worst angle quality with the vertex at x; stops early once it is known to be below `enough`. What
  /// stopped it is looked at first the next time.
  [[nodiscard]] double worst(const Vec3& x, double enough) {
    double q = 2;
    for (std::size_t i = 0; i < size_; ++i) {
      q = std::min(q, quality(faces_[order_[i]], x));
      if (q < enough) {
        std::swap(order_[i], order_[0]);
        return q;
      }
    }
    return q;
  }

 private:
  struct Face {
    std::array<Vec3, 3> p;
    Vec3 unit_normal;  // points out of the tetrahedron
  };

  static double quality(const Face& face, const Vec3& x) {
    const Vec3 a = face.p[0] - x;
    const Vec3 b = face.p[1] - x;
    const Vec3 c = face.p[2] - x;
    if (!(a.dot(face.unit_normal) > 0)) return kInverted;
    // Outward normals of the three faces at x.
    const Vec3 na = c.cross(b);
    const Vec3 nb = a.cross(c);
    const Vec3 nc = b.cross(a);
    const double la = na.squaredNorm();
    const double lb = nb.squaredNorm();
    const double lc = nc.squaredNorm();
    if (!(la > 0 && lb > 0 && lc > 0)) return kInverted;
    const double ia = 1 / std::sqrt(la), ib = 1 / std::sqrt(lb), ic = 1 / std::sqrt(lc);
    const Vec3& n = face.unit_normal;
    const double c1 = -na.dot(nb) * (ia * ib), c2 = -nb.dot(nc) * (ib * ic), c3 = -nc.dot(na) * (ic * ia);
    const double c4 = -n.dot(na) * ia, c5 = -n.dot(nb) * ib, c6 = -n.dot(nc) * ic;
    const double largest = std::max({c1, c2, c3, c4, c5, c6});
    const double smallest = std::min({c1, c2, c3, c4, c5, c6});
    return std::min(4 * (1 - largest), 1 + smallest);
  }

  std::array<Face, kMaxTets> faces_;
  std::array<std::uint8_t, kMaxTets> order_;
  std::size_t size_ = 0;
};

}  // namespace lumesh
