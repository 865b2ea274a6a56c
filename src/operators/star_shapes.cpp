#include "star_shapes.hpp"

#include <cmath>

#include "lumesh/core/wide.hpp"
#include "lumesh/metric/measures.hpp"

namespace lumesh::operators {
namespace {

constexpr std::size_t kLanes = 4;  // Doubles in an AVX register.
constexpr std::size_t kColumns = 18, kResults = 10;

struct Triple {
  double x, y, z;
};

/// One row of the columns, with the vertex somewhere; plain numbers, which compilers vectorise.
struct Row {
  Triple w, u, v,
      normal;  // Edges from a to the vertex, to b, to c; the normal of a, b, c times twice its area.
  metric::TraceFreeExp metric;

  [[gnu::always_inline]] Row(const double* c, std::size_t i, const Triple& at, const SymTensor& log)
      : w{at.x - c[0 * kLanes + i], at.y - c[1 * kLanes + i], at.z - c[2 * kLanes + i]},
        u{c[3 * kLanes + i], c[4 * kLanes + i], c[5 * kLanes + i]},
        v{c[6 * kLanes + i], c[7 * kLanes + i], c[8 * kLanes + i]},
        normal{c[9 * kLanes + i], c[10 * kLanes + i], c[11 * kLanes + i]},
        metric(SymTensor{0.25 * (c[12 * kLanes + i] + log.xx), 0.25 * (c[13 * kLanes + i] + log.xy),
                         0.25 * (c[14 * kLanes + i] + log.xz), 0.25 * (c[15 * kLanes + i] + log.yy),
                         0.25 * (c[16 * kLanes + i] + log.yz), 0.25 * (c[17 * kLanes + i] + log.zz)}) {}

  [[nodiscard, gnu::always_inline]] double six_volumes() const {
    return normal.x * w.x + normal.y * w.y + normal.z * w.z;
  }
  /// Sum of the squares of the metric lengths of the edges.
  [[nodiscard, gnu::always_inline]] double squared_edges() const {
    const double sx = u.x + v.x + w.x, sy = u.y + v.y + w.y, sz = u.z + v.z + w.z;
    return metric.contraction_with(
        {4 * (u.x * u.x + v.x * v.x + w.x * w.x) - sx * sx, 4 * (u.x * u.y + v.x * v.y + w.x * w.y) - sx * sy,
         4 * (u.x * u.z + v.x * v.z + w.x * w.z) - sx * sz, 4 * (u.y * u.y + v.y * v.y + w.y * w.y) - sy * sy,
         4 * (u.y * u.z + v.y * v.z + w.y * w.z) - sy * sz,
         4 * (u.z * u.z + v.z * v.z + w.z * w.z) - sz * sz});
  }
};

/// One block of rows. The sign of a cube is that of the volume.
LUMESH_WIDE_LOOPS void measure(const double* __restrict columns, std::size_t blocks, Triple at, SymTensor log,
                               double* __restrict cubed) {
  for (std::size_t block = 0; block < blocks; ++block, columns += kColumns * kLanes, cubed += kLanes) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const Row row(columns, i, at, log);
      const double volumes = row.six_volumes(), edges = row.squared_edges();
      cubed[i] = 432 * volumes * std::abs(volumes) / (edges * edges * edges);
    }
  }
}

