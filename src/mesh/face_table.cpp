#include "face_table.hpp"

#include "lumesh/geometry/tetrahedron.hpp"

namespace lumesh {
namespace {

Cell<3> face_corners(const Cell<4>& tet, int face) {
  const auto& [i, j, k] = kTetFaces[face];
  return sorted_corners({tet[i], tet[j], tet[k]});
}

}  // namespace

FaceTable::FaceTable(std::span<const Cell<4>> tets, std::size_t vertex_count) : faces_(tets.size() * 4) {
  const std::size_t buckets = std::clamp<std::size_t>(tets.size() / 2048, 1, 4096);
  const std::size_t block = std::max<std::size_t>(16384, tets.size() / 256);
  const std::size_t blocks = (tets.size() + block - 1) / block;
  const auto bucket_of = [&](const Cell<3>& corners) { return corners[0] * buckets / vertex_count; };
  // Counts, then places of the first face of each (bucket, block), so that writing needs no coordination.
  std::vector<std::size_t> place(buckets * blocks + 1, 0);
  parallel::for_each_block(tets.size(), block, [&](std::size_t b, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      for (int f = 0; f < 4; ++f) ++place[bucket_of(face_corners(tets[t], f)) * blocks + b];
  });
  std::size_t total = 0;
  for (std::size_t& entry : place) total += std::exchange(entry, total);
  bucket_begin_.resize(buckets + 1, tets.size() * 4);
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) bucket_begin_[bucket] = place[bucket * blocks];
  parallel::for_each_block(tets.size(), block, [&](std::size_t b, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      for (int f = 0; f < 4; ++f) {
        const Cell<3> corners = face_corners(tets[t], f);
        faces_[place[bucket_of(corners) * blocks + b]++] = {corners, static_cast<std::uint32_t>(t << 2 | f)};
      }
  });
  parallel::for_each_block(buckets, 1, [&](std::size_t bucket, std::size_t, std::size_t) {
    std::sort(faces_.data() + bucket_begin_[bucket], faces_.data() + bucket_begin_[bucket + 1]);
  });
}

}  // namespace lumesh
