// MetaImage, https://itk.org/Wiki/ITK/MetaIO/Documentation. Read here because MetaIO, which ITK uses, trusts
// every number of the header: NDims = 2147483648 keeps it busy for hours, and a file cut off is read as if it
// were whole.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/core/trimmed.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "mesh_formats.hpp"
#include "raw_image.hpp"

namespace lumesh::io {

namespace {

namespace fs = std::filesystem;

/// Without blanks around it; damaged files have other control characters too, which must not reach messages.
std::string cleaned(std::string_view text) {
  std::string clean(text);
  for (char& c : clean)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return std::string(trimmed(clean));
}

/// The "key = value" lines up to ElementDataFile, after which the voxels may follow.
class MetaHeader {
 public:
  explicit MetaHeader(const fs::path& path) : path_(path) {
    std::ifstream in(path, std::ios::binary);
    constexpr std::size_t kMaxLines = 1000;
    constexpr std::size_t kLongestLine = 4096;
    std::string line(kLongestLine, '\0');
    for (std::size_t i = 0; i < kMaxLines && in.getline(line.data(), kLongestLine); ++i) {
      const std::string_view text(line.c_str());
      const std::size_t equals = text.find('=');
      if (equals == std::string_view::npos) break;
      const std::string key = cleaned(text.substr(0, equals));
      values_.emplace(key, cleaned(text.substr(equals + 1)));
      if (key != "ElementDataFile") continue;
      size_ = static_cast<std::size_t>(in.tellg());
      return;
    }
    fail(path, "its header has no ElementDataFile; save it again");
  }

  /// Bytes of the header.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// The value of the first of the keys that is there, empty if none is.
  [[nodiscard]] std::string text(std::initializer_list<const char*> keys) const {
    for (const char* key : keys)
      if (const auto found = values_.find(key); found != values_.end()) return found->second;
    return {};
  }
  [[nodiscard]] bool is_true(std::initializer_list<const char*> keys) const {
    const std::string value = text(keys);
    return !value.empty() && (value[0] == 'T' || value[0] == 't' || value[0] == '1');
  }
  /// `count` numbers; empty if none of the keys is there.
  [[nodiscard]] std::vector<double> numbers(std::initializer_list<const char*> keys,
                                            std::size_t count) const {
    const std::string value = text(keys);
    if (value.empty()) return {};
    std::vector<double> all(count);
    const char* at = value.data();
    const char* const end = at + value.size();
    for (double& number : all) {
      while (at != end && *at == ' ') ++at;
      const auto [next, error] = std::from_chars(at, end, number);
      if (error != std::errc())
        fail(path_, fmt::format("its {} does not hold {} numbers; correct the header", *keys.begin(), count));
      at = next;
    }
    return all;
  }
  [[nodiscard]] std::int64_t integer(const char* key, std::int64_t otherwise) const {
    const std::string value = text({key});
    if (value.empty()) return otherwise;
    const std::optional<std::int64_t> number = parse_number<std::int64_t>(value);
    if (!number) fail(path_, fmt::format("its {} is no whole number; correct the header", key));
    return *number;
  }

