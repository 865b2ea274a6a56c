// Images of more than one volume: frames in time, or several values for each voxel.
#include <fmt/format.h>

#include <cstring>

#include "file_fault.hpp"
#include "lumesh/parallel/loops.hpp"
#include "raw_image.hpp"

namespace lumesh::io {

namespace fs = std::filesystem;

std::size_t product_of_sizes(const fs::path& path, std::span<const std::int64_t> sizes) {
  constexpr std::int64_t kMax = 1'000'000;
  std::int64_t product = 1;
  for (const std::int64_t size : sizes) {
    if (size < 1 || size > kMax || product * size > kMax)
      fail(path, fmt::format("has a damaged header ({} volumes); save it again", size));
    product *= size;
  }
  return static_cast<std::size_t>(product);
}

std::string several_volumes_text(std::size_t volumes) {
  return fmt::format("has {} volumes; `frame` takes one of them, 0 to {}, `all_frames` one after the other",
                     volumes, volumes - 1);
}

VolumeRange chosen_volumes(const fs::path& path, const ImageHeader& header, const FileChoice& choice) {
  if (choice.frame && *choice.frame >= header.volumes)
    fail(path, header.volumes == 1 ? fmt::format("has one volume, frame 0, and no frame {}", *choice.frame)
                                   : fmt::format("has no frame {}; it {}", *choice.frame,
                                                 several_volumes_text(header.volumes)));
  if (choice.frame) return {*choice.frame, 1};
  if (header.volumes > 1 && header.type != VoxelType::kFloat && header.type != VoxelType::kDouble)
    fail(path, several_volumes_text(header.volumes));
  return {0, header.volumes};
}

void sort_into_volumes(const VolumeRange& kept, RawImage& image) {
  const std::size_t width = voxel_bytes(image.type), voxels = image.frame.voxel_count(), all = image.volumes;
  auto sorted = std::make_unique_for_overwrite<std::byte[]>(voxels * kept.count * width);
  parallel::for_each_index(voxels, [&](std::size_t v) {
    for (std::size_t n = 0; n < kept.count; ++n)
      std::memcpy(sorted.get() + (n * voxels + v) * width,
                  image.voxels.get() + (v * all + kept.first + n) * width, width);
  });
  image.voxels = std::move(sorted);
  image.volumes = kept.count;
}

void keep_volumes(const VolumeRange& kept, RawImage& image) {
  if (kept.count == image.volumes) return;
  const std::size_t bytes = image.frame.voxel_count() * voxel_bytes(image.type);
  auto rest = std::make_unique_for_overwrite<std::byte[]>(kept.count * bytes);
  std::memcpy(rest.get(), image.voxels.get() + kept.first * bytes, kept.count * bytes);
  image.voxels = std::move(rest);
  image.volumes = kept.count;
}

}  // namespace lumesh::io
