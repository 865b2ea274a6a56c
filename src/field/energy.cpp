// Rows of the quadratic form are products of one-dimensional differences, so that all of them come from the
// twenty values around a voxel; a row that reaches outside the band is NaN and counts nothing (natural
// boundary conditions).
#include "energy.hpp"

#include "differences.hpp"
#include "lumesh/core/wide.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::field {

namespace {

/// The rows times their weights, 0 where a row reaches outside the band.
[[gnu::always_inline]] inline Differences weighted(const Differences& d, const DifferenceWeights& w,
                                                   const Lanes& stiffness) {
  const auto times = [&](const Lanes& row, float weight) __attribute__((always_inline)) {
    return keep_numbers(row) * (stiffness * weight);
  };
  return {times(d.xxx, w.xxx), times(d.yyy, w.yyy), times(d.zzz, w.zzz), times(d.xxy, w.xxy),
          times(d.xyy, w.xyy), times(d.xxz, w.xxz), times(d.xzz, w.xzz), times(d.yyz, w.yyz),
          times(d.yzz, w.yzz), times(d.xyz, w.xyz), times(d.xx, w.xx),   times(d.yy, w.yy),
          times(d.zz, w.zz),   times(d.xy, w.xy),   times(d.xz, w.xz),   times(d.yz, w.yz)};
}

[[gnu::always_inline]] inline void subtract_targets(const DifferenceTargets& targets, int segment,
                                                    Differences& d) {
  const std::int32_t place = targets.place.empty() ? 0 : targets.place[static_cast<std::size_t>(segment)];
  if (place == 0) return;
  const auto rows = rows_of(d);
  for (std::size_t n = 0; n < kDifferenceCount; ++n) *rows[n] -= load(targets.rows[n].at(place));
}

/// out = the transpose of the rows, times them.
[[gnu::always_inline]] inline void transpose(const Differences& d, Stencil& out) {
  // The transposes of the same factors. c… is the coefficient of the second difference …, d… of a first one.
  const Lanes cxx = d.xx - d.xxx - d.xxy - d.xxz, cyy = d.yy - d.yyy - d.xyy - d.yyz,
              czz = d.zz - d.zzz - d.xzz - d.yzz;
  const Lanes cxy = d.xy - d.xyz;
  const Lanes ddx = cxx - d.xxx - cxy - d.xz, ddy = cyy - d.yyy - d.yz, ddz = czz - d.zzz;
  const Lanes ddx_y = d.xxy + cxy, ddx_z = d.xxz + d.xz - d.xyz, ddy_z = d.yyz + d.yz;
  out.x2 = d.xxx, out.xm = cxx, out.y2 = d.yyy, out.ym = cyy, out.z2 = d.zzz, out.zm = czz;
  out.x1 = ddx - d.xxx - (d.xyy + d.xyy) - (d.xzz + d.xzz);
  out.o = -cxx - ddx - cyy - ddy - czz - ddz;
  out.xy = ddx_y + d.xyy;
  out.y1 = ddy - d.yyy - ddx_y - d.xxy - (d.yzz + d.yzz);
  out.xmy = d.xxy, out.xym = d.xyy;
  out.xz = ddx_z + d.xzz;
  out.z1 = ddz - d.zzz - ddx_z - d.xxz - ddy_z - d.yyz;
  out.xmz = d.xxz, out.xzm = d.xzz;
  out.yz = ddy_z + d.yzz - d.xyz;
  out.xyz = d.xyz, out.ymz = d.yyz, out.yzm = d.yzz;
}

/// out = the sums of weights times squared coefficients.
[[gnu::always_inline]] inline void add_difference_squares(const Stencil& u, const DifferenceWeights& w,
                                                          const Lanes& stiffness, Stencil& out) {
  const auto weight = [&](const Lanes& row, float value) __attribute__((always_inline)) {
    return keep(stiffness * value, row == row);
  };
  const Lanes xxx = weight(u.x2 + u.xm + u.o + u.x1, w.xxx), yyy = weight(u.y2 + u.ym + u.o + u.y1, w.yyy),
              zzz = weight(u.z2 + u.zm + u.o + u.z1, w.zzz);
  const Lanes x = u.o + u.x1, y = u.o + u.y1, z = u.o + u.z1;
  const Lanes xxy = weight(x + u.xm + u.y1 + u.xy + u.xmy, w.xxy),
              xyy = weight(x + y + u.xy + u.ym + u.xym, w.xyy);
  const Lanes xxz = weight(x + u.xm + u.z1 + u.xz + u.xmz, w.xxz),
              xzz = weight(x + z + u.xz + u.zm + u.xzm, w.xzz);
  const Lanes yyz = weight(y + u.ym + z + u.yz + u.ymz, w.yyz),
              yzz = weight(y + z + u.yz + u.zm + u.yzm, w.yzz);
  const Lanes xyz = weight(x + y + z + u.xy + u.xz + u.yz + u.xyz, w.xyz);
  const Lanes xx = weight(x + u.xm, w.xx), yy = weight(y + u.ym, w.yy), zz = weight(z + u.zm, w.zz);
  const Lanes xy = weight(x + y + u.xy, w.xy), xz = weight(x + z + u.xz, w.xz),
              yz = weight(y + z + u.yz, w.yz);
  const Lanes xs = xxy + xxz + xx, ys = xyy + yyz + yy, zs = xzz + yzz + zz;
  out.o = 9.0F * (xxx + yyy + zzz) + 4.0F * (xs + ys + zs) + xy + xz + yz + xyz;
  out.xm = xxx + xs, out.x1 = 9.0F * xxx + xs + 4.0F * (xyy + xzz) + xy + xz + xyz, out.x2 = xxx;
  out.ym = yyy + ys, out.y1 = 9.0F * yyy + ys + 4.0F * (xxy + yzz) + xy + yz + xyz, out.y2 = yyy;
  out.zm = zzz + zs, out.z1 = 9.0F * zzz + zs + 4.0F * (xxz + yyz) + xz + yz + xyz, out.z2 = zzz;
  out.xy = xxy + xyy + xy + xyz, out.xmy = xxy, out.xym = xyy;
  out.xz = xxz + xzz + xz + xyz, out.xmz = xxz, out.xzm = xzz;
  out.yz = yyz + yzz + yz + xyz, out.xyz = xyz, out.ymz = yyz, out.yzm = yzz;
}

enum class Form : std::uint8_t { kProduct, kResidual, kDiagonal };  // the diagonal of the differences alone

/// Adds the rows of the faces along one axis. The band is wide enough for all of a face's points to be in it.
template <Form form, int axis>
[[gnu::always_inline]] inline void add_face_rows(const Stencil& u, const FaceWeights& faces, int entry,
                                                 Stencil& out) {
  const auto from = face_points<axis, const Lanes>(u);
  const auto to = face_points<axis, Lanes>(out);
  const Lanes place = load(faces.at(entry, FaceWeights::kPlace));
  Lanes own = load(faces.at(entry, FaceWeights::kOwn));
  Lanes first = load(faces.at(entry, FaceWeights::kFirst)),
        second = load(faces.at(entry, FaceWeights::kSecond));
  const LaneMask is_face = place > Lanes{};
  Lanes middle =
      place * keep(kFaceInner * (from.lower + from.upper) + kFaceOuter * (from.before + from.after), is_face);
  if constexpr (form == Form::kResidual)
    if (!faces.middles.empty())
      middle -= place * load(&faces.middles[static_cast<std::size_t>(entry) * kLanes]);
  Lanes slope = own * (from.upper - from.lower) +
                (first * ((from.first_p - from.first_m) + (from.first_p_upper - from.first_m_upper)) +
                 second * ((from.second_p - from.second_m) + (from.second_p_upper - from.second_m_upper)));
  slope = keep(slope, is_face);
  if constexpr (form == Form::kResidual) slope -= load(faces.at(entry, FaceWeights::kTarget));
  const Lanes a = kFaceInner * middle, b = kFaceOuter * middle;  // to the two inner and the two outer points
  own *= slope, first *= slope, second *= slope;
  to.lower += a - own, to.upper += a + own;
  to.before += b, to.after += b;
  to.first_m -= first, to.first_p += first, to.first_m_upper -= first, to.first_p_upper += first;
  to.second_m -= second, to.second_p += second, to.second_m_upper -= second, to.second_p_upper += second;
}

/// Contributions that go to whole segments after a shift along x, until all of a block are known: reading y,
/// adding and writing it back at odd places would wait for the write before.
class ShiftedSums {
 public:
  enum Part : std::uint8_t { kX1, kX2, kXm, kXY, kXmY, kXYm, kXZ, kXmZ, kXZm, kXYZ, kShiftedCount };
  enum Straight : std::uint8_t { kO = kShiftedCount, kPlusY, kMinusY, kPlusZ, kMinusZ, kPlusYZ, kCount };