/// Per block rows of: cube of the quality; gradient and Hessian of 1 / quality, both divided by it.
LUMESH_WIDE_LOOPS void differentiate(const double* __restrict columns, std::size_t blocks, Triple at,
                                     SymTensor log, double* __restrict out) {
  constexpr double two_thirds = 2.0 / 3, ten_ninths = 10.0 / 9;
  for (std::size_t block = 0; block < blocks;
       ++block, columns += kColumns * kLanes, out += kResults * kLanes) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const Row row(columns, i, at, log);
      const double volumes = row.six_volumes(), edges = row.squared_edges();
      out[i] = 432 * volumes * volumes / (edges * edges * edges);
      // 1 / quality = T V^(-2/3) / constant, with T the sum of the squared lengths.
      const SymTensor m = row.metric.tensor();
      const double sx = 3 * row.w.x - row.u.x - row.v.x, sy = 3 * row.w.y - row.u.y - row.v.y,
                   sz = 3 * row.w.z - row.u.z - row.v.z;
      const double p = 2 / edges, q = 1 / volumes, h = 6 / edges;
      const double t0 = p * (m.xx * sx + m.xy * sy + m.xz * sz), t1 = p * (m.xy * sx + m.yy * sy + m.yz * sz),
                   t2 = p * (m.xz * sx + m.yz * sy + m.zz * sz);
      const double v0 = q * row.normal.x, v1 = q * row.normal.y, v2 = q * row.normal.z;
      out[1 * kLanes + i] = t0 - two_thirds * v0;
      out[2 * kLanes + i] = t1 - two_thirds * v1;
      out[3 * kLanes + i] = t2 - two_thirds * v2;
      out[4 * kLanes + i] = h * m.xx - two_thirds * 2 * t0 * v0 + ten_ninths * v0 * v0;
      out[5 * kLanes + i] = h * m.xy - two_thirds * (t0 * v1 + t1 * v0) + ten_ninths * v0 * v1;
      out[6 * kLanes + i] = h * m.xz - two_thirds * (t0 * v2 + t2 * v0) + ten_ninths * v0 * v2;
      out[7 * kLanes + i] = h * m.yy - two_thirds * 2 * t1 * v1 + ten_ninths * v1 * v1;
      out[8 * kLanes + i] = h * m.yz - two_thirds * (t1 * v2 + t2 * v1) + ten_ninths * v1 * v2;
      out[9 * kLanes + i] = h * m.zz - two_thirds * 2 * t2 * v2 + ten_ninths * v2 * v2;
    }
  }
}

}  // namespace

void StarShapes::add(const TetMesh& mesh, VertexId va, VertexId vb, VertexId vc) {
  const std::size_t i = count_++;
  if (blocks() * kColumns * kLanes > columns_.size()) {
    columns_.resize(2 * blocks() * kColumns * kLanes);
    results_.resize(2 * blocks() * kResults * kLanes);
  }
  const Vec3& a = mesh.point(va);
  const Vec3 u = mesh.point(vb) - a, v = mesh.point(vc) - a, n = u.cross(v);
  const SymTensor logs = mesh.log_metric(va) + mesh.log_metric(vb) + mesh.log_metric(vc);
  const double row[kColumns] = {a[0], a[1], a[2], u[0],    u[1],    u[2],    v[0],    v[1],    v[2],
                                n[0], n[1], n[2], logs.xx, logs.xy, logs.xz, logs.yy, logs.yz, logs.zz};
  double* const out = columns_.data() + i / kLanes * kColumns * kLanes + i % kLanes;
  for (std::size_t k = 0; k < kColumns; ++k) out[k * kLanes] = row[k];
}

void StarShapes::gather(const TetMesh& mesh, VertexId vertex, std::span<const TetId> tets) {
  clear();
  for (const TetId t : tets) {
    const auto [x, y, z] = kTetFaces[mesh.index_of(t, vertex)];
    add(mesh, mesh.vertex(t, x), mesh.vertex(t, z), mesh.vertex(t, y));
  }
}

std::size_t StarShapes::blocks() const {
  return (count_ + kLanes - 1) / kLanes;
}

void StarShapes::complete_last_block() {
  if (count_ == 0) return;
  double* const last = columns_.data() + (blocks() - 1) * kColumns * kLanes;
  for (std::size_t lane = (count_ - 1) % kLanes + 1; lane < kLanes; ++lane)
    for (std::size_t k = 0; k < kColumns; ++k) last[k * kLanes + lane] = last[k * kLanes];
}

std::span<const double> StarShapes::ratios_cubed_at(const Vec3& x, const SymTensor& log_metric) {
  complete_last_block();
  measure(columns_.data(), blocks(), {x[0], x[1], x[2]}, log_metric, results_.data());
  return {results_.data(), count_};
}

ShapeSums StarShapes::sums_at(const Vec3& x, const SymTensor& log_metric) {
  complete_last_block();
  differentiate(columns_.data(), blocks(), {x[0], x[1], x[2]}, log_metric, results_.data());
  ShapeSums sums;
  for (std::size_t i = 0; i < count_; ++i) {
    const double* const r = results_.data() + i / kLanes * kResults * kLanes + i % kLanes;
    const double value = 1 / metric::cube_root(r[0]);
    const auto at = [&](std::size_t k) { return value * r[k * kLanes]; };
    sums.value += value;
    sums.gradient += Vec3(at(1), at(2), at(3));
    sums.hessian = sums.hessian + SymTensor{at(4), at(5), at(6), at(7), at(8), at(9)};
  }
  return sums;
}

}  // namespace lumesh::operators
