#pragma once
/// @file The vessels of an image in segments about as long as they are thick (chunks), and their adjacency.

#include <array>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "lumesh/core/grid.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/image/topology.hpp"

namespace lumesh::image {

inline constexpr std::uint32_t kNoChunk = 0xffffffffU;

/// A face between voxels of two chunks.
struct ChunkFace {
  std::uint32_t first = 0, second = 0;  ///< Chunks, ascending.
  std::uint32_t voxel = 0, other = 0;   ///< Of these chunks.
  float half_width = 0;                 ///< The lesser distance of both.
};

class VesselChunks {
 public:
  explicit VesselChunks(const LabelImage& image);

  struct Chunk {
    Index3 seed = Index3::Zero();
    float half_width = 0;               ///< Distance of its middle from the background.
    Vec3 border_sum = Vec3::Zero();     ///< Of its voxels at the image's border …
    std::size_t border_count = 0;       ///< … and how many.
    std::vector<std::uint32_t> beside;  ///< Chunks that it shares faces with, ascending.
  };
  [[nodiscard]] const std::vector<Chunk>& chunks() const { return chunks_; }
  [[nodiscard]] const std::vector<ChunkFace>& faces() const { return faces_; }  ///< By chunks.
  /// Greatest half width of the way between two chunks; 0 if they share no face.
  [[nodiscard]] float saddle(std::uint32_t a, std::uint32_t b) const;
  /// Whether the way between two chunks is much thinner than both, and there is no wider one around.
  [[nodiscard]] bool is_neck(std::uint32_t a, std::uint32_t b) const;
  /// Whether two chunks are connected here only through a bottleneck.
  [[nodiscard]] bool are_apart(std::uint32_t a, std::uint32_t b) const;
  /// The same, and one or two voxels thick where they share faces.
  [[nodiscard]] bool hang_by_thread(std::uint32_t a, std::uint32_t b) const;
  /// Whether the object between the middles of two chunks is narrower than at both, as a convex one never is.
  [[nodiscard]] bool narrows_between(std::uint32_t a, std::uint32_t b) const;
  /// The chunks around a place between two, by the chunk to which the way is wider: of vessels side by side.
  using Sides = std::array<std::vector<std::uint32_t>, 2>;
  /// @return Empty unless the parts on both sides go on in two directions.
  [[nodiscard]] std::optional<Sides> passing_sides(std::uint32_t a, std::uint32_t b, const Vec3& place) const;

  [[nodiscard]] const Index3& size() const { return size_; }
  [[nodiscard]] std::size_t voxel_count() const { return chunk_of_.size(); }
  [[nodiscard]] std::uint32_t chunk_of(std::size_t voxel) const { return chunk_of_[voxel]; }
  /// Whether a voxel is background of a wide cavity, which counts as part of the vessel around it.
  [[nodiscard]] bool is_filled(std::size_t voxel) const { return is_filled_[voxel]; }
  /// Whether a voxel shares a face with any chunk.
  [[nodiscard]] bool is_beside(std::size_t voxel) const;
  [[nodiscard]] Index3 place_of(std::size_t voxel) const {  ///< In the box.
    return grid_place(size_, voxel);
  }
  [[nodiscard]] std::size_t offset(const Index3& place) const { return grid_offset(size_, place); }
  [[nodiscard]] bool contains(const Index3& place) const {
    return (place.array() >= 0).all() && (place.array() < size_.array()).all();
  }
  [[nodiscard]] const Index3& low() const { return low_; }  ///< Of the box in the image.

 private:
  void find_distances(const LabelImage& image);
  /// @return Whether there is any.
  bool fill_wide_cavities(LabelImage& all);
  void choose_seeds();
  void flood();
  [[nodiscard]] bool is_in_line(std::uint32_t chunk) const;
  void absorb_bumps();
  void find_faces();
  void find_borders(const Index3& image_size);
  void part();
  /// @return Whether there is any: then its chunks are new, and all is to be parted anew.
  bool continue_interrupted_vessels();
  [[nodiscard]] double chord(const Vec3& middle, const Vec3& way, double most) const;
  [[nodiscard]] float widest_way_around(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] bool goes_on_from_wall(const std::vector<std::uint32_t>& side, const Vec3& place) const;
  [[nodiscard]] bool goes_on_from_axis(const std::vector<std::uint32_t>& side, const Vec3& place) const;

  Index3 low_ = Index3::Zero(), size_ = Index3::Zero();
  std::vector<float> distance_;  ///< In smallest voxel edges; 0 in the background.
  std::vector<bool> is_filled_;  ///< Per voxel: is_filled().
  std::vector<std::uint32_t> chunk_of_;
  Vec3 edges_ = Vec3::Ones();  ///< Of a voxel, in the smallest one.
  std::vector<Chunk> chunks_;
  std::vector<ChunkFace> faces_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, float> saddles_;
};

}  // namespace lumesh::image
