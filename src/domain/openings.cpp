#include "lumesh/domain/openings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <span>
#include <utility>

#include "lumesh/core/squares.hpp"
#include "lumesh/geometry/area_order.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/patch_renaming.hpp"
#include "lumesh/parallel/loops.hpp"
#include "opening_names.hpp"
#include "opening_squares.hpp"

namespace lumesh {
namespace {

/// Area, first moment and box of a part of a plane, summed up from triangles.
struct FlatShape {
  double area_mm2 = 0;
  Vec3 moment = Vec3::Zero();
  Box3 box_mm;

  /// @param normal  Of unit length; triangles that turn against it count negative.
  void add(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal) {
    const double area = 0.5 * (b - a).cross(c - a).dot(normal);
    area_mm2 += area;
    moment += area * triangle_centre(a, b, c);
    for (const Vec3& p : {a, b, c}) box_mm.extend(p);
  }
};

/// A rectangle of a cut plane, just inside of the object, divided into squares.
class PlaneGrid {
 public:
  /// @param middle_mm, half_u, half_v  Of the rectangle, along the axes.
  /// @param beyond  The material on the other side of the plane. @param step  Raised where there would be too
  /// many.
  PlaneGrid(const Domain& domain, Material beyond, const CutPlane& plane, const Vec3& u, const Vec3& v,
            const Vec3& middle_mm, double half_u, double half_v, double step)
      : domain_(domain), beyond_(beyond), normal_(plane.normal), u_(u), v_(v) {
    constexpr double kMaxSquares = 1.6e7;
    step = step_ = std::max(step, std::sqrt(4 * half_u * half_v / kMaxSquares));
    columns_ = std::max(1, static_cast<int>(std::ceil(2 * half_u / step)));
    rows_ = std::max(1, static_cast<int>(std::ceil(2 * half_v / step)));
    inside_mm_ = 1e-3 * domain.finest_resolution_mm();
    first_ = middle_mm - (plane.normal.dot(middle_mm - plane.point_mm) + inside_mm_) * plane.normal -
             0.5 * step * ((columns_ - 1) * u + (rows_ - 1) * v);
    materials_.assign(size(), 0);
    parallel::for_each_index(static_cast<std::size_t>(rows_),
                             [&](std::size_t r) { fill(static_cast<int>(r)); });
  }

  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  }
  [[nodiscard]] Material material(std::size_t square) const { return materials_[square]; }
  [[nodiscard]] Vec3 centre_of(std::size_t square) const {
    const auto columns = static_cast<std::size_t>(columns_);
    return centre_of(static_cast<int>(square % columns), static_cast<int>(square / columns));
  }
  /// The shape of a part, of cells between the centres of four squares each: right to second order in the
  /// step, also along sides that run along the squares.
  /// @param is_inside  The squares of a part of the material.
  [[nodiscard]] FlatShape shape_of(Material material, std::span<const std::uint8_t> is_inside) const {
    FlatShape shape;
    for (int row = 0; row + 1 < rows_; ++row)
      for (int column = 0; column + 1 < columns_; ++column) {
        std::array<bool, 4> in;
        for (std::size_t k = 0; k < 4; ++k)
          in[k] = is_inside[square(column + kCorners[k][0], row + kCorners[k][1])] != 0;
        if (std::ranges::any_of(in, std::identity())) add_cell(column, row, in, material, shape);
      }
    return shape;
  }
  [[nodiscard]] std::shared_ptr<const OpeningSquares> squares(std::vector<std::uint8_t> is_inside) const {
    return std::make_shared<const OpeningSquares>(
        OpeningSquares{first_, u_, v_, step_, columns_, rows_, std::move(is_inside)});
  }
  /// The square that holds a place of the plane.
  [[nodiscard]] std::size_t square_at(const Vec3& x) const {
    const auto along = [&](const Vec3& axis, int count) {
      return std::clamp(static_cast<int>(std::lround((x - first_).dot(axis) / step_)), 0, count - 1);
    };
    return static_cast<std::size_t>(along(u_, columns_)) +
           static_cast<std::size_t>(columns_) * static_cast<std::size_t>(along(v_, rows_));
  }

  /// Calls visit(place, material, beside) where a meshed material meets another one along a row or a column.
  template <class Visit>
  void for_each_change(const Visit& visit) const {
    for (std::size_t s = 0; s < size(); ++s) {
      if (!domain_.is_meshed(materials_[s])) continue;
      for_each_square_beside(static_cast<std::size_t>(columns_), size(), s, [&](std::size_t beside) {
        if (materials_[beside] != materials_[s])
          visit(0.5 * (centre_of(s) + centre_of(beside)), materials_[s], materials_[beside]);
      });
    }
  }