  /// The sums of a block by part and segment. Copied, so that the compiler knows that no store changes it.
  struct View {
    float* first;
    std::ptrdiff_t stride;
    float* nowhere;

    [[gnu::always_inline]] inline float* at(std::size_t part, std::ptrdiff_t segment) const {
      return first + static_cast<std::ptrdiff_t>(part) * stride + segment * kLanes;
    }
    /// Where a row's contributions go: y, or nowhere if there is no such row (they are 0), for other threads
    /// write to theirs.
    [[gnu::always_inline]] inline float* row_of(float* y, std::int32_t segment) const {
      return segment == 0 ? nowhere : y + static_cast<std::ptrdiff_t>(segment) * kLanes;
    }
  };

  /// For up to `segments` segments of a block.
  [[gnu::always_inline]] inline View reserve(std::size_t segments) {
    const std::size_t stride = (segments + 2) * kLanes;
    if (values_.size() < stride * kCount) values_.resize(stride * kCount);
    for (std::size_t part = 0; part < kShiftedCount; ++part) {
      store(&values_[part * stride], Lanes{});
      store(&values_[(part + 1) * stride - kLanes], Lanes{});
    }
    return {values_.data() + kLanes, static_cast<std::ptrdiff_t>(stride), nowhere_.data()};
  }

