#include "star_quality.hpp"

#include <utility>

#include "lumesh/core/wide.hpp"

namespace lumesh::fitting {

namespace {

using Lanes = StarQuality::Lanes;

/// Squares that keep the sign are ordered like the numbers themselves and need no roots.
inline double signed_square(double a) {
  return a * std::abs(a);
}
inline double signed_root(double a) {
  return std::copysign(std::sqrt(std::abs(a)), a);
}
inline double larger(double a, double b) {
  return a > b ? a : b;
}
inline double smaller(double a, double b) {
  return a < b ? a : b;
}

struct Extremes {
  Lanes largest, smallest;  // cosines of the dihedral angles, as signed squares
  Lanes positive;           // all measures that must be positive are, if this is
};

LUMESH_WIDE_LOOPS void find_normals(StarQuality::Faces& f) {
  for (std::size_t i = 0; i < StarQuality::kGroup; ++i) {
    const double px = f.corner[0][0][i], py = f.corner[0][1][i], pz = f.corner[0][2][i];
    const double ax = f.corner[1][0][i] - px, ay = f.corner[1][1][i] - py, az = f.corner[1][2][i] - pz;
    const double bx = f.corner[2][0][i] - px, by = f.corner[2][1][i] - py, bz = f.corner[2][2][i] - pz;
    const double nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx;
    f.normal[0][i] = nx;
    f.normal[1][i] = ny;
    f.normal[2][i] = nz;
    f.inverse_normal2[i] = 1 / (nx * nx + ny * ny + nz * nz);
  }
}

LUMESH_WIDE_LOOPS void find_extremes(const StarQuality::Faces& __restrict f, const double* __restrict x,
                                     Extremes& __restrict out) {
  for (std::size_t i = 0; i < StarQuality::kGroup; ++i) {
    const double ax = f.corner[0][0][i] - x[0], ay = f.corner[0][1][i] - x[1], az = f.corner[0][2][i] - x[2];
    const double bx = f.corner[1][0][i] - x[0], by = f.corner[1][1][i] - x[1], bz = f.corner[1][2][i] - x[2];
    const double cx = f.corner[2][0][i] - x[0], cy = f.corner[2][1][i] - x[1], cz = f.corner[2][2][i] - x[2];
    const double nx = f.normal[0][i], ny = f.normal[1][i], nz = f.normal[2][i];
    // Outward normals of the three faces at x: c x b, a x c, b x a.
    const double ux = cy * bz - cz * by, uy = cz * bx - cx * bz, uz = cx * by - cy * bx;
    const double vx = ay * cz - az * cy, vy = az * cx - ax * cz, vz = ax * cy - ay * cx;
    const double wx = by * az - bz * ay, wy = bz * ax - bx * az, wz = bx * ay - by * ax;
    const double uu = ux * ux + uy * uy + uz * uz;
    const double vv = vx * vx + vy * vy + vz * vz;
    const double ww = wx * wx + wy * wy + wz * wz;
    const double iu = 1 / uu, iv = 1 / vv, iw = 1 / ww, in = f.inverse_normal2[i];
    const double uv = -(ux * vx + uy * vy + uz * vz);
    const double vw = -(vx * wx + vy * wy + vz * wz);
    const double wu = -(wx * ux + wy * uy + wz * uz);
    const double nu = -(nx * ux + ny * uy + nz * uz);
    const double nv = -(nx * vx + ny * vy + nz * vz);
    const double nw = -(nx * wx + ny * wy + nz * wz);
    const double c1 = uv * std::abs(uv) * (iu * iv), c2 = vw * std::abs(vw) * (iv * iw);
    const double c3 = wu * std::abs(wu) * (iw * iu), c4 = nu * std::abs(nu) * (in * iu);
    const double c5 = nv * std::abs(nv) * (in * iv), c6 = nw * std::abs(nw) * (in * iw);
    out.largest[i] = larger(larger(larger(c1, c2), larger(c3, c4)), larger(c5, c6));
    out.smallest[i] = smaller(smaller(smaller(c1, c2), smaller(c3, c4)), smaller(c5, c6));
    out.positive[i] = smaller(smaller(ax * nx + ay * ny + az * nz, uu), smaller(vv, ww));
  }
}

}  // namespace

StarQuality::StarQuality(const WorkMesh& mesh, std::uint32_t vertex) {
  const auto star = mesh.star(vertex);
  const std::size_t count = std::min(star.size(), kMaxTets);
  size_ = (count + kGroup - 1) / kGroup;
  for (std::size_t i = 0; i < size_ * kGroup; ++i) {
    const Corner4& c = mesh.tets[star[std::min(i, count - 1)]];  // the last one fills its group
    const std::size_t at =
        (c[1] == vertex ? 1U : 0U) + (c[2] == vertex ? 2U : 0U) + (c[3] == vertex ? 3U : 0U);
    Faces& faces = groups_[i / kGroup];
    const Triangle opposite = face_of(c, at);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = mesh.positions[opposite[k]];
      for (std::size_t axis = 0; axis < 3; ++axis)
        faces.corner[k][axis][i % kGroup] = p[static_cast<int>(axis)];
    }
  }
  for (std::size_t g = 0; g < size_; ++g) {
    find_normals(groups_[g]);
    order_[g] = static_cast<std::uint8_t>(g);
  }
}

double StarQuality::worst(const Vec3& x, double enough) {
  const double max_cosine = signed_square(1 - enough / 4);
  const double min_cosine = signed_square(enough - 1);
  double largest = -1;
  double smallest = 1;
  Extremes extremes;
  for (std::size_t g = 0; g < size_; ++g) {
    find_extremes(groups_[order_[g]], x.data(), extremes);
    double positive = extremes.positive[0];
    for (std::size_t i = 0; i < kGroup; ++i) {
      largest = larger(extremes.largest[i], largest);
      smallest = smaller(extremes.smallest[i], smallest);
      positive = smaller(extremes.positive[i], positive);
    }
    if (!(positive > 0)) {
      std::swap(order_[g], order_[0]);
      return kInverted;
    }
    if (largest > max_cosine || smallest < min_cosine) {
      std::swap(order_[g], order_[0]);
      break;
    }
  }
  return std::min(4 * (1 - signed_root(largest)), 1 + signed_root(smallest));
}

}  // namespace lumesh::fitting