  /// Connected squares of one meshed material: a number for each square, 0 for none.
  [[nodiscard]] std::vector<std::uint32_t> parts() const {
    return connected_squares(static_cast<std::size_t>(columns_), size(), [&](std::size_t s) {
      return domain_.is_meshed(materials_[s]) ? materials_[s] : Material{0};
    });
  }

 private:
  static constexpr std::array<std::array<int, 2>, 4> kCorners = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

  [[nodiscard]] std::size_t square(int column, int row) const {
    return static_cast<std::size_t>(column) +
           static_cast<std::size_t>(columns_) * static_cast<std::size_t>(row);
  }
  [[nodiscard]] Vec3 centre_of(int column, int row) const {
    return first_ + step_ * (column * u_ + row * v_);
  }

  /// The part of one cell inside, as the polygon of its corners there and of where its sides cross the rim.
  void add_cell(int column, int row, const std::array<bool, 4>& in, Material material,
                FlatShape& shape) const {
    std::array<Vec3, 8> polygon;
    std::size_t count = 0;
    const auto corner = [&](std::size_t k) {
      return centre_of(column + kCorners[k % 4][0], row + kCorners[k % 4][1]);
    };
    for (std::size_t k = 0; k < 4; ++k) {
      if (in[k]) polygon[count++] = corner(k);
      if (in[k] != in[(k + 1) % 4])
        polygon[count++] =
            in[k] ? end_of(material, corner(k), corner(k + 1)) : end_of(material, corner(k + 1), corner(k));
    }
    for (std::size_t k = 1; k + 1 < count; ++k) shape.add(polygon[0], polygon[k], polygon[k + 1], normal_);
  }

  /// The end of the material between a place in it and another one.
  [[nodiscard]] Vec3 end_of(Material material, Vec3 in, Vec3 out) const {
    constexpr int kHalvings = 8;
    for (int i = 0; i < kHalvings; ++i) {
      const Vec3 middle = 0.5 * (in + out);
      (material_of(middle) == material ? in : out) = middle;
    }
    return 0.5 * (in + out);
  }

  /// Runs of squares at a time, where there may be something.
  void fill(int row) {
    constexpr int kRun = 16;
    for (int begin = 0; begin < columns_; begin += kRun) {
      const int end = std::min(begin + kRun, columns_);
      Box3 box(centre_of(begin, row));
      box.extend(centre_of(end - 1, row));
      if (!domain_.may_hold_object(box.min(), box.max())) continue;
      for (int column = begin; column < end; ++column)
        materials_[static_cast<std::size_t>(column) +
                   static_cast<std::size_t>(columns_) * static_cast<std::size_t>(row)] =
            material_of(centre_of(column, row));
    }
  }

  /// None where another plane cuts nearer, as one in the same place.
  [[nodiscard]] Material material_of(const Vec3& x) const {
    const Material m = domain_.material_at(x);
    return domain_.is_meshed(m) && domain_.material_at(x + 2 * inside_mm_ * normal_) != beyond_ ? 0 : m;
  }

  const Domain& domain_;
  Material beyond_;
  Vec3 normal_, u_, v_, first_;
  double step_, inside_mm_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<Material> materials_;
};

/// The openings of one cut plane.
class PlaneOpenings {
 public:
  PlaneOpenings(const Domain& domain, std::size_t cut)
      : domain_(domain),
        plane_(domain.cut_planes()[cut]),
        beyond_(domain.material_beyond(cut)),
        u_(plane_.normal.unitOrthogonal()),
        v_(plane_.normal.cross(u_)) {}