 private:
  const fs::path& path_;
  std::map<std::string, std::string> values_;
  std::size_t size_ = 0;
};

VoxelType voxel_type(const fs::path& path, const std::string& name) {
  // A long has 32 bits there.
  const std::string known = name == "MET_ULONG" ? "MET_UINT" : name == "MET_LONG" ? "MET_INT" : name;
  for (const VoxelTypeNames& type : kVoxelTypes)
    if (type.meta == known) return type.type;
  fail(path, fmt::format("has voxels of type '{}'; save it with integer voxels", name.substr(0, 30)));
}

std::size_t dimension_count(const fs::path& path, const MetaHeader& header) {
  constexpr std::int64_t kMax = 10;
  const std::int64_t dimensions = header.integer("NDims", 0);
  if (dimensions < 1 || dimensions > kMax) fail(path, "has a damaged header (NDims); save it again");
  if (dimensions < 3) fail(path, fmt::format(kFlatImage, dimensions));
  return static_cast<std::size_t>(dimensions);
}

/// Values of a voxel, side by side.
std::size_t channel_count(const fs::path& path, const MetaHeader& header) {
  const std::int64_t channels = header.integer("ElementNumberOfChannels", 1);
  return product_of_sizes(path, {&channels, 1});
}

/// Frames times channels.
std::size_t volume_count(const fs::path& path, const MetaHeader& header) {
  const std::size_t n = dimension_count(path, header);
  std::vector<std::int64_t> sizes = {static_cast<std::int64_t>(channel_count(path, header))};
  const std::vector<double> all = header.numbers({"DimSize"}, n);
  if (all.empty()) fail(path, "its header has no DimSize; save it again");
  for (std::size_t i = 3; i < n; ++i) {
    constexpr double kMax = 1e9;
    sizes.push_back(std::abs(all[i]) < kMax ? static_cast<std::int64_t>(all[i]) : 0);
  }
  if (sizes.front() > 1 && product_of_sizes(path, {sizes.data() + 1, sizes.size() - 1}) > 1)
    fail(path, fmt::format(kVolumesOfVectors, sizes.front()));
  return product_of_sizes(path, sizes);
}

ImageHeader place(const fs::path& path, const MetaHeader& header, const FileChoice& choice) {
  const std::size_t n = dimension_count(path, header);
  ImageHeader image;
  image.volumes = volume_count(path, header);
  image.unit_is_given = choice.unit_mm.has_value();
  if (const std::string unit = unit_called(header.text({"DistanceUnits"})); unit_in_mm(unit) > 0)
    image.stated_unit = unit;
  const double scale = choice.unit_or_stated_mm(image.stated_unit);
  const auto size = header.numbers({"DimSize"}, n);
  const auto spacing = header.numbers({"ElementSpacing", "ElementSize"}, n);
  const auto origin = header.numbers({"Offset", "Position", "Origin"}, n);
  const auto axes = header.numbers({"TransformMatrix", "Rotation", "Orientation"}, n * n);
  image.has_spacing = spacing.empty() ? kNoAxis : kAllAxes;
  image.type = voxel_type(path, header.text({"ElementType"}));
  constexpr double kLargestSide = 1e9;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!(std::abs(size[i]) < kLargestSide)) fail(path, "has a damaged header (DimSize); save it again");
    image.size.at(i) = static_cast<std::int64_t>(size[i]);
    image.spacing_mm[k] = scale * (spacing.empty() ? 1 : spacing[i]);
    if (!origin.empty()) image.origin_mm[k] = scale * origin[i];
    if (!axes.empty()) image.direction.col(k) = Vec3(axes[n * i], axes[n * i + 1], axes[n * i + 2]);
  }
  return image;
}

/// Inflates zlib or gzip data into `out`; returns the bytes that came, none if their checksum is wrong or
/// missing.
std::size_t inflate_all(std::ifstream& in, std::byte* out, std::size_t bytes) {
  constexpr std::size_t kChunk = std::size_t{1} << 18;
  constexpr int kAnyHeader = 15 + 32;
  std::vector<char> chunk(kChunk);
  z_stream stream = {};
  if (inflateInit2(&stream, kAnyHeader) != Z_OK) return 0;
  const auto has_input = [&] {
    if (stream.avail_in == 0) {
      in.read(chunk.data(), kChunk);
      stream.next_in = reinterpret_cast<Bytef*>(chunk.data());
      stream.avail_in = static_cast<uInt>(in.gcount());
    }
    return stream.avail_in > 0;
  };
  std::size_t done = 0;
  int code = Z_OK;
  while (code == Z_OK && done < bytes && has_input()) {
    const std::size_t room = std::min<std::size_t>(bytes - done, std::size_t{1} << 30);
    stream.next_out = reinterpret_cast<Bytef*>(out + done);
    stream.avail_out = static_cast<uInt>(room);
    code = inflate(&stream, Z_NO_FLUSH);
    done += room - stream.avail_out;
  }
  // The checksum stands behind the last byte, also where there are more than the header says.
  std::vector<Bytef> beyond(kChunk);
  while (code == Z_OK && done == bytes && has_input()) {
    stream.next_out = beyond.data();
    stream.avail_out = static_cast<uInt>(beyond.size());
    code = inflate(&stream, Z_NO_FLUSH);
  }
  inflateEnd(&stream);
  return code == Z_STREAM_END ? done : 0;
}

