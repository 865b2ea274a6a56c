#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "inputs.hpp"
#include "lumesh/core/counted.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "mesh_boundary.hpp"

namespace lumesh::centerline {

namespace {

constexpr int kMargin = 4;  ///< Voxels around the mesh.

/// Where the mesh's voxels are, and how far beyond its caps vessels go on.
struct Grid {
  ImageFrame frame;
  std::vector<Cap> caps;

  [[nodiscard]] double voxel_mm() const { return frame.spacing_mm.x(); }
  [[nodiscard]] double beyond_mm(const Cap& cap) const { return std::max(cap.radius, 4 * voxel_mm()); }
};

/// Rows of voxels along x through the boundary: which voxels lie between an entry and the next exit.
class RowFiller {
 public:
  RowFiller(const Boundary& boundary, const ImageFrame& frame) : boundary_(boundary), frame_(frame) {}

  [[nodiscard]] std::vector<Index3> voxels() const {
    std::vector<Index3> voxels;
    for_each_stretch([&](std::size_t row, double entry, double exit) {
      const auto j = static_cast<int>(row % static_cast<std::size_t>(frame_.size.y()));
      const auto k = static_cast<int>(row / static_cast<std::size_t>(frame_.size.y()));
      const auto last = static_cast<int>(std::floor(exit));
      for (int i = static_cast<int>(std::ceil(entry)); i <= last; ++i) voxels.emplace_back(i, j, k);
    });
    return voxels;
  }

  /// However triangles are turned.
  [[nodiscard]] double volume_mm3() const {
    double voxels = 0;
    for_each_stretch([&](std::size_t, double entry, double exit) { voxels += exit - entry; });
    return voxels * frame_.voxel_volume_mm3();
  }

 private:
  struct Crossing {
    std::size_t row;
    double x;  ///< In voxels.
  };

  /// body(row, entry, exit), in order.
  template <class Body>
  void for_each_stretch(const Body& body) const {
    std::vector<Crossing> crossings = parallel::collect<Crossing>(
        boundary_.triangles.size(), [&](std::size_t t, std::vector<Crossing>& out) { cross(t, out); });
    parallel::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
      return a.row != b.row ? a.row < b.row : a.x < b.x;
    });
    for (std::size_t c = 0; c + 1 < crossings.size();) {
      if (crossings[c].row != crossings[c + 1].row) {
        ++c;  // An entry without an exit: the boundary is not closed there.
        continue;
      }
      body(crossings[c].row, crossings[c].x, crossings[c + 1].x);
      c += 2;
    }
  }

  /// Side of a row at (y, z) of the projected edge: the same number for both triangles at the edge.
  [[nodiscard]] static bool is_left(const Vec3& a, const Vec3& b, double y, double z) {
    const bool swap = std::lexicographical_compare(b.data(), b.data() + 3, a.data(), a.data() + 3);
    const Vec3& p = swap ? b : a;
    const Vec3& q = swap ? a : b;
    return ((q.y() - p.y()) * (z - p.z()) - (q.z() - p.z()) * (y - p.y()) > 0) != swap;
  }

  void cross(std::size_t t, std::vector<Crossing>& out) const {
    std::array<Vec3, 3> at;
    for (std::size_t n = 0; n < 3; ++n) at[n] = frame_.to_index(boundary_.corner(t, n));
    const Vec3 low = at[0].cwiseMin(at[1]).cwiseMin(at[2]), high = at[0].cwiseMax(at[1]).cwiseMax(at[2]);
    const Vec3 normal = (at[1] - at[0]).cross(at[2] - at[0]);
    if (normal.x() == 0) return;
    for (int k = static_cast<int>(std::ceil(low.z())); k <= high.z(); ++k) {
      for (int j = static_cast<int>(std::ceil(low.y())); j <= high.y(); ++j) {
        const bool side = is_left(at[0], at[1], j, k);
        if (is_left(at[1], at[2], j, k) != side || is_left(at[2], at[0], j, k) != side) continue;
        const double x =
            at[0].x() - (normal.y() * (j - at[0].y()) + normal.z() * (k - at[0].z())) / normal.x();
        out.push_back({static_cast<std::size_t>(j) +
                           static_cast<std::size_t>(frame_.size.y()) * static_cast<std::size_t>(k),
                       std::clamp(x, low.x(), high.x())});
      }
    }
  }