  /// Found on a coarse grid, measured on a fine one each.
  [[nodiscard]] std::vector<Opening> find() const {
    constexpr double kCoarse = 0.4;  // Voxels.
    const PlaneGrid coarse = whole_plane(kCoarse * domain_.finest_resolution_mm());
    const std::vector<std::uint32_t> part = coarse.parts();
    std::vector<std::vector<std::size_t>> squares;
    for (std::size_t s = 0; s < part.size(); ++s) {
      if (part[s] == 0) continue;
      squares.resize(std::max(squares.size(), std::size_t{part[s]}));
      squares[part[s] - 1].push_back(s);
    }
    std::vector<std::size_t> order(squares.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    // The largest first: the fine grid of a part ends a voxel around it, and where parts are one on it, the
    // smaller one would be measured with what of the larger one happens to lie there.
    std::ranges::stable_sort(
        order, [&](std::size_t a, std::size_t b) { return squares[a].size() > squares[b].size(); });
    std::map<std::size_t, Opening> by_part;
    for (const std::size_t p : order) {
      const Vec3 place = coarse.centre_of(squares[p].front());
      const Label label = domain_.label_of(coarse.material(squares[p].front()));
      const bool is_known = std::ranges::any_of(by_part, [&](const auto& known) {
        return known.second.label == label && known.second.squares->hold(place);
      });
      if (is_known) continue;  // On the fine grid the two were one.
      Opening found = measure(coarse, squares[p]);
      if (found.area_mm2 >= kMinArea * voxel_face_mm2(domain_, plane_.normal))
        by_part.emplace(p, std::move(found));
    }
    std::vector<Opening> openings;
    for (auto& [number, opening] : by_part) openings.push_back(std::move(opening));
    name_as_planned(openings);
    return openings;
  }

  /// Part of the plane that may cut the object.
  [[nodiscard]] PlaneGrid whole_plane(double step_mm) const {
    if (plane_.section)
      return {domain_, beyond_, plane_, u_, v_, plane_.point_mm, plane_.radius_mm, plane_.radius_mm, step_mm};
    const Box3 bounds = domain_.bounds_mm();
    double half_u = 0, half_v = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 off = bounds.corner(static_cast<Box3::CornerType>(corner)) - bounds.center();
      half_u = std::max(half_u, std::abs(off.dot(u_)));
      half_v = std::max(half_v, std::abs(off.dot(v_)));
    }
    return {domain_, beyond_, plane_, u_, v_, bounds.center(), half_u, half_v, step_mm};
  }

 private:
  static constexpr double kMinArea = 0.5;  // Voxel faces.

  /// The largest of a label gets the first of its names.
  void name_as_planned(std::vector<Opening>& openings) const {
    for (const auto& [label, name] : plane_.names) {
      Opening* largest = nullptr;
      for (Opening& o : openings)
        if (o.label == label && o.name.empty() && (largest == nullptr || o.area_mm2 > largest->area_mm2))
          largest = &o;
      if (largest != nullptr) largest->name = name;
    }
  }

  [[nodiscard]] Opening measure(const PlaneGrid& coarse, const std::vector<std::size_t>& squares) const {
    constexpr double kSquares = 160;               // Along the longer side …
    constexpr double kFinest = 0.06, kFine = 0.4;  // … as long as they are so many voxels.
    const double margin_mm = domain_.finest_resolution_mm();
    std::array<double, 2> low, high;
    low.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
    for (const std::size_t s : squares) {
      const Vec3 x = coarse.centre_of(s);
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double at = x.dot(axis == 0 ? u_ : v_);
        low[axis] = std::min(low[axis], at - margin_mm);
        high[axis] = std::max(high[axis], at + margin_mm);
      }
    }
    const double half_u = 0.5 * (high[0] - low[0]), half_v = 0.5 * (high[1] - low[1]);
    const Vec3 on_plane = plane_.normal.dot(plane_.point_mm) * plane_.normal;
    const Vec3 middle = on_plane + 0.5 * (low[0] + high[0]) * u_ + 0.5 * (low[1] + high[1]) * v_;
    const double step =
        std::clamp(2 * std::max(half_u, half_v) / kSquares, kFinest * margin_mm, kFine * margin_mm);
    const PlaneGrid fine(domain_, beyond_, plane_, u_, v_, middle, half_u, half_v, step);
    return sum(fine, coarse, squares);
  }

  /// Opening of the parts on the fine grid that the coarse one's squares belong to.
  [[nodiscard]] Opening sum(const PlaneGrid& fine, const PlaneGrid& coarse,
                            const std::vector<std::size_t>& squares) const {
    const std::vector<std::uint32_t> part = fine.parts();
    std::vector<bool> is_mine(part.size() + 1, false);
    const Material material = coarse.material(squares.front());
    for (const std::size_t s : squares) {
      const std::size_t at = fine.square_at(coarse.centre_of(s));
      if (fine.material(at) == material) is_mine[part[at]] = true;
    }
    Opening opening;
    opening.label = domain_.label_of(material);
    opening.normal = plane_.normal + Vec3::Zero();  // No -0.
    opening.voxel_mm = std::sqrt(voxel_face_mm2(domain_, plane_.normal));
    std::vector<std::uint8_t> is_inside(part.size(), 0);
    for (std::size_t s = 0; s < part.size(); ++s)
      if (part[s] != 0 && is_mine[part[s]]) is_inside[s] = 1;
    const FlatShape shape = fine.shape_of(material, is_inside);
    opening.squares = fine.squares(std::move(is_inside));
    if (!(shape.area_mm2 > 0)) return opening;
    opening.area_mm2 = shape.area_mm2;
    opening.box_mm = shape.box_mm;
    opening.centre_mm = shape.moment / shape.area_mm2;
    opening.centre_mm -= plane_.normal.dot(opening.centre_mm - plane_.point_mm) * plane_.normal;
    return opening;
  }

