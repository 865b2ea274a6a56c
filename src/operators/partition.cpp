#include "lumesh/operators/partition.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <utility>

#include "cavity.hpp"
#include "lumesh/core/local_map.hpp"
#include "lumesh/metric/tensor.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::operators {
namespace {

constexpr std::size_t kTetBlock = 4096;

/// Recursive bisection of an array of vertices; every part ends up contiguous.
class Bisection {
 public:
  Bisection(const TetMesh& mesh, std::vector<std::uint32_t>& vertices, std::uint32_t bucket_size)
      : mesh_(mesh),
        vertices_(vertices),
        max_vertices_(bucket_size + bucket_size / 2),
        begins_part_(vertices.size(), 0) {
    if (!vertices.empty()) cut({vertices.data(), vertices.size()});
  }
  /// 1 where a part begins.
  [[nodiscard]] const std::vector<std::uint8_t>& begins_part() const { return begins_part_; }

 private:
  using Part = std::span<std::uint32_t>;
  static constexpr std::size_t kSamples = 1000, kWorthATask = 8192;

  void cut(Part part) {
    if (part.size() <= max_vertices_) {
      begins_part_[static_cast<std::size_t>(part.data() - vertices_.data())] = 1;
      return;
    }
    const std::size_t half = halve(part);
    const Part left = part.first(half), right = part.subspan(half);
    if (part.size() < kWorthATask) {
      cut(left);
      cut(right);
    } else {
      parallel::invoke_both([&] { cut(left); }, [&] { cut(right); });
    }
  }

  /// Puts the vertices on one side of a plane first. The plane goes through the median of some, across the
  /// direction in which they spread most in their mean metric.
  std::size_t halve(Part part) const {
    const std::size_t stride = (part.size() + kSamples - 1) / kSamples;
    SymTensor log_sum;
    Vec3 centre = Vec3::Zero();
    double count = 0;
    for (std::size_t i = 0; i < part.size(); i += stride, ++count) {
      log_sum = log_sum + mesh_.log_metric(VertexId(part[i]));
      centre += mesh_.point(VertexId(part[i]));
    }
    const MetricFrame frame(metric::exp((1 / count) * log_sum), centre / count);
    Mat3 covariance = Mat3::Zero();
    for (std::size_t i = 0; i < part.size(); i += stride) {
      const Vec3 p = frame(mesh_.point(VertexId(part[i])));
      covariance += p * p.transpose();
    }
    const Vec3 axis = Eigen::SelfAdjointEigenSolver<Mat3>(covariance).eigenvectors().col(2);
    const Vec3 across = frame.covector(axis);
    const auto height = [&](std::uint32_t v) { return across.dot(mesh_.point(VertexId(v))); };
    std::vector<double> heights;
    for (std::size_t i = 0; i < part.size(); i += stride) heights.push_back(height(part[i]));
    const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    std::nth_element(heights.begin(), middle, heights.end());
    const auto second =
        std::partition(part.begin(), part.end(), [&](std::uint32_t v) { return height(v) < *middle; });
    const auto first_size = static_cast<std::size_t>(second - part.begin());
    // Points that lie together leave one side nearly empty: any cut will do.
    const bool lopsided = first_size < part.size() / 8 || first_size > part.size() - part.size() / 8;
    return lopsided ? part.size() / 2 : first_size;
  }

  const TetMesh& mesh_;
  const std::vector<std::uint32_t>& vertices_;
  std::size_t max_vertices_;
  std::vector<std::uint8_t> begins_part_;
};

/// Says of most numbers whether they have come up before: most come up again soon.
class RecentPairs {
 public:
  [[nodiscard]] bool holds(std::uint64_t pair) {
    std::uint64_t& entry = entries_[pair * 0x9E3779B97F4A7C15ull >> (64 - kBits)];
    return std::exchange(entry, pair) == pair;
  }

 private:
  static constexpr int kBits = 10;
  std::array<std::uint64_t, std::size_t{1} << kBits> entries_ = {};  // 0 is not a pair.
};

parallel::TaskGraph neighbours_of(TetMesh& mesh, const std::vector<std::uint32_t>& tets,
                                  std::uint32_t buckets) {
  const auto pairs = parallel::collect_blocks<std::uint64_t>(
      tets.size(), kTetBlock, [&](std::size_t begin, std::size_t end, std::vector<std::uint64_t>& out) {
        RecentPairs known;
        for (std::size_t i = begin; i < end; ++i) {
          std::array<std::uint64_t, 4> bucket{};
          for (int k = 0; k < 4; ++k) bucket[k] = mesh.lock_word(mesh.vertex(TetId(tets[i]), k));
          if (bucket[0] == bucket[1] && bucket[1] == bucket[2] && bucket[2] == bucket[3]) continue;
          for (const auto& [k, l] : kTetEdges) {
            const std::uint64_t a = bucket[k], b = bucket[l];
            if (a == b || known.holds(std::min(a, b) << 32 | std::max(a, b))) continue;
            parallel::add_both_ways(a, b, out);
          }
        }
      });
  return parallel::adjacency_of(pairs, buckets);
}

parallel::TaskGraph conflicts_of(const parallel::TaskGraph& neighbours) {
  constexpr std::size_t kBucketBlock = 64;
  const auto pairs = parallel::collect_blocks<std::uint64_t>(
      neighbours.size(), kBucketBlock,
      [&](std::size_t begin, std::size_t end, std::vector<std::uint64_t>& out) {
        LocalMap<std::uint32_t, char> known;
        for (std::size_t b = begin; b < end; ++b) {
          known.clear();
          known.insert(static_cast<std::uint32_t>(b), 0);
          const auto add = [&](std::uint32_t other) {
            if (known.insert(other, 0).added) out.push_back(std::uint64_t{b} << 32 | other);
          };
          for (const std::uint32_t next : neighbours.of(b)) {
            add(next);
            for (const std::uint32_t second : neighbours.of(next)) add(second);
          }
        }
      });
  return parallel::adjacency_of(pairs, neighbours.size());
}

}  // namespace

std::size_t bucket_size_for(std::size_t items) {
  constexpr std::size_t kMin = 32, kMax = 256, kBuckets = 4000;
  return std::clamp(items / kBuckets, kMin, kMax);
}

Partition partition_vertices(TetMesh& mesh, const std::vector<std::uint32_t>& vertices,
                             const std::vector<std::uint32_t>& tets, std::uint32_t bucket_size) {
  std::vector<std::uint32_t> sorted = vertices;
  const Bisection bisection(mesh, sorted, bucket_size);
  Partition partition;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    partition.buckets += bisection.begins_part()[i];
    mesh.lock_word(VertexId(sorted[i])) = partition.buckets - 1;
  }
  partition.neighbours = neighbours_of(mesh, tets, partition.buckets);
  partition.conflicts = conflicts_of(partition.neighbours);
  return partition;
}

}  // namespace lumesh::operators
