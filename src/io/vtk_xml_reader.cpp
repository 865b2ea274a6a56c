#include "vtk_xml_reader.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>

#include "file_fault.hpp"
#include "lumesh/core/base64.hpp"
#include "lumesh/core/memory.hpp"
#include "vtk_xml_writer.hpp"

namespace lumesh::io {

namespace {

constexpr std::uint64_t kBestRatio = 1100;  // zlib cannot do better than 1032 : 1

/// And small enough for an integer of 64 bits.
template <class Number>
bool is_whole(Number number) {
  return std::abs(number) < Number(9e15) && number == std::floor(number);
}

template <class Stored, class Value>
bool convert_all(const std::vector<unsigned char>& bytes, std::vector<Value>& out) {
  out.resize(bytes.size() / sizeof(Stored));
  for (std::size_t i = 0; i < out.size(); ++i) {
    Stored stored;
    std::memcpy(&stored, bytes.data() + i * sizeof(Stored), sizeof(Stored));
    if constexpr (std::is_integral_v<Value> && std::is_floating_point_v<Stored>) {
      if (!is_whole(stored)) return false;
    }
    out[i] = static_cast<Value>(stored);
  }
  return true;
}

template <class Value>
bool parse_text(std::string_view text, std::vector<Value>& out) {
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    while (at != end && (*at == ' ' || *at == '\n' || *at == '\t' || *at == '\r')) ++at;
    if (at == end) return true;
    Value value{};
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc()) return false;
    out.push_back(value);
    at = next;
  }
}

}  // namespace

VtkXmlReader::VtkXmlReader(const std::filesystem::path& path, std::string_view dataset_type) : path_(path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(kNotThere);
  content_.assign(std::istreambuf_iterator<char>(in), {});
  if (content_.empty()) fail("the file is empty; copy it again");
  split_appended();
  const std::size_t xml_size = appended_.data() == nullptr
                                   ? content_.size()
                                   : static_cast<std::size_t>(appended_.data() - content_.data());
  // The appended bytes are no XML: an unclosed <AppendedData> ends the parse, but what stands before it is
  // there.
  const pugi::xml_parse_result result =
      document_.load_buffer_inplace(content_.data(), xml_size, pugi::parse_minimal | pugi::parse_fragment);
  if (!result && appended_.data() == nullptr)
    fail(fmt::format("not a complete XML file ({}); write or copy it again", result.description()));
  const pugi::xml_node file = document_.child("VTKFile");
  if (!file) fail("not a VTK XML file");
  if (file.attribute("type").value() != dataset_type)
    fail(fmt::format("holds {} where {} is needed", file.attribute("type").value(), dataset_type));
  if (std::string_view(file.attribute("byte_order").as_string("LittleEndian")) != "LittleEndian")
    fail("big-endian VTK XML files are not supported; write it again on this machine");
  header_bytes_ = std::string_view(file.attribute("header_type").as_string("UInt32")) == "UInt64" ? 8 : 4;
  const std::string_view compressor = file.attribute("compressor").as_string("");
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
    fail(fmt::format("compressed with {}; write it with zlib or uncompressed", compressor));
  packed_ = !compressor.empty();
  dataset_ = file.child(std::string(dataset_type).c_str());
  piece_ = dataset_.child("Piece");
  if (!piece_) fail("has no data piece");
  if (piece_.next_sibling("Piece")) fail("holds several pieces; merge them into one first");
}

void VtkXmlReader::split_appended() {
  const std::size_t tag = content_.find("<AppendedData");
  if (tag == std::string::npos) return;
  const std::size_t close = content_.find('>', tag);
  const std::size_t start = close == std::string::npos ? close : content_.find('_', close);
  if (start == std::string::npos) fail("its appended data are cut off");
  appended_is_base64_ = content_.substr(tag, close - tag).find("base64") != std::string::npos;
  appended_ = std::string_view(content_).substr(start + 1);
}

pugi::xml_node VtkXmlReader::find_array(const pugi::xml_node& parent, std::string_view name) {
  for (const pugi::xml_node& array : parent.children("DataArray")) {
    if (array.attribute("Name").value() == name) return array;
  }
  return {};
}

std::size_t VtkXmlReader::count(const char* attribute) const {
  const long long n = piece_.attribute(attribute).as_llong(0);
  if (n < 0 || n > std::numeric_limits<std::int32_t>::max() * 4LL)
    fail(fmt::format("{} is out of range", attribute));
  return static_cast<std::size_t>(n);
}

