#pragma once
/// @file The tetrahedra around one vertex in the metric of that vertex alone, where lengths are Euclidean.

#include <cstdint>
#include <vector>

#include "neighbourhoods.hpp"

namespace lumesh::operators {

/// For decisions that need not be fine: no neighbour's metric is looked at, and all of it is a few dozen
/// numbers.
class UniformStar {
 public:
  void gather(const TetMesh& mesh, VertexId v, VertexBall& ball);

  /// Cube of the worst mean ratio.
  [[nodiscard]] double worst_cubed() const;

  /// The place in ball.neighbours of the nearest one at less than `max_length` that was not given yet;
  /// equally near ones by coordinates.
  /// @return false if there is none.
  bool next_nearest(double max_length, std::uint32_t& place);

  /// True if no tetrahedron falls below the floor once v is where its neighbour is.
  /// @param qualities  Of them all, in the order of ball.tets; -1 where one vanishes.
  [[nodiscard]] bool fits_at(std::uint32_t place, double floor_cubed, std::vector<float>& qualities) const;

 private:
  struct Neighbour {
    Vec3 at;  // From v, in units of its metric.
    double squared_length = 0;
    bool given = false;
  };
  /// Share of one tetrahedron in the sums below, with its other corners a, b, c.
  struct Face {
    std::array<std::uint32_t, 3> corners;  // Places of neighbours; positively oriented with v behind them.
    Vec3 normal;                           // (b - a) x (c - a).
    double offset;                         // normal . a
    Vec3 sum;                              // a + b + c
    double squares;                        // Of the edges of a, b, c and of their distances from v.
  };
  /// Cube of the mean ratio of the tetrahedron of a face with v at p.
  [[nodiscard]] static double ratio_cubed(const Face& face, const Vec3& p);

  std::vector<Neighbour> neighbours_;
  std::vector<Face> faces_;
};

}  // namespace lumesh::operators
