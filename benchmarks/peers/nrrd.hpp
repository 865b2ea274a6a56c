#pragma once
/// @file A small reader of NRRD label images, for drivers of programs that do not read what lumesh reads.

#include <zlib.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace peers {

struct LabelImage {
  std::array<std::size_t, 3> size{};
  std::array<std::array<double, 3>, 3> step{};  ///< From a voxel to the next along axis i, mm in LPS.
  std::array<double, 3> origin{};               ///< Centre of the first voxel, mm in LPS.
  std::vector<std::uint16_t> labels;            ///< The first axis runs fastest.
};

namespace detail {

inline std::string without_spaces(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

/// "(1,0,0) (0,1,0)" or "64 64 64" as numbers.
inline std::vector<double> numbers_of(std::string text) {
  for (char& c : text)
    if (c == '(' || c == ')' || c == ',') c = ' ';
  std::istringstream in(text);
  std::vector<double> numbers;
  for (double x = 0; in >> x;) numbers.push_back(x);
  return numbers;
}

/// What x, y and z of the file are to be multiplied with to be LPS; without a name they are taken as LPS.
inline std::array<double, 3> signs_of(const std::string& space) {
  if (space.empty() || space == "left-posterior-superior" || space == "LPS") return {1, 1, 1};
  if (space == "right-anterior-superior" || space == "RAS") return {-1, -1, 1};
  throw std::runtime_error("space '" + space + "' is not known");
}

template <class Voxel>
void take_labels(const std::vector<unsigned char>& bytes, std::vector<std::uint16_t>& labels) {
  const Voxel* voxels = reinterpret_cast<const Voxel*>(bytes.data());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (voxels[i] < 0 || static_cast<std::int64_t>(voxels[i]) > 65535)
      throw std::runtime_error("labels must lie from 0 to 65535");
    labels[i] = static_cast<std::uint16_t>(voxels[i]);
  }
}

struct VoxelType {
  std::size_t bytes;
  void (*take)(const std::vector<unsigned char>&, std::vector<std::uint16_t>&);
};

inline VoxelType voxel_type(const std::string& name) {
  static const std::map<std::string, VoxelType> types = {
      {"uint8", {1, take_labels<std::uint8_t>}},   {"uchar", {1, take_labels<std::uint8_t>}},
      {"int8", {1, take_labels<std::int8_t>}},     {"unsigned char", {1, take_labels<std::uint8_t>}},
      {"int16", {2, take_labels<std::int16_t>}},   {"short", {2, take_labels<std::int16_t>}},
      {"uint16", {2, take_labels<std::uint16_t>}}, {"unsigned short", {2, take_labels<std::uint16_t>}},
      {"ushort", {2, take_labels<std::uint16_t>}}, {"int", {4, take_labels<std::int32_t>}},
      {"int32", {4, take_labels<std::int32_t>}}};
  const auto found = types.find(name);
  if (found == types.end()) throw std::runtime_error("voxels of type '" + name + "' are not read");
  return found->second;
}

inline void take_frame(std::map<std::string, std::string>& fields, LabelImage& image) {
  const std::vector<double> size = numbers_of(fields["sizes"]);
  if (fields["dimension"] != "3" || size.size() != 3) throw std::runtime_error("not an image of three axes");
  const std::vector<double> step = numbers_of(fields["space directions"]);
  const std::vector<double> spacing = numbers_of(fields["spacings"]);
  std::vector<double> origin = numbers_of(fields["space origin"]);
  origin.resize(3, 0);
  const std::array<double, 3> sign = signs_of(fields["space"]);
  for (std::size_t i = 0; i < 3; ++i) {
    image.size[i] = static_cast<std::size_t>(size[i]);
    image.origin[i] = sign[i] * origin[i];
    for (std::size_t j = 0; j < 3; ++j) {
      const double of_spacing = i != j ? 0 : spacing.size() == 3 ? spacing[i] : 1;
      image.step[i][j] = sign[j] * (step.size() == 9 ? step[3 * i + j] : of_spacing);
    }
  }
}

/// The bytes behind the header; zlib passes on what is not compressed.
inline std::vector<unsigned char> read_bytes(const std::string& path, long begin, std::size_t count,
                                             bool gzip) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  std::vector<unsigned char> bytes(count);
  if (!file || std::fseek(file.get(), begin, SEEK_SET) != 0) throw std::runtime_error("cannot be read");
  if (!gzip) {
    if (std::fread(bytes.data(), 1, count, file.get()) != count) throw std::runtime_error("is truncated");
    return bytes;
  }
  z_stream stream{};
  inflateInit2(&stream, 16 + MAX_WBITS);
  std::vector<unsigned char> packed(1 << 20);
  int status = Z_OK;
  // avail_out counts in 32 bits: images above 4 GiB need several turns, as the input does.
  for (std::size_t done = 0; done < count && status == Z_OK;) {
    if (stream.avail_in == 0) {
      stream.avail_in = static_cast<uInt>(std::fread(packed.data(), 1, packed.size(), file.get()));
      stream.next_in = packed.data();
      if (stream.avail_in == 0) break;
    }
    stream.next_out = bytes.data() + done;
    stream.avail_out = static_cast<uInt>(std::min<std::size_t>(count - done, 1U << 30));
    status = inflate(&stream, Z_NO_FLUSH);
    done = stream.next_out - bytes.data();
  }
  const bool whole = stream.total_out == count;
  inflateEnd(&stream);
  if (!whole) throw std::runtime_error("is truncated or damaged");
  return bytes;
}

}  // namespace detail

/// Reads an attached .nrrd of integers, raw or gzip, in the frame that lumesh gives it.
/// @throws std::runtime_error that names the file.
inline LabelImage read_nrrd(const std::string& path) try {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot be read");
  std::string line;
  if (!std::getline(file, line) || line.rfind("NRRD", 0) != 0) throw std::runtime_error("is not NRRD");
  std::map<std::string, std::string> fields;
  while (std::getline(file, line) && !detail::without_spaces(line).empty())
    if (const auto colon = line.find(':'); line[0] != '#' && colon != std::string::npos)
      fields[line.substr(0, colon)] = detail::without_spaces(line.substr(colon + 1));
  if (fields.count("data file") != 0) throw std::runtime_error("has its voxels in another file");
  if (fields["endian"] == "big") throw std::runtime_error("is big-endian");
  const bool gzip = fields["encoding"] == "gzip" || fields["encoding"] == "gz";
  if (!gzip && fields["encoding"] != "raw") throw std::runtime_error("is encoded neither raw nor as gzip");
  LabelImage image;
  detail::take_frame(fields, image);
  const detail::VoxelType type = detail::voxel_type(fields["type"]);
  image.labels.resize(image.size[0] * image.size[1] * image.size[2]);
  type.take(detail::read_bytes(path, static_cast<long>(file.tellg()), image.labels.size() * type.bytes, gzip),
            image.labels);
  return image;
} catch (const std::exception& fault) {
  throw std::runtime_error(path + ": " + fault.what());
}

}  // namespace peers