 private:
  std::vector<float> values_;
  std::array<float, kLanes> nowhere_ = {};
};

[[gnu::always_inline]] inline void scatter(const Stencil& out,
                                           const std::array<std::int32_t, kRowCount>& rows, std::ptrdiff_t n,
                                           const ShiftedSums::View sums, float* y) {
  using S = ShiftedSums;
  store(sums.at(S::kX1, n), out.x1), store(sums.at(S::kX2, n), out.x2), store(sums.at(S::kXm, n), out.xm);
  store(sums.at(S::kXY, n), out.xy), store(sums.at(S::kXmY, n), out.xmy), store(sums.at(S::kXYm, n), out.xym);
  store(sums.at(S::kXZ, n), out.xz), store(sums.at(S::kXmZ, n), out.xmz), store(sums.at(S::kXZm, n), out.xzm);
  store(sums.at(S::kXYZ, n), out.xyz);
  store(sums.at(S::kO, n), out.o);
  store(sums.at(S::kPlusY, n), out.y1), store(sums.at(S::kMinusY, n), out.ym);
  store(sums.at(S::kPlusZ, n), out.z1), store(sums.at(S::kMinusZ, n), out.zm);
  store(sums.at(S::kPlusYZ, n), out.yz);
  const auto row = [&](std::size_t r) { return sums.row_of(y, rows[r]); };
  add_to(row(kY2), out.y2), add_to(row(kZ2), out.z2), add_to(row(kYmZ), out.ymz), add_to(row(kYZm), out.yzm);
}

[[gnu::always_inline]] inline void add_shifted(const std::array<std::int32_t, kRowCount>& rows, int segment,
                                               std::ptrdiff_t n, const ShiftedSums::View sums, float* y) {
  using S = ShiftedSums;
  const auto at = [&](std::size_t part, std::ptrdiff_t shift) __attribute__((always_inline)) {
    return load(sums.at(part, n) + shift);
  };
  const auto row = [&](std::size_t r) { return sums.row_of(y, rows[r]); };
  add_to(y + static_cast<std::ptrdiff_t>(segment) * kLanes,
         (at(S::kO, 0) + at(S::kX1, -1)) + (at(S::kX2, -2) + at(S::kXm, 1)));
  add_to(row(kY1), at(S::kPlusY, 0) + (at(S::kXY, -1) + at(S::kXmY, 1)));
  add_to(row(kYm), at(S::kMinusY, 0) + at(S::kXYm, -1));
  add_to(row(kZ1), at(S::kPlusZ, 0) + (at(S::kXZ, -1) + at(S::kXmZ, 1)));
  add_to(row(kZm), at(S::kMinusZ, 0) + at(S::kXZm, -1));
  add_to(row(kYZ), at(S::kPlusYZ, 0) + at(S::kXYZ, -1));
}

template <Form form>
[[gnu::always_inline]] inline void apply_block(const Energy& e, const Band::Block& block, const float* x,
                                               ShiftedSums& block_sums, float* y) {
  const Band& band = *e.band;
  const auto* const rows = &band.rows(0);
  const float* const stiffness = e.stiffness.data();
  const int begin = block.begin, end = block.end;
  const ShiftedSums::View sums = block_sums.reserve(static_cast<std::size_t>(end - begin));
  for (int s = begin; s < end; ++s) {
    const Stencil u = gather(rows[s], s, x);
    Stencil out;
    const Lanes stiff = load(stiffness + static_cast<std::ptrdiff_t>(s) * kLanes);
    if constexpr (form == Form::kDiagonal) {
      add_difference_squares(u, e.differences, stiff, out);
    } else {
      Differences d = differences_of(u);
      if constexpr (form == Form::kResidual) subtract_targets(e.targets, s, d);
      transpose(weighted(d, e.differences, stiff), out);
    }
    int entry = band.first_entry(s);
    if (form != Form::kDiagonal && entry != band.first_entry(s + 1)) {
      if (band.faces(s, 0) != 0) add_face_rows<form, 0>(u, e.faces, entry++, out);
      if (band.faces(s, 1) != 0) add_face_rows<form, 1>(u, e.faces, entry++, out);
      if (band.faces(s, 2) != 0) add_face_rows<form, 2>(u, e.faces, entry++, out);
    }
    scatter(out, rows[s], s - begin, sums, y);
  }
  for (int s = begin; s < end; ++s) add_shifted(rows[s], s, s - begin, sums, y);
}

LUMESH_WIDE_LOOPS void multiply(const Energy& e, const Band::Block& block, const float* x, ShiftedSums& sums,
                                float* y) {
  apply_block<Form::kProduct>(e, block, x, sums, y);
}
LUMESH_WIDE_LOOPS void residual(const Energy& e, const Band::Block& block, const float* x, ShiftedSums& sums,
                                float* y) {
  apply_block<Form::kResidual>(e, block, x, sums, y);
}
LUMESH_WIDE_LOOPS void diagonal(const Energy& e, const Band::Block& block, const float* x, ShiftedSums& sums,
                                float* y) {
  apply_block<Form::kDiagonal>(e, block, x, sums, y);
}

/// Even chunks first, then odd ones: chunks of one kind write to different rows, so that sums have a fixed
/// order.
template <class Body>
void for_each_chunk(const Band& band, const Body& body) {
  const std::size_t count = band.chunks().size() - 1;
  for (std::size_t kind = 0; kind < 2; ++kind) {
    parallel::for_each_block((count + 1 - kind) / 2, 1, [&](std::size_t n, std::size_t, std::size_t) {
      const std::size_t chunk = 2 * n + kind;
      ShiftedSums sums;
      for (int b = band.chunks()[chunk]; b < band.chunks()[chunk + 1]; ++b)
        body(band.blocks()[static_cast<std::size_t>(b)], sums);
    });
  }
}

}  // namespace