  const Boundary& boundary_;
  const ImageFrame& frame_;
};

/// The shift keeps rows of voxels off corners and edges at round coordinates.
ImageFrame frame_around(const Box3& box, double margin, double voxel) {
  ImageFrame frame;
  frame.spacing_mm.setConstant(voxel);
  frame.origin_mm = box.min() - Vec3::Constant(margin) + voxel * Vec3(0.3141, 0.2718, 0.1414);
  frame.size =
      ((box.max() + Vec3::Constant(margin) - frame.origin_mm) / voxel).array().ceil().cast<int>() + 1;
  return frame;
}

/// From rows through the boundary where they find much more than the sum over its triangles: some of these
/// are turned to the wrong side then.
double sound_volume(const Boundary& boundary, double sum, const Box3& box) {
  constexpr double kRows = 200, kMuchMore = 1.5;
  const double voxel = box.sizes().maxCoeff() / kRows;
  const double of_rows = RowFiller(boundary, frame_around(box, voxel, voxel)).volume_mm3();
  return of_rows > kMuchMore * std::abs(sum) ? of_rows : std::abs(sum);
}

/// Edge of voxels where none is given: fine enough for the mesh's usual vessel, and for the thinnest that
/// ends at a cap.
double usual_voxel(double mean_radius, double volume, const std::vector<Cap>& caps) {
  double voxel = kUsualVoxel * mean_radius;
  for (const Cap& cap : caps) voxel = std::min(voxel, kVoxelOfThinnest * cap.radius);
  return std::max(voxel, std::cbrt(volume / kMaxUsualVoxels));
}

Grid grid_around(const Boundary& boundary, const CenterlineOptions& options) {
  double volume = 0, area = 0;
  Box3 box;
  const Vec3 base = boundary.corner(0, 0);
  for (std::size_t t = 0; t < boundary.triangles.size(); ++t) {
    const Vec3 normal = boundary.area_vector(t);
    volume += normal.dot(boundary.corner(t, 0) - base) / 3;
    if (boundary.is_opening[t] == 0) area += normal.norm();
    for (std::size_t n = 0; n < 3; ++n) box.extend(boundary.corner(t, n));
  }
  const double extent = box.sizes().maxCoeff();
  Grid grid;
  grid.caps = caps_of(boundary, volume > 0 ? 1 : -1);
  volume = extent > 0 ? sound_volume(boundary, volume, box) : 0;
  if (!(volume > 1e-9 * extent * extent * extent) || !(area > 0))
    throw Error(ErrorKind::kBadInput, "the boundary of the mesh encloses nothing; is its surface closed?");
  // A tube's volume is half its radius times its area.
  const double voxel =
      options.voxel_mm > 0 ? options.voxel_mm : usual_voxel(2 * volume / area, volume, grid.caps);
  if (volume / (voxel * voxel * voxel) > 1e9 || extent / voxel > 30000)
    throw Error(ErrorKind::kBadInput,
                fmt::format("voxels of {:g} mm are too small for a mesh of {:g} mm; give larger ones", voxel,
                            extent));
  grid.frame.spacing_mm.setConstant(voxel);
  double margin = kMargin * voxel;
  for (const Cap& cap : grid.caps) margin = std::max(margin, kMargin * voxel + grid.beyond_mm(cap));
  grid.frame = frame_around(box, margin, voxel);
  return grid;
}

/// A voxel in a prism that stands on a triangle of a cap, from a voxel below it upwards.
struct PrismVoxel {
  Index3 at;
  double height_mm;
};

