#include "lumesh/geometry/predicates.hpp"

// Kernel headers of CGAL only (LGPL); no package under the GPL may be included here.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace lumesh::detail {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 to_cgal(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}
Kernel::Point_2 to_cgal(const Vec2& p) {
  return {p.x(), p.y()};
}

}  // namespace

int orient2d_exact(const Vec2& a, const Vec2& b, const Vec2& c) {
  return static_cast<int>(CGAL::orientation(to_cgal(a), to_cgal(b), to_cgal(c)));
}

int orient3d_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return static_cast<int>(CGAL::orientation(to_cgal(a), to_cgal(b), to_cgal(c), to_cgal(d)));
}

int insphere_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& e) {
  return static_cast<int>(
      CGAL::side_of_oriented_sphere(to_cgal(a), to_cgal(b), to_cgal(c), to_cgal(d), to_cgal(e)));
}

}  // namespace lumesh::detail
