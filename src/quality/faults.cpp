#include "lumesh/quality/faults.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/mesh/triangle_sides.hpp"
#include "lumesh/parallel/sum.hpp"
#include "lumesh/quality/surface.hpp"
#include "validity.hpp"

namespace lumesh::quality {

namespace {

std::string at(const Vec3& x) {
  return "at " + coordinates_text(x);
}

/// Before the place of one of them.
const char* one_of(std::uint64_t count) {
  return count == 1 ? "" : "one ";
}

/// How many, and one of them.
struct Count {
  std::uint64_t count = 0;
  std::size_t first = 0;

  void add(std::size_t what) {
    if (count == 0) first = what;
    ++count;
  }
  void add(const Count& more) {
    if (count == 0) first = more.first;
    count += more.count;
  }
};

class Faults {
 public:
  explicit Faults(const MeshView& mesh)
      : mesh_(mesh), cells_(mesh), origin_(mesh.points.empty() ? Vec3(Vec3::Zero()) : mesh.points[0]) {}

  std::vector<MeshFault> find() {
    if (!look_at_points()) return std::move(faults_);
    look_at_cells();
    look_at_faces();
    look_at_edges();
    look_at_crossings();
    look_at_volume();
    return std::move(faults_);
  }

 private:
  /// What follows needs numbers.
  bool look_at_points() {
    const auto bad = std::ranges::find_if(mesh_.points, [](const Vec3& x) { return !is_place(x); });
    if (bad == mesh_.points.end()) return true;
    const auto number = bad - mesh_.points.begin();
    faults_.push_back({bad->allFinite()
                           ? fmt::format("point {} lies beyond {:g}, {}", number, kFarthest, at(*bad))
                           : fmt::format("point {} has a coordinate that is not finite", number)});
    return false;
  }

  [[nodiscard]] bool is_positive(std::size_t cell) const {
    if (cell >= mesh_.tetrahedra.size()) return cells_.volume(cell) > 0 && !cells_.has_turned_corner(cell);
    const auto& [a, b, c, d] = mesh_.tetrahedra[cell];
    return orient3d(mesh_.points[a], mesh_.points[b], mesh_.points[c], mesh_.points[d]) > 0;
  }

  void look_at_cells() {
    struct Sums {
      Count turned;
      double volume = 0, magnitude = 0;
    };
    const Sums sums = parallel::reduce(
        cells_.size(), kBlock, Sums(),
        [&](Sums& part, std::size_t i) {
          if (!is_positive(i)) part.turned.add(i);
          const double volume = cells_.volume(i);
          part.volume += volume;
          part.magnitude += std::abs(volume);
        },
        [](Sums a, const Sums& b) {
          a.turned.add(b.turned);
          a.volume += b.volume;
          a.magnitude += b.magnitude;
          return a;
        });
    volume_ = sums.volume;
    magnitude_ = sums.magnitude;
    if (sums.turned.count == 0) return;
    const CellTriangles faces = cells_.triangles(sums.turned.first);
    const Vec3& place = mesh_.points[faces.items[0][0]];
    faults_.push_back(
        {fmt::format("{} flat or turned inside out, {}{}", counted(sums.turned.count, "cell is", "cells are"),
                     one_of(sums.turned.count), at(place)),
         place});
  }

  /// The outside are the faces that only one cell has, whatever patches they are in.
  void look_at_faces() {
    const MeshSurface surface = extract_surface(mesh_);
    outside_ = surface.outer();
    if (surface.overfull_faces > 0)
      faults_.push_back({counted(surface.overfull_faces, "face has", "faces have") + " more than two cells"});
  }

  void look_at_edges() {
    const std::vector<TriangleSide> sides = sorted_sides(outside_);
    const auto runs_up = [&](const TriangleSide& side) { return side.runs_up(outside_[side.triangle]); };
    Count bad;
    for_each_edge(sides, [&](std::span<const TriangleSide> edge) {
      if (edge.size() != 2 || runs_up(edge[0]) == runs_up(edge[1]))
        bad.add(static_cast<std::size_t>(edge.data() - sides.data()));
    });
    if (bad.count == 0) return;
    const TriangleSide& edge = sides[bad.first];
    const Vec3 place = 0.5 * (mesh_.points[edge.low] + mesh_.points[edge.high]);
    faults_.push_back({fmt::format("{} not have one face on each side, {}{}",
                                   counted(bad.count, "edge of the outside does", "edges of the outside do"),
                                   one_of(bad.count), at(place)),
                       place});
  }

  void look_at_crossings() {
    const std::vector<SelfCrossing> crossings = find_self_crossings(mesh_.points, outside_);
    if (crossings.empty()) return look_at_sheets();
    const Vec3& place = crossings.front().place;
    faults_.push_back({fmt::format("the outside crosses or touches itself: {}, {}{}",
                                   counted(crossings.size(), "pair of triangles", "pairs of triangles"),
                                   one_of(crossings.size()), at(place)),
                       place});
  }

  void look_at_sheets() {
    if (!faults_.empty()) return;  // It has to be closed.
    const std::vector<Vec3> places = find_doubled_places(mesh_.points, outside_);
    if (!places.empty())
      faults_.push_back({fmt::format("{}, {}{}",
                                     counted(places.size(), "piece of the mesh lies within another",
                                             "pieces of the mesh lie within others"),
                                     one_of(places.size()), at(places.front())),
                         places.front()});
  }

  /// The divergence theorem: a third of the flux of the position through the outside is the volume within.
  void look_at_volume() {
    double enclosed = 0;
    for (const auto& [a, b, c] : outside_)
      enclosed +=
          (mesh_.points[a] - origin_).dot((mesh_.points[b] - origin_).cross(mesh_.points[c] - origin_)) / 6;
    constexpr double kRounding = 1e-9;
    if (std::abs(enclosed - volume_) <= kRounding * (magnitude_ + std::abs(enclosed))) return;
    faults_.push_back(
        {fmt::format("the cells fill {:.9g} {}3 but the outside encloses {:.9g}: there are gaps or "
                     "overlaps within",
                     volume_, mesh_.info->unit, enclosed)});
  }

  static constexpr std::size_t kBlock = 8192;

  const MeshView& mesh_;
  AllCells cells_;
  Vec3 origin_;  // Near the mesh, so that little cancels.
  std::vector<Cell<3>> outside_;
  double volume_ = 0, magnitude_ = 0;
  std::vector<MeshFault> faults_;
};

}  // namespace

std::vector<MeshFault> find_placed_faults(const MeshView& mesh) {
  return Faults(mesh).find();
}

std::vector<std::string> find_faults(const MeshView& mesh) {
  std::vector<std::string> lines;
  for (MeshFault& fault : find_placed_faults(mesh)) lines.push_back(std::move(fault.text));
  return lines;
}

}  // namespace lumesh::quality