std::vector<PrismVoxel> prisms_on(const Cap& cap, const Boundary& boundary, const Grid& grid) {
  std::vector<PrismVoxel> voxels;
  const Vec3 up = grid.beyond_mm(cap) * cap.normal;
  for (const std::size_t t : cap.triangles) {
    std::array<Vec3, 3> corner;
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (std::size_t n = 0; n < 3; ++n) {
      corner[n] = boundary.corner(t, n);
      low = low.cwiseMin(corner[n]).cwiseMin(corner[n] + up);
      high = high.cwiseMax(corner[n]).cwiseMax(corner[n] + up);
    }
    const Index3 first = grid.frame.to_index(low).array().floor().cast<int>();
    const Index3 last = grid.frame.to_index(high).array().ceil().cast<int>();
    const auto holds = [&](const Vec3& p, double height) {
      if (height < -grid.voxel_mm() || height > grid.beyond_mm(cap)) return false;
      std::array<double, 3> side;
      for (std::size_t n = 0; n < 3; ++n)
        side[n] = (corner[(n + 1) % 3] - corner[n]).cross(p - corner[n]).dot(cap.normal);
      return (side[0] >= 0 && side[1] >= 0 && side[2] >= 0) || (side[0] <= 0 && side[1] <= 0 && side[2] <= 0);
    };
    for_each_place(first, last, [&](const Index3& at) {
      const Vec3 p = grid.frame.to_physical(at.cast<double>());
      if (holds(p, cap.height(p))) voxels.push_back({at, cap.height(p)});
    });
  }
  return voxels;
}

/// The voxels of a mesh, and those beyond its caps, both ascending in memory order, each once.
struct MeshVoxels {
  std::vector<Index3> inside;
  std::vector<Index3> beyond;
};

/// The last layer of voxels below each cap belongs to those beyond: so nothing joins what lies at two caps
/// that face each other. Where another vessel lies in a cap's way, the prisms end at it.
MeshVoxels voxels_of(const Boundary& boundary, const Grid& grid) {
  const MemoryOrder before{grid.frame};
  const auto ascend = [&](std::vector<Index3>& voxels) {
    std::erase_if(voxels, [&](const Index3& v) { return !grid.frame.contains(v); });
    if (!std::ranges::is_sorted(voxels, before)) parallel::sort_unique(voxels, before);
  };
  MeshVoxels voxels;
  std::vector<Index3> all = RowFiller(boundary, grid.frame).voxels();
  ascend(all);
  // What of the last layer lies beside the prisms, at the rim, would be pieces of their own.
  const auto add_layer_around = [&](const Index3& middle, const Cap& cap) {
    for_each_place(middle - Index3::Ones(), middle + Index3::Ones(), [&](const Index3& at) {
      if (cap.height(grid.frame.to_physical(at.cast<double>())) > -grid.voxel_mm() &&
          std::ranges::binary_search(all, at, before))
        voxels.beyond.push_back(at);
    });
  };
  for (const Cap& cap : grid.caps) {
    const std::vector<PrismVoxel> prisms = prisms_on(cap, boundary, grid);
    const auto is_above_inside = [&](const PrismVoxel& voxel) {
      return voxel.height_mm > 0 && std::ranges::binary_search(all, voxel.at, before);
    };
    double end_mm = grid.beyond_mm(cap);
    for (const PrismVoxel& voxel : prisms)
      if (voxel.height_mm > 2 * grid.voxel_mm() && is_above_inside(voxel))
        end_mm = std::min(end_mm, voxel.height_mm);
    for (const PrismVoxel& voxel : prisms) {
      if (voxel.height_mm <= end_mm && !is_above_inside(voxel)) voxels.beyond.push_back(voxel.at);
      if (voxel.height_mm <= 0) add_layer_around(voxel.at, cap);
    }
  }
  ascend(voxels.beyond);
  std::set_difference(all.begin(), all.end(), voxels.beyond.begin(), voxels.beyond.end(),
                      std::back_inserter(voxels.inside), before);
  return voxels;
}

