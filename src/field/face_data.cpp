#include "face_data.hpp"

#include <cmath>

#include "lumesh/core/sort_unique.hpp"
#include "lumesh/core/wide.hpp"
#include "segment_loops.hpp"
#include "stencil.hpp"

namespace lumesh::field {

namespace {

constexpr float kGrazing = 0.25F;  // least variance, relative: faces that the boundary grazes
constexpr float kSteep = 0.6F;
constexpr float kAgainst = 0.2F;

/// The axes beside a face's own, in the order of FacePoints.
constexpr std::array<std::array<int, 2>, 3> kBeside = {{{1, 2}, {0, 2}, {0, 1}}};

/// Unit normals in the middles of faces, along the face's axis and those beside it.
struct FaceNormals {
  Lanes own, first, second;
};

template <int axis>
[[gnu::always_inline]] inline FaceNormals face_normals(const Stencil& u,
                                                       const std::array<float, 3>& per_edge) {
  const auto p = face_points<axis, const Lanes>(u);
  constexpr auto kOthers = kBeside[axis];
  const Lanes own = ((p.upper - p.before) + (p.after - p.lower)) * per_edge[axis];
  const Lanes first = ((p.first_p - p.first_m) + (p.first_p_upper - p.first_m_upper)) * per_edge[kOthers[0]];
  const Lanes second =
      ((p.second_p - p.second_m) + (p.second_p_upper - p.second_m_upper)) * per_edge[kOthers[1]];
  const Lanes length = square_root(own * own + first * first + second * second + 1e-30F);
  return {own / length, first / length, second / length};
}

std::array<float, 3> per_edge_of(const Band& band) {
  const Vec3 inverse = band.edges().cwiseInverse();
  return {static_cast<float>(inverse.x()), static_cast<float>(inverse.y()), static_cast<float>(inverse.z())};
}

/// A normal that points against the voxels' sides by more than kAgainst says nothing: between two walls that
/// are close the function may still have one slope for both. The weights stay as they were then; at first the
/// face's own axis stands for the normal.
template <int axis>
[[gnu::always_inline]] inline void weigh_faces(const Stencil& u, std::uint8_t faces, std::uint8_t plus,
                                               const std::array<float, 3>& per_edge, float volume, int entry,
                                               FaceWeights& weights) {
  FaceNormals n = face_normals<axis>(u, per_edge);
  const Lanes forward =
      mask_of(plus) ? Lanes{} - 1.0F : Lanes{} + 1.0F;  // along the axis, towards the plus side
  const LaneMask is_against = n.own * forward < Lanes{} - kAgainst;
  const LaneMask stays = is_against & (load(weights.at(entry, FaceWeights::kPlace)) > Lanes{});
  n = {is_against ? forward : n.own, is_against ? Lanes{} : n.first, is_against ? Lanes{} : n.second};
  const LaneMask is_face = mask_of(faces);
  const float edge = 1 / per_edge[axis], area = volume * per_edge[axis];
  const Lanes variance = n.own * n.own * (edge * edge);
  const Lanes place = area / (variance > Lanes{} + kGrazing ? variance : Lanes{} + kGrazing);
  const float scale = std::sqrt(static_cast<float>(kSlope) * area);
  const auto set = [&](FaceWeights::Part part, const Lanes& value) {
    float* const to = weights.at(entry, part);
    store(to, stays ? load(to) : keep(value, is_face));
  };
  set(FaceWeights::kPlace, place);
  set(FaceWeights::kOwn, n.own * (scale * per_edge[axis]));
  set(FaceWeights::kFirst, n.first * (0.25F * scale * per_edge[kBeside[axis][0]]));
  set(FaceWeights::kSecond, n.second * (0.25F * scale * per_edge[kBeside[axis][1]]));
  set(FaceWeights::kTarget, Lanes{} + scale);
}

LUMESH_WIDE_LOOPS void weigh_block(const Band& band, const LaneArray& function,
                                   const std::array<float, 3>& per_edge, float volume, int begin, int end,
                                   FaceWeights& weights) {
  for (int s = begin; s < end; ++s) {
    int entry = band.first_entry(s);
    if (entry == band.first_entry(s + 1)) continue;
    const Stencil u = gather(band.rows(s), s, function.data());
    if (band.faces(s, 0) != 0)
      weigh_faces<0>(u, band.faces(s, 0), band.plus(s), per_edge, volume, entry++, weights);
    if (band.faces(s, 1) != 0)
      weigh_faces<1>(u, band.faces(s, 1), band.plus(s), per_edge, volume, entry++, weights);
    if (band.faces(s, 2) != 0)
      weigh_faces<2>(u, band.faces(s, 2), band.plus(s), per_edge, volume, entry++, weights);
  }
}

template <int axis>
std::uint8_t steep(const Stencil& u, std::uint8_t faces, const std::array<float, 3>& per_edge) {
  const FaceNormals n = face_normals<axis>(u, per_edge);
  unsigned bits = 0;
  for (unsigned lane = 0; lane < kLanes; ++lane)
    bits |= static_cast<unsigned>(std::abs(n.own[lane]) > kSteep) << lane;
  return static_cast<std::uint8_t>(bits & faces);
}

/// The entries and lanes of a voxel's faces.
void add_faces_of(const Band& band, Lane voxel, std::vector<int>& out) {
  for (int axis = 0; axis < 3; ++axis) {
    const Index3 back = -Index3::Unit(axis);
    for (const Lane lane : {voxel, band.neighbour(voxel, back.x(), back.y(), back.z())}) {
      const int s = lane / kLanes;
      if (!Band::has(band.faces(s, axis), lane % kLanes)) continue;
      out.push_back(band.entry_of(s, axis) * kLanes + lane % kLanes);
    }
  }
}

}  // namespace

void set_face_weights(const LaneArray& function, FitState& state) {
  const std::array<float, 3> per_edge = per_edge_of(state.band);
  const auto volume = static_cast<float>(state.band.edges().prod());
  for_each_segment_block(state.band.end(), [&](int begin, int end) {
    weigh_block(state.band, function, per_edge, volume, begin, end, state.energy.faces);
  });
}

std::vector<std::array<std::uint8_t, 3>> steep_faces(const LaneArray& function, const FitState& state) {
  const Band& band = state.band;
  const std::array<float, 3> per_edge = per_edge_of(band);
  std::vector<std::array<std::uint8_t, 3>> result(band.segment_count());
  for_each_segment_block(band.end(), [&](int begin, int end) {
    for (int s = begin; s < end; ++s) {
      if (band.first_entry(s) == band.first_entry(s + 1)) continue;
      const Stencil u = gather(band.rows(s), s, function.data());
      result[static_cast<std::size_t>(s)] = {steep<0>(u, band.faces(s, 0), per_edge),
                                             steep<1>(u, band.faces(s, 1), per_edge),
                                             steep<2>(u, band.faces(s, 2), per_edge)};
    }
  });
  return result;
}

void DampedFaces::damp(FitState& state) {
  std::vector<int> damped;
  for (int s = 1; s < state.band.end(); ++s) {
    const std::uint8_t outlier = state.outlier[static_cast<std::size_t>(s)];
    for (int lane = 0; outlier != 0 && lane < kLanes; ++lane)
      if (Band::has(outlier, lane)) add_faces_of(state.band, s * kLanes + lane, damped);
  }
  sort_unique(damped);
  for (const int at : damped) {
    Saved saved{at, {}};
    for (std::uint8_t p = 0; p < FaceWeights::kPartCount; ++p) {
      float& weight = state.energy.faces.at(at / kLanes, static_cast<FaceWeights::Part>(p))[at % kLanes];
      saved.parts[p] = weight;
      weight *= p == FaceWeights::kPlace ? kOutlierShare : std::sqrt(kOutlierShare);
    }
    saved_.push_back(saved);
  }
}

void DampedFaces::restore(FitState& state) {
  for (const Saved& saved : saved_)
    for (std::uint8_t p = 0; p < FaceWeights::kPartCount; ++p)
      state.energy.faces.at(saved.at / kLanes, static_cast<FaceWeights::Part>(p))[saved.at % kLanes] =
          saved.parts[p];
  saved_.clear();
}

}  // namespace lumesh::field
