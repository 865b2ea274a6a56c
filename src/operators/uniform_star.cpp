#include "uniform_star.hpp"

#include <algorithm>
#include <cmath>

#include "cavity.hpp"
#include "lumesh/metric/measures.hpp"

namespace lumesh::operators {
void UniformStar::gather(const TetMesh& mesh, VertexId v, VertexBall& ball) {
  const MetricFrame from_v(mesh.metric(v), mesh.point(v));
  neighbours_.clear();
  for (const std::uint32_t w : ball.neighbours) {
    const Vec3 at = from_v(mesh.point(VertexId(w)));
    neighbours_.push_back({at, at.squaredNorm()});
  }
  faces_.clear();
  for (const TetId t : ball.tets) {
    const auto [i, j, k] = kTetFaces[mesh.index_of(t, v)];
    const Cell<4>& corners = mesh.tet(t);
    const std::array<std::uint32_t, 3> places = {*ball.places.find(corners[i]), *ball.places.find(corners[k]),
                                                 *ball.places.find(corners[j])};
    const Neighbour &a = neighbours_[places[0]], &b = neighbours_[places[1]], &c = neighbours_[places[2]];
    const Vec3 ab = b.at - a.at, ac = c.at - a.at, normal = ab.cross(ac);
    faces_.push_back({places, normal, normal.dot(a.at), a.at + b.at + c.at,
                      ab.squaredNorm() + ac.squaredNorm() + (c.at - b.at).squaredNorm() + a.squared_length +
                          b.squared_length + c.squared_length});
  }
}

double UniformStar::ratio_cubed(const Face& face, const Vec3& p) {
  const double volumes = face.normal.dot(p) - face.offset;
  const double squares = face.squares + 3 * p.squaredNorm() - 2 * face.sum.dot(p);
  return 432 * volumes * std::abs(volumes) / (squares * squares * squares);
}

double UniformStar::worst_cubed() const {
  double worst = 1;
  for (const Face& face : faces_) worst = std::min(worst, ratio_cubed(face, Vec3::Zero()));
  return worst;
}

bool UniformStar::next_nearest(double max_length, std::uint32_t& place) {
  Neighbour* nearest = nullptr;
  for (Neighbour& one : neighbours_) {
    if (one.given || one.squared_length >= max_length * max_length) continue;
    if (nearest == nullptr || one.squared_length < nearest->squared_length ||
        (one.squared_length == nearest->squared_length &&
         std::lexicographical_compare(one.at.begin(), one.at.end(), nearest->at.begin(), nearest->at.end())))
      nearest = &one;
  }
  if (nearest == nullptr) return false;
  nearest->given = true;
  place = static_cast<std::uint32_t>(nearest - neighbours_.data());
  return true;
}

bool UniformStar::fits_at(std::uint32_t place, double floor_cubed, std::vector<float>& qualities) const {
  const Vec3& p = neighbours_[place].at;
  qualities.clear();
  for (const Face& face : faces_) {
    if (std::ranges::find(face.corners, place) != face.corners.end()) {
      qualities.push_back(-1);
      continue;
    }
    const double cubed = ratio_cubed(face, p);
    if (!(cubed > 0) || cubed < floor_cubed) return false;
    qualities.push_back(static_cast<float>(metric::cube_root(cubed)));
  }
  return true;
}

}  // namespace lumesh::operators
