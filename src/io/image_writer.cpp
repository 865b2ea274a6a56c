#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cstring>
#include <string>

#include "file_fault.hpp"
#include "format_table.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/parallel/cancellation.hpp"
#include "mesh_formats.hpp"
#include "output_file.hpp"
#include "parallel_gzip.hpp"
#include "raw_image.hpp"

namespace lumesh {

namespace {

namespace fs = std::filesystem;
using io::OutputFile;
using io::VoxelType;

VoxelType smallest_type(const LabelImage& image) {
  const Label largest = image.values().back();
  if (largest <= 0xff) return VoxelType::kUInt8;
  return largest <= 0xffff ? VoxelType::kUInt16 : VoxelType::kInt32;
}

/// Labels of the voxels [first, last) as they stand in the file.
void fill_voxels(const LabelImage& image, VoxelType type, std::size_t first, std::size_t last,
                 std::byte* out) {
  io::visit_voxel_type(type, [&](auto example) {
    for (std::size_t i = first; i < last; ++i, out += sizeof(example)) {
      example = static_cast<decltype(example)>(image.values()[image.voxels()[i]]);
      std::memcpy(out, &example, sizeof(example));
    }
  });
}

std::string vector_text(const Vec3& v) {
  return fmt::format("({},{},{})", v.x(), v.y(), v.z());
}

template <class Value>
void put(std::array<std::byte, 352>& header, std::size_t at, Value value) {
  std::memcpy(header.data() + at, &value, sizeof(value));
}

/// NIfTI-1: qform and sform both in RAS (nifti1.h).
std::array<std::byte, 352> nifti_header(const fs::path& path, const ImageFrame& frame, VoxelType type) {
  std::array<std::byte, 352> header = {};
  if ((frame.size.array() > 32767).any())
    io::fail(path, "NIfTI-1 holds at most 32767 voxels along an axis; write .nrrd");
  put<std::int32_t>(header, 0, 348);
  const std::array<int, 8> dimensions = {3, frame.size.x(), frame.size.y(), frame.size.z(), 1, 1, 1, 1};
  for (std::size_t i = 0; i < 8; ++i) put(header, 40 + 2 * i, static_cast<std::int16_t>(dimensions[i]));
  put(header, 70, static_cast<std::int16_t>(io::names_of(type).nifti));
  put(header, 72, static_cast<std::int16_t>(8 * io::voxel_bytes(type)));
  Mat3 axes = frame.direction;
  axes.topRows<2>() *= -1;
  const bool mirrored = axes.determinant() < 0;
  put(header, 76, mirrored ? -1.0F : 1.0F);
  for (int i = 0; i < 3; ++i)
    put(header, 80 + 4 * static_cast<std::size_t>(i), static_cast<float>(frame.spacing_mm[i]));
  put(header, 108, 352.0F);
  put(header, 112, 1.0F);
  constexpr std::byte kMillimetres{2};
  header[123] = kMillimetres;
  put<std::int16_t>(header, 252, 1);
  put<std::int16_t>(header, 254, 1);
  const Vec3 origin(-frame.origin_mm.x(), -frame.origin_mm.y(), frame.origin_mm.z());
  for (int row = 0; row < 3; ++row) {
    const std::size_t at = 280 + 16 * static_cast<std::size_t>(row);
    for (int i = 0; i < 3; ++i)
      put(header, at + 4 * static_cast<std::size_t>(i),
          static_cast<float>(axes(row, i) * frame.spacing_mm[i]));
    put(header, at + 12, static_cast<float>(origin[row]));
    put(header, 268 + 4 * static_cast<std::size_t>(row), static_cast<float>(origin[row]));
  }
  if (mirrored) axes.col(2) *= -1;
  Eigen::Quaterniond q(axes);
  if (q.w() < 0) q.coeffs() *= -1;
  put(header, 256, static_cast<float>(q.x()));
  put(header, 260, static_cast<float>(q.y()));
  put(header, 264, static_cast<float>(q.z()));
  std::memcpy(header.data() + 344, "n+1", 4);
  return header;
}

}  // namespace

void io::write_nrrd(const fs::path& path, const LabelImage& image,
                    const std::function<void()>& when_complete) {
  const ImageFrame& frame = image.frame();
  const VoxelType type = smallest_type(image);
  OutputFile file(path);
  file.print("NRRD0004\ntype: {}\ndimension: 3\nspace: left-posterior-superior\n", io::names_of(type).nrrd);
  file.print("sizes: {} {} {}\nspace directions:", frame.size.x(), frame.size.y(), frame.size.z());
  for (int i = 0; i < 3; ++i) file.print(" {}", vector_text(frame.direction.col(i) * frame.spacing_mm[i]));
  file.print(
      "\nkinds: domain domain domain\nendian: little\nencoding: gzip\nspace units: \"mm\" \"mm\" \"mm\"\n");
  file.print("space origin: {}\n\n", vector_text(frame.origin_mm));
  const std::size_t width = io::voxel_bytes(type);
  io::write_gzip(file, frame.voxel_count() * width, [&](std::size_t first, std::size_t last, std::byte* out) {
    fill_voxels(image, type, first / width, last / width, out);
  });
  if (when_complete) when_complete();
  file.commit();
}

void io::write_nifti(const fs::path& path, const LabelImage& image,
                     const std::function<void()>& when_complete) {
  const VoxelType type = smallest_type(image);
  const std::array<std::byte, 352> header = nifti_header(path, image.frame(), type);
  const std::size_t width = io::voxel_bytes(type);
  const std::size_t bytes = image.frame().voxel_count() * width;
  OutputFile file(path);
  if (lower_extension(path).ends_with(".gz")) {
    // Voxels begin at a multiple of their width (352), so parts split between voxels.
    io::write_gzip(file, header.size() + bytes, [&](std::size_t first, std::size_t last, std::byte* out) {
      const std::size_t from_header = first < header.size() ? header.size() - first : 0;
      std::memcpy(out, header.data() + (header.size() - from_header), from_header);
      const std::size_t begin = first + from_header - header.size();
      fill_voxels(image, type, begin / width, (last - header.size()) / width, out + from_header);
    });
  } else {
    file.write(header.data(), header.size());
    constexpr std::size_t kChunk = std::size_t{1} << 20;
    std::vector<std::byte> chunk(kChunk * width);
    for (std::size_t first = 0; first < image.voxels().size(); first += kChunk) {
      parallel::check_cancelled();
      const std::size_t last = std::min(image.voxels().size(), first + kChunk);
      fill_voxels(image, type, first, last, chunk.data());
      file.write(chunk.data(), (last - first) * width);
    }
  }
  if (when_complete) when_complete();
  file.commit();
}

void write_image(const fs::path& path, const LabelImage& image, const std::function<void()>& when_complete) {
  io::format_of(path, FileUse::kWriteImage).code.write_image(path, image, when_complete);
}

}  // namespace lumesh
