#pragma once
/// @file Faults put into sound surfaces, the same for the same seed.

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "lumesh/geometry/hilbert.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/triangle_mesh.hpp"
#include "lumesh/surface/rims.hpp"

namespace lumesh::surfaces {

class FaultMaker {
 public:
  FaultMaker(TriangleMesh surface, unsigned seed) : surface_(std::move(surface)), random_(seed) {
    for (const Vec3& p : surface_.points) box_.extend(p);
    is_at_rim_.assign(surface_.points.size(), 0);
    for (const Rim& rim : find_rims(surface_))
      for (const std::uint32_t v : rim.vertices) is_at_rim_[v] = 1;
  }

  /// Triangles around some places taken out.
  TriangleMesh with_holes(int count = 5) {
    std::vector<std::uint8_t> is_gone(surface_.triangles.size(), 0);
    for (int n = 0; n < count; ++n)
      for (const std::uint32_t t : small_patch(1)) is_gone[t] = 1;
    TriangleMesh result = surface_;
    result.triangles.clear();
    result.patches.clear();
    for (std::size_t t = 0; t < is_gone.size(); ++t)
      if (is_gone[t] == 0) {
        result.triangles.push_back(surface_.triangles[t]);
        result.patches.push_back(surface_.patches[t]);
      }
    return result;
  }
  TriangleMesh with_turned(double share = 0.05) {
    TriangleMesh result = surface_;
    for (Cell<3>& t : result.triangles)
      if (std::uniform_real_distribution(0.0, 1.0)(random_) < share) std::swap(t[0], t[1]);
    return result;
  }
  /// Some vertices pulled across the edge opposite to them.
  TriangleMesh with_folds(int count = 5) {
    TriangleMesh result = surface_;
    for (int n = 0; n < count; ++n) {
      const Cell<3>& t = surface_.triangles[any_triangle()];
      const Vec3 middle = (surface_.points[t[1]] + surface_.points[t[2]]) / 2;
      if ((middle - surface_.points[t[0]]).norm() < 0.005 * box_.diagonal().norm())
        result.points[t[0]] = surface_.points[t[0]] + 1.4 * (middle - surface_.points[t[0]]);
    }
    return result;
  }
  /// Pieces of the wall there twice, the copies a little turned and moved so that they cross it.
  TriangleMesh with_overlaps(int count = 3) {
    TriangleMesh result = surface_;
    for (int n = 0; n < count; ++n) {
      const std::vector<std::uint32_t> patch = small_patch(2);
      if (patch.empty()) continue;
      const Vec3 centre = middle_of(patch.front());
      const Eigen::AngleAxisd turn(0.05, random_direction());
      for (const std::uint32_t t : patch)
        append(result, t, [&](const Vec3& p) {
          return Vec3(centre + turn * (p - centre) + 2e-4 * box_.diagonal().norm() * Vec3::Ones());
        });
    }
    return result;
  }
  /// The whole again, scaled by a factor from its middle.
  TriangleMesh with_shell_again(double factor) {
    TriangleMesh result = surface_;
    const Vec3 centre = box_.center();
    for (std::uint32_t t = 0; t < surface_.triangles.size(); ++t)
      append(result, t, [&](const Vec3& p) { return Vec3(centre + factor * (p - centre)); });
    return result;
  }
  /// Triangles that stand on edges of the wall.
  TriangleMesh with_fins(int count = 5) {
    TriangleMesh result = surface_;
    for (int n = 0; n < count; ++n) {
      const std::uint32_t t = any_triangle();
      const Cell<3> corners = surface_.triangles[t];
      const Vec3 tip = middle_of(t) + 0.005 * box_.diagonal().norm() * random_direction();
      result.triangles.push_back({corners[0], corners[1], static_cast<std::uint32_t>(result.points.size())});
      result.patches.push_back(surface_.patches[t]);
      result.points.push_back(tip);
    }
    return result;
  }
  TriangleMesh with(const std::string& kind) {
    if (kind == "holes") return with_holes();
    if (kind == "turned") return with_turned();
    if (kind == "folds") return with_folds();
    if (kind == "overlaps") return with_overlaps();
    if (kind == "same shell") return with_shell_again(1);
    if (kind == "scaled shell") return with_shell_again(1.001);
    if (kind == "fins") return with_fins();
    return FaultMaker(FaultMaker(with_folds(), random_()).with_holes(), random_()).with_turned();  // "all"
  }
  static const std::vector<std::string>& kinds() {
    static const std::vector<std::string> all = {"holes",      "turned",       "folds", "overlaps",
                                                 "same shell", "scaled shell", "fins",  "all"};
    return all;
  }

 private:
  std::uint32_t any_triangle() { return static_cast<std::uint32_t>(random_() % surface_.triangles.size()); }
  Vec3 random_direction() {
    std::normal_distribution<double> normal;
    return Vec3(normal(random_), normal(random_), normal(random_)).normalized();
  }
  [[nodiscard]] Vec3 middle_of(std::uint32_t t) const {
    const auto& [a, b, c] = surface_.triangles[t];
    return (surface_.points[a] + surface_.points[b] + surface_.points[c]) / 3;
  }
  /// Around a place where its size is 8 % of the whole at most; fewer rings, or nothing, if there is
  /// none.
  std::vector<std::uint32_t> small_patch(int rings) {
    constexpr int kTrials = 50;
    for (; rings >= 0; --rings)
      for (int trial = 0; trial < kTrials; ++trial) {
        std::vector<std::uint32_t> patch = patch_around(any_triangle(), rings);
        Box3 box;
        bool is_at_rim = false;  // What is missing there nobody knows.
        for (const std::uint32_t t : patch)
          for (const std::uint32_t v : surface_.triangles[t]) {
            box.extend(surface_.points[v]);
            is_at_rim = is_at_rim || is_at_rim_[v] != 0;
          }
        if (!is_at_rim && box.diagonal().norm() < 0.08 * box_.diagonal().norm()) return patch;
      }
    return {};
  }
  [[nodiscard]] std::vector<std::uint32_t> patch_around(std::uint32_t seed, int rings) const {
    std::vector<std::uint8_t> is_in(surface_.triangles.size(), 0), is_reached(surface_.points.size(), 0);
    is_in[seed] = 1;
    for (int ring = 0; ring < rings; ++ring) {
      for (std::size_t t = 0; t < is_in.size(); ++t)
        if (is_in[t] != 0)
          for (const std::uint32_t v : surface_.triangles[t]) is_reached[v] = 1;
      for (std::size_t t = 0; t < is_in.size(); ++t)
        for (const std::uint32_t v : surface_.triangles[t])
          if (is_reached[v] != 0) is_in[t] = 1;
    }
    std::vector<std::uint32_t> patch;
    for (std::uint32_t t = 0; t < is_in.size(); ++t)
      if (is_in[t] != 0) patch.push_back(t);
    return patch;
  }
  template <class Move>
  void append(TriangleMesh& result, std::uint32_t t, const Move& move) const {
    Cell<3> corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      corners[i] = static_cast<std::uint32_t>(result.points.size());
      result.points.push_back(move(surface_.points[surface_.triangles[t][i]]));
    }
    result.triangles.push_back(corners);
    result.patches.push_back(surface_.patches[t]);
  }

  const TriangleMesh surface_;
  std::mt19937 random_;
  Box3 box_;
  std::vector<std::uint8_t> is_at_rim_;  // Of each point.
};

}  // namespace lumesh::surfaces