/// Where the voxels are.
struct VoxelSource {
  fs::path path;
  std::uintmax_t file_bytes = 0;
  bool local = false;  ///< Behind the header.
  bool packed = false;
};

VoxelSource find_voxels(const fs::path& path, const MetaHeader& header) {
  if (!header.text({"BinaryData"}).empty() && !header.is_true({"BinaryData"}))
    fail(path, "stores its voxels as text; save it as binary");
  const std::string name = header.text({"ElementDataFile"});
  if (name.starts_with("LIST") || name.find('%') != std::string::npos)
    fail(path, "keeps its voxels in one file per slice; save it as one .mha file");
  VoxelSource source;
  source.local = name == "LOCAL" || name == "Local" || name == "local";
  source.path = source.local ? path : path.parent_path() / name;
  source.packed = header.is_true({"CompressedData"});
  std::error_code code;
  source.file_bytes = fs::file_size(source.path, code);
  if (code)
    fail(path, fmt::format("its voxels cannot be read from {}; check that file", source.path.string()));
  return source;
}

/// Where they begin, from HeaderSize: -1 says that they end with the file. Refuses files too short for them.
std::uintmax_t voxel_offset(const fs::path& path, const MetaHeader& header, const VoxelSource& source,
                            std::uintmax_t bytes) {
  const std::int64_t stated = header.integer("HeaderSize", 0);
  std::uintmax_t offset = source.local ? header.size() : 0;
  if (stated > 0) offset = static_cast<std::uintmax_t>(stated);
  if (stated == -1) offset = source.file_bytes - std::min(source.file_bytes, bytes);
  if (offset > source.file_bytes || (!source.packed && source.file_bytes - offset < bytes))
    fail(path, kTruncated);
  return offset;
}

}  // namespace

bool is_meta_image(const fs::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".mha" || extension == ".mhd";
}

std::size_t volumes_of_meta_image(const fs::path& path) {
  return volume_count(path, MetaHeader(path));
}

RawImage read_meta_image(const fs::path& path, const FileChoice& choice, Context& context) {
  const MetaHeader header(path);
  const ImageHeader placed = place(path, header, choice);
  const VoxelSource source = find_voxels(path, header);
  RawImage image;
  image.frame = checked_frame(path, placed, context);
  image.type = placed.type;
  const VolumeRange volumes = chosen_volumes(path, placed, choice);
  image.volumes = placed.volumes;  // All are read, for zlib has no places in a file.
  const std::size_t bytes = image.value_count() * voxel_bytes(image.type);
  const std::uintmax_t offset = voxel_offset(path, header, source, bytes);
  image.voxels = allocate_voxels(path, image.frame, image.type, source.file_bytes, image.volumes);
  std::ifstream in(source.path, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(offset));
  std::size_t got = 0;
  if (source.packed) {
    got = inflate_all(in, image.voxels.get(), bytes);
  } else {
    in.read(reinterpret_cast<char*>(image.voxels.get()), static_cast<std::streamsize>(bytes));
    got = static_cast<std::size_t>(in.gcount());
  }
  if (got != bytes) fail(path, kDamagedVoxels);
  if (header.is_true({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"})) swap_bytes(image);
  if (channel_count(path, header) > 1)
    sort_into_volumes(volumes, image);
  else
    keep_volumes(volumes, image);
  return image;
}

}  // namespace lumesh::io
