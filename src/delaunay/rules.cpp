#include "rules.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace lumesh::delaunay {
namespace {

constexpr float kSurfaceFirst = 1e6F;

/// Cosine of the smallest angle of a triangle.
double cosine_of_smallest_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double ab = (b - a).squaredNorm(), bc = (c - b).squaredNorm(), ca = (a - c).squaredNorm();
  // It is opposite the shortest side.
  const double least = std::min({ab, bc, ca});
  return (ab + bc + ca - 2 * least) / (2 * std::sqrt(ab * bc * ca / least));
}

}  // namespace

Circumsphere circumsphere(const TetMesh& mesh, TetId t) {
  const Vec3& a = mesh.corner(t, 0);
  const Vec3 u = mesh.corner(t, 1) - a, v = mesh.corner(t, 2) - a, w = mesh.corner(t, 3) - a;
  const Vec3 vw = v.cross(w), wu = w.cross(u), uv = u.cross(v);
  const Vec3 offset = (u.squaredNorm() * vw + v.squaredNorm() * wu + w.squaredNorm() * uv) / (2 * u.dot(vw));
  return {a + offset, offset.norm()};
}

Material Rules::material_of(TetId t) const {
  const Circumsphere sphere = circumsphere(mesh_, t);
  return sphere.centre.allFinite() ? domain_.material_at(sphere.centre) : 0;
}

bool Rules::is_boundary(TetId t, int face) const {
  const FaceLink behind = mesh_.link(t, face);
  if (behind.is_boundary()) return false;
  const auto mine = static_cast<Material>(mesh_.label(t)),
             other = static_cast<Material>(mesh_.label(behind.tet()));
  return mine != other && (domain_.is_meshed(mine) || domain_.is_meshed(other));
}

/// Where the edge between the centres of both circumspheres crosses the boundary.
Vec3 Rules::surface_centre(TetId t, int face, Material mine, Material other) const {
  Vec3 low = circumsphere(mesh_, t).centre, high = circumsphere(mesh_, mesh_.link(t, face).tet()).centre;
  double at_low = domain_.separation(low, mine, other).value,
         at_high = domain_.separation(high, mine, other).value;
  constexpr int kSteps = 40;
  const double close = 1e-4 * domain_.resolution_mm();
  for (int step = 0; step < kSteps && (high - low).norm() > close; ++step) {
    // Regula falsi with halved end values (Illinois), kept off the ends.
    double fraction = at_low > 0 && at_high < 0 ? at_low / (at_low - at_high) : 0.5;
    fraction = std::clamp(fraction, 0.02, 0.98);
    const Vec3 middle = low + fraction * (high - low);
    const double value = domain_.separation(middle, mine, other).value;
    if (std::abs(value) < close) return middle;
    if (value > 0) {
      low = middle;
      at_low = value;
      at_high *= 0.5;
    } else {
      high = middle;
      at_high = value;
      at_low *= 0.5;
    }
  }
  return 0.5 * (low + high);
}

std::optional<Wish> Rules::wish_of_face(TetId t, int face) const {
  const auto mine = static_cast<Material>(mesh_.label(t));
  const auto other = static_cast<Material>(mesh_.label(mesh_.link(t, face).tet()));
  const Cell<3> corners = mesh_.face_corners(t, face);
  const Vec3 &a = mesh_.point(VertexId(corners[0])), &b = mesh_.point(VertexId(corners[1])),
             &c = mesh_.point(VertexId(corners[2]));
  const Vec3 centre = surface_centre(t, face, mine, other);
  if (!centre.allFinite()) return std::nullopt;
  const double radius = (centre - a).norm();
  const double spacing = spacing_.surface_spacing_at(centre, mine, other);
  const bool is_off = std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
    return v < 4 || mesh_.dimension(VertexId(v)) == VertexDimension::kVolume;
  });
  const double limit = std::cos(limits_.facet_angle_deg * std::numbers::pi / 180);
  if (radius <= spacing && !is_off && cosine_of_smallest_angle(a, b, c) <= limit) return std::nullopt;
  return at_surface(centre, t, mine, other, radius, spacing);
}

/// A point on the surface, or on the curve where it ends if that is near.
std::optional<Wish> Rules::at_surface(const Vec3& place, TetId t, Material mine, Material other,
                                      double radius, double spacing) const {
  constexpr double kLeast = 0.25;  // Of the spacing, from what is there.
  MaterialSet set{mine, other};
  const auto on_surface = domain_.project(place, set, spacing);
  Wish wish{on_surface.value_or(place), t, kSurfaceFirst + static_cast<float>(radius / spacing),
            VertexDimension::kSurface};
  const MaterialSet near = domain_.materials_near(wish.point, 0.5 * std::min(radius, spacing));
  for (const Material third : near) {
    if (set.contains(third)) continue;
    MaterialSet triple = set;
    triple.insert(third);
    if (const auto on_curve = domain_.project(wish.point, triple, spacing)) {
      wish.point = *on_curve;
      wish.dimension = VertexDimension::kCurve;
      break;
    }
  }
  for (const std::uint32_t v : mesh_.tet(t))
    if ((mesh_.point(VertexId(v)) - wish.point).norm() < kLeast * spacing) return std::nullopt;
  return wish;
}

std::optional<Wish> Rules::wish_of_tet(TetId t) const {
  const auto mine = static_cast<Material>(mesh_.label(t));
  if (!domain_.is_meshed(mine)) return std::nullopt;
  const Circumsphere sphere = circumsphere(mesh_, t);
  double shortest2 = std::numeric_limits<double>::infinity();
  for (const auto& [i, j] : kTetEdges)
    shortest2 = std::min(shortest2, (mesh_.corner(t, i) - mesh_.corner(t, j)).squaredNorm());
  const double largest = kRadiusPerSize * spacing_.size_at(sphere.centre, mine);
  const bool is_long = sphere.radius > limits_.radius_edge * std::sqrt(shortest2);
  if (sphere.radius <= largest && !is_long) return std::nullopt;
  // What would stand near the surface is left to it.
  constexpr double kMargin = 0.4;
  const double clearance = domain_.surroundings(sphere.centre).clearance_mm;
  if (clearance < std::min(kMargin * std::min(sphere.radius, largest), domain_.clearance_limit_mm()))
    return std::nullopt;
  return Wish{sphere.centre, t, static_cast<float>(sphere.radius / largest), VertexDimension::kVolume};
}

}  // namespace lumesh::delaunay