DifferenceWeights difference_weights(const Vec3& edges, double third, double second) {
  const double volume = edges.prod();
  const Vec3 i =
      edges.cwiseProduct(edges).cwiseInverse();  // a squared difference is divided by the squared steps
  const auto w = [&](double weight) { return static_cast<float>(weight * volume); };
  DifferenceWeights d;
  d.xxx = w(third * i.x() * i.x() * i.x()), d.yyy = w(third * i.y() * i.y() * i.y());
  d.zzz = w(third * i.z() * i.z() * i.z());
  d.xxy = w(3 * third * i.x() * i.x() * i.y()), d.xyy = w(3 * third * i.x() * i.y() * i.y());
  d.xxz = w(3 * third * i.x() * i.x() * i.z()), d.xzz = w(3 * third * i.x() * i.z() * i.z());
  d.yyz = w(3 * third * i.y() * i.y() * i.z()), d.yzz = w(3 * third * i.y() * i.z() * i.z());
  d.xyz = w(6 * third * i.x() * i.y() * i.z());
  d.xx = w(second * i.x() * i.x()), d.yy = w(second * i.y() * i.y()), d.zz = w(second * i.z() * i.z());
  d.xy = w(2 * second * i.x() * i.y()), d.xz = w(2 * second * i.x() * i.z()),
  d.yz = w(2 * second * i.y() * i.z());
  return d;
}

float whole_diagonal(const DifferenceWeights& w) {
  // Sums of squared coefficients: 20 of (-1, 3, -3, 1), 6 of (1, -2, 1), 2 of (-1, 1).
  return 20 * (w.xxx + w.yyy + w.zzz) + 12 * (w.xxy + w.xyy + w.xxz + w.xzz + w.yyz + w.yzz) + 8 * w.xyz +
         6 * (w.xx + w.yy + w.zz) + 4 * (w.xy + w.xz + w.yz);
}

void apply(const Energy& energy, const LaneArray& x, LaneArray& y) {
  for_each_chunk(*energy.band, [&](const Band::Block& block, ShiftedSums& sums) {
    multiply(energy, block, x.data(), sums, y.data());
  });
}

void apply_residual(const Energy& energy, const LaneArray& x, LaneArray& y) {
  for_each_chunk(*energy.band, [&](const Band::Block& block, ShiftedSums& sums) {
    residual(energy, block, x.data(), sums, y.data());
  });
}

void add_difference_diagonal(const Energy& energy, const LaneArray& x, LaneArray& y) {
  for_each_chunk(*energy.band, [&](const Band::Block& block, ShiftedSums& sums) {
    diagonal(energy, block, x.data(), sums, y.data());
  });
}

}  // namespace lumesh::field