/// Places the wall between voxels by its distance from them. Beyond a cap it goes on as at the cap.
void place_wall(const Boundary& boundary, const Grid& grid, Lumen& lumen) {
  std::vector<Cell<3>> wall;
  for (std::size_t t = 0; t < boundary.triangles.size(); ++t)
    if (boundary.is_opening[t] == 0) wall.push_back(boundary.triangles[t]);
  const TriangleTree tree(boundary.points, wall);
  const double voxel = grid.voxel_mm();
  lumen.refine_shares([&](const Vec3& position, bool inside) {
    Vec3 p = grid.frame.origin_mm + position;
    for (const Cap& cap : grid.caps) {
      const double height = cap.height(p);
      const Vec3 projection = p - height * cap.normal;
      if (height <= 0 || height > grid.beyond_mm(cap) || (projection - cap.middle).norm() > 2 * cap.radius)
        continue;
      p = projection;
      break;
    }
    const double distance = std::min(tree.nearest(p, 2 * voxel).distance, 2 * voxel);
    return 0.5 + (inside ? 0.5 : -0.5) * distance / voxel;
  });
}

/// @return Caps without a voxel of the lumen: smaller than one, or of a piece that is left out.
std::vector<Cap> add_openings(const Grid& grid, Lumen& lumen) {
  std::vector<Cap> missed;
  for (const Cap& cap : grid.caps) {
    Opening opening;
    opening.normal = cap.normal;
    const Index3 middle = grid.frame.to_index(cap.middle).array().round().cast<int>();
    const auto reach = static_cast<int>(std::ceil(1.5 * cap.radius / grid.voxel_mm())) + 1;
    for (int k = -reach; k <= reach; ++k) {
      for (int j = -reach; j <= reach; ++j) {
        for (int i = -reach; i <= reach; ++i) {
          const std::uint32_t id = lumen.find(middle + Index3(i, j, k));
          if (id == kNoVoxel) continue;
          const double height = cap.height(grid.frame.origin_mm + lumen.position(id));
          if (height > 0 || height < -2.2 * grid.voxel_mm()) continue;
          if (opening.voxel == kNoVoxel || lumen.wall_mm(id) > lumen.wall_mm(opening.voxel))
            opening.voxel = id;
        }
      }
    }
    if (opening.voxel == kNoVoxel) {
      missed.push_back(cap);
      continue;
    }
    const Vec3 at = lumen.position(opening.voxel);
    opening.point = at - cap.height(grid.frame.origin_mm + at) * cap.normal;
    lumen.openings.push_back(opening);
  }
  return missed;
}

void warn_of_missed(const std::vector<Cap>& missed, double voxel_mm, const Context& context) {
  if (missed.empty()) return;
  std::string places;
  for (const Cap& cap : missed)
    places += fmt::format("{}radius {:.3g} mm at {}", places.empty() ? "" : "; ", cap.radius,
                          place_text(cap.middle));
  context.warn(
      fmt::format("voxels of {:.3g} mm join no line to {} ({}): the vessel there is too thin for them",
                  voxel_mm, counted(missed.size(), "opening", "openings"), places));
}

}  // namespace

Lumen lumen_of_mesh(const MeshView& mesh, const CenterlineOptions& options, Context& context) {
  const Boundary boundary = boundary_of(mesh, context);
  const Grid grid = grid_around(boundary, options);
  MeshVoxels voxels = voxels_of(boundary, grid);
  if (voxels.inside.empty())
    throw Error(ErrorKind::kBadInput,
                fmt::format("no voxel of {:g} mm lies inside the mesh", grid.voxel_mm()));
  Lumen lumen(grid.frame, std::move(voxels.inside), voxels.beyond);
  if (lumen.left_out() > 0)
    context.warn(
        fmt::format("{:.3g} mm3 that voxels of {:.3g} mm do not join to the largest piece are left out",
                    static_cast<double>(lumen.left_out()) * grid.frame.voxel_volume_mm3(), grid.voxel_mm()));
  place_wall(boundary, grid, lumen);
  warn_of_missed(add_openings(grid, lumen), grid.voxel_mm(), context);
  return lumen;
}

}  // namespace lumesh::centerline