std::vector<Vec3> VtkXmlReader::points() const {
  const std::vector<double> values = doubles(piece_.child("Points").child("DataArray"), "point coordinates");
  if (values.size() != 3 * count("NumberOfPoints")) fail(kFewPoints);
  std::vector<Vec3> points(values.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = Vec3(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    if (!points[i].allFinite()) fail("point " + std::to_string(i) + " is not finite");
  }
  return points;
}

CellCorners VtkXmlReader::cells(const char* kind) const {
  const pugi::xml_node node = piece_.child(kind);
  const std::string name = kind;
  return {integers(find_array(node, "connectivity"), (name + " connectivity").c_str()),
          integers(find_array(node, "offsets"), (name + " offsets").c_str())};
}

std::string_view VtkXmlReader::appended_text(std::size_t offset, const char* what) const {
  if (appended_.data() == nullptr || offset >= appended_.size())
    fail(fmt::format("the data of {} are cut off", what));
  return appended_.substr(offset);
}

std::uint64_t VtkXmlReader::header_word(std::string_view raw, std::size_t index, const char* what) const {
  if ((index + 1) * header_bytes_ > raw.size()) fail(fmt::format("the data of {} are cut off", what));
  std::uint64_t word = 0;
  std::memcpy(&word, raw.data() + index * header_bytes_, header_bytes_);
  return word;
}

void VtkXmlReader::check_size(std::uint64_t bytes, const char* what) const {
  unpacked_bytes_ += bytes;
  if (unpacked_bytes_ > kBestRatio * content_.size())
    fail(fmt::format(
        "holds more in its arrays, up to {}, than a file of its size can; several are the same data", what));
  constexpr std::uint64_t kLarge = 64U << 20U, kMaxPerByte = 9;  // 8-bit numbers and what they become.
  if (bytes > kLarge && kMaxPerByte * bytes > available_memory_bytes())
    io::fail(path_, fmt::format("unpacking {} needs more memory than there is", what), ErrorKind::kMemory);
}

/// Length or block header, then the bytes.
std::vector<unsigned char> VtkXmlReader::unpack(std::string_view raw, const char* what) const {
  const auto cut_off = [&] { fail(fmt::format("the data of {} are cut off or damaged", what)); };
  if (!packed_) {
    const std::uint64_t size = header_word(raw, 0, what);
    if (size > raw.size() - header_bytes_) cut_off();
    check_size(size, what);
    const char* first = raw.data() + header_bytes_;
    return {first, first + size};
  }
  const std::uint64_t blocks = header_word(raw, 0, what);
  if (blocks == 0) return {};
  const std::uint64_t block_bytes = header_word(raw, 1, what);
  const std::uint64_t last_bytes = header_word(raw, 2, what);
  if (blocks > raw.size() / header_bytes_ || last_bytes > block_bytes ||
      ((blocks > 1 || last_bytes == 0) && block_bytes > kBestRatio * raw.size()))
    cut_off();
  const std::uint64_t total = (blocks - 1) * block_bytes + (last_bytes > 0 ? last_bytes : block_bytes);
  if (total > kBestRatio * raw.size()) cut_off();
  check_size(total, what);
  std::vector<unsigned char> out(total);
  std::size_t from = (3 + blocks) * header_bytes_;
  std::size_t to = 0;
  for (std::uint64_t b = 0; b < blocks; ++b) {
    const std::uint64_t packed = header_word(raw, 3 + b, what);
    if (from > raw.size() || packed > raw.size() - from) cut_off();
    uLongf wanted = b + 1 == blocks && last_bytes > 0 ? last_bytes : block_bytes;
    const uLongf expected = wanted;
    if (uncompress(out.data() + to, &wanted, reinterpret_cast<const Bytef*>(raw.data() + from),
                   static_cast<uLong>(packed)) != Z_OK ||
        wanted != expected)
      cut_off();
    from += packed;
    to += wanted;
  }
  return out;
}

std::vector<unsigned char> VtkXmlReader::bytes(const pugi::xml_node& array, const char* what) const {
  const std::string_view format = array.attribute("format").as_string("ascii");
  if (format == "appended") {
    const auto offset = static_cast<std::size_t>(array.attribute("offset").as_ullong(0));
    const std::string_view data = appended_text(offset, what);
    return appended_is_base64_ ? unpack(decode_base64(data.substr(0, data.find('<'))), what)
                               : unpack(data, what);
  }
  if (format != "binary") fail(fmt::format("{} has the unknown format {}", what, format));
  return unpack(decode_base64(array.text().get()), what);
}

template <class Value>
std::vector<Value> VtkXmlReader::values(const pugi::xml_node& array, const char* what) const {
  if (!array) fail(fmt::format("has no {}", what));
  std::vector<Value> out;
  const std::string_view format = array.attribute("format").as_string("ascii");
  const std::string_view type = array.attribute("type").as_string("");
  const std::string fractions = fmt::format("{} holds fractions where whole numbers are needed", what);
  if (format == "ascii" && std::is_integral_v<Value> && type.starts_with("Float")) {
    const std::vector<double> given = doubles(array, what);
    if (!std::ranges::all_of(given, is_whole<double>)) fail(fractions);
    return std::vector<Value>(given.begin(), given.end());
  }
  if (format == "ascii") {
    if (!parse_text(array.text().get(), out)) fail(fmt::format("{} holds text that is not a number", what));
    return out;
  }
  const std::vector<unsigned char> raw = bytes(array, what);
  using Convert = bool (*)(const std::vector<unsigned char>&, std::vector<Value>&);
  static const std::map<std::string_view, Convert> kConversions = {
      {"Float64", convert_all<double>},     {"Float32", convert_all<float>},
      {"Int64", convert_all<std::int64_t>}, {"UInt64", convert_all<std::uint64_t>},
      {"Int32", convert_all<std::int32_t>}, {"UInt32", convert_all<std::uint32_t>},
      {"Int16", convert_all<std::int16_t>}, {"UInt16", convert_all<std::uint16_t>},
      {"Int8", convert_all<std::int8_t>},   {"UInt8", convert_all<std::uint8_t>}};
  const auto convert = kConversions.find(type);
  if (convert == kConversions.end()) fail(fmt::format("{} has the unknown type {}", what, type));
  if (!convert->second(raw, out)) fail(fractions);
  return out;
}

std::vector<double> VtkXmlReader::doubles(const pugi::xml_node& array, const char* what) const {
  return values<double>(array, what);
}

std::vector<std::int64_t> VtkXmlReader::integers(const pugi::xml_node& array, const char* what) const {
  return values<std::int64_t>(array, what);
}

std::string VtkXmlReader::text(const pugi::xml_node& array) const {
  std::string out;
  for (const std::int64_t c : integers(array, "a text")) out.push_back(static_cast<char>(c));
  return out;
}

void VtkXmlReader::fail(const std::string& what) const {
  std::string line = what;  // It may quote what stands in a damaged file.
  for (char& c : line)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  io::fail(path_, line);
}

}  // namespace lumesh::io