  const Domain& domain_;
  const CutPlane& plane_;
  Material beyond_;
  Vec3 u_, v_;
};

double off_plane_mm(const FlatEnd& end) {
  double off_mm = 0;
  for (const std::array<Vec3, 3>& corners : end.triangles_mm)
    for (const Vec3& p : corners) off_mm = std::max(off_mm, std::abs(end.normal.dot(p - end.centre_mm)));
  return off_mm;
}

}  // namespace

std::vector<Opening> openings_of(std::span<const FlatEnd> ends, double resolution_mm) {
  std::vector<Opening> all;
  for (const FlatEnd& end : ends)
    all.push_back({.label = 1,
                   .area_mm2 = end.area_mm2,
                   .centre_mm = end.centre_mm,
                   .normal = end.normal,
                   .box_mm = end.box_mm,
                   .voxel_mm = resolution_mm,
                   .squares = squares_of(end),
                   .is_of_surface = true,
                   .off_mm = off_plane_mm(end),
                   .name = end.name});
  return all;
}

std::vector<Opening> find_openings(const Domain& domain) {
  std::vector<Opening> all = openings_of(domain.flat_ends(), domain.resolution_mm());
  if (!all.empty()) return all;
  std::vector<OpeningNeighbours> neighbours;
  for (std::size_t cut = 0; cut < domain.cut_planes().size(); ++cut) {
    const std::vector<Opening> more = PlaneOpenings(domain, cut).find();
    all.insert(all.end(), more.begin(), more.end());
    for (OpeningNeighbours& of_one : neighbours_in_plane(more)) neighbours.push_back(std::move(of_one));
  }
  mark_rims(neighbours, all);
  sort_by_area(all, [](const Opening& o) { return AreaAtPlace{o.area_mm2, o.centre_mm}; });
  name_openings(PatchNaming(domain.label_names()), all);
  return all;
}

std::vector<RimPlace> find_rim_places(const Domain& domain, double step_mm) {
  std::vector<RimPlace> places;
  const auto cuts = domain.cut_planes();
  for (std::size_t c = 0; c < cuts.size(); ++c) {
    const Material beyond = domain.material_beyond(c);
    const PlaneGrid grid = PlaneOpenings(domain, c).whole_plane(step_mm);
    grid.for_each_change([&](const Vec3& place, Material inside, Material beside) {
      if (beside != beyond) places.push_back({place, {inside, beside, beyond}});
    });
  }
  return places;
}

std::vector<NamedOpening> named_openings(std::span<const Opening> openings) {
  std::vector<NamedOpening> result;
  for (const Opening& o : openings) result.push_back({o.name, o.centre_mm, o.radius_mm(), o.is_rim});
  return result;
}

double voxel_face_mm2(const Domain& domain, const Vec3& normal) {
  return std::pow(domain.resolution_mm(), 3) / domain.resolution_along_mm(normal);
}

std::size_t opening_of_places(std::span<const Opening> openings, Label label, std::span<const Vec3> places_mm,
                              const Vec3& normal) {
  constexpr double kSamePlane = 0.9;  // Cosine.
  const bool is_known = has_label(openings, label);
  std::size_t best = openings.size(), most = 0;
  double smallest_mm = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < openings.size(); ++i) {
    const Opening& o = openings[i];
    if ((is_known && o.label != label) || o.normal.dot(normal) < kSamePlane) continue;
    std::size_t held = 0;
    double off_mm = std::numeric_limits<double>::infinity();
    for (const Vec3& place : places_mm) {
      if (std::abs(o.normal.dot(place - o.centre_mm)) > o.voxel_mm) continue;
      held += o.squares && o.squares->hold(place) ? 1 : 0;
      off_mm = std::min(off_mm, o.box_mm.exteriorDistance(place));
    }
    if (!is_known && 2 * held < places_mm.size()) continue;
    if (off_mm > o.voxel_mm || held < most || (held == most && off_mm >= smallest_mm)) continue;
    best = i;
    most = held;
    smallest_mm = off_mm;
  }
  return best;
}

}  // namespace lumesh
