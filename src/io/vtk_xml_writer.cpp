#include "vtk_xml_writer.hpp"

#include <zlib.h>

#include <algorithm>
#include <string>

#include "lumesh/core/assert.hpp"
#include "lumesh/core/base64.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/parallel/loops.hpp"
#include "mesh_info_json.hpp"

namespace lumesh::io {

namespace {

constexpr std::size_t kTargetBlockBytes = std::size_t{1} << 18;
constexpr int kCompressionLevel = 1;  // Level 6 takes 4 times as long for 5 % smaller files.

/// Streams base64; pads at the end.
class Base64Stream {
 public:
  explicit Base64Stream(OutputFile& file) : file_(file) {}

  void write(std::string_view bytes) {
    if (!held_.empty()) {
      const std::size_t missing = std::min(kGroup - held_.size(), bytes.size());
      held_ += bytes.substr(0, missing);
      bytes.remove_prefix(missing);
      if (held_.size() < kGroup) return;
      finish();
    }
    const std::size_t whole = bytes.size() / kGroup * kGroup;
    file_.write(encode_base64(bytes.substr(0, whole)));
    held_ = bytes.substr(whole);
  }
  void finish() {
    file_.write(encode_base64(held_));
    held_.clear();
  }

 private:
  static constexpr std::size_t kGroup = 3;  // Bytes that become letters together.
  OutputFile& file_;
  std::string held_;
};

std::string compress_block(const std::vector<std::byte>& raw) {
  uLongf bytes = compressBound(static_cast<uLong>(raw.size()));
  std::string packed(bytes, '\0');
  const int code =
      compress2(reinterpret_cast<Bytef*>(packed.data()), &bytes, reinterpret_cast<const Bytef*>(raw.data()),
                static_cast<uLong>(raw.size()), kCompressionLevel);
  LUMESH_ASSERT(code == Z_OK);
  packed.resize(bytes);
  packed.shrink_to_fit();
  return packed;
}

}  // namespace

std::string xml_escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += static_cast<unsigned char>(c) < ' ' ? '_' : c;
    }
  }
  return out;
}

std::size_t xml_type_bytes(std::string_view type) {
  if (type == "Int8" || type == "UInt8") return 1;
  if (type == "Int16" || type == "UInt16") return 2;
  if (type == "Int32" || type == "UInt32" || type == "Float32") return 4;
  if (type == "Int64" || type == "UInt64" || type == "Float64") return 8;
  return 0;
}

VtkXmlWriter::VtkXmlWriter(const std::filesystem::path& path, std::string_view dataset_type)
    : file_(path), dataset_type_(dataset_type) {
  print("<?xml version=\"1.0\"?>\n<!-- lumesh {} -->\n", kVersion);
  print("<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" ",
        dataset_type);
  print("compressor=\"vtkZLibDataCompressor\">\n<{}>\n", dataset_type);
}

void VtkXmlWriter::array(const XmlArray& shape, const Fill& fill) {
  print("<DataArray type=\"{}\" Name=\"{}\" ", shape.type, xml_escaped(shape.name));
  // meshio makes a column of a scalar that says it has one component.
  if (shape.components > 1) print("NumberOfComponents=\"{}\" ", shape.components);
  for (std::size_t i = 0; i < shape.component_names.size(); ++i)
    print("ComponentName{}=\"{}\" ", i, xml_escaped(shape.component_names[i]));
  print("NumberOfTuples=\"{}\" format=\"binary\">\n", shape.tuples);
  const std::size_t tuple_bytes = xml_type_bytes(shape.type) * shape.components;
  // A multiple of 8 tuples, so that readers may decode blocks one by one into any type.
  const std::size_t block = std::max<std::size_t>(8, kTargetBlockBytes / tuple_bytes / 8 * 8);
  std::vector<std::string> packed((shape.tuples + block - 1) / block);
  parallel::for_each_block(shape.tuples, block, [&](std::size_t b, std::size_t begin, std::size_t end) {
    std::vector<std::byte> raw((end - begin) * tuple_bytes);
    fill(begin, end, raw.data());
    packed[b] = compress_block(raw);
  });
  const std::size_t last = shape.tuples % block * tuple_bytes;
  std::vector<std::uint64_t> header = {packed.size(), packed.empty() ? 0 : block * tuple_bytes, last};
  for (const auto& bytes : packed) header.push_back(bytes.size());
  file_.write(
      encode_base64({reinterpret_cast<const char*>(header.data()), header.size() * sizeof(header[0])}));
  Base64Stream stream(file_);
  for (const auto& bytes : packed) stream.write(bytes);
  stream.finish();
  print("\n</DataArray>\n");
}

void VtkXmlWriter::vectors(std::string_view name, std::span<const Vec3> vectors) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  numbers(name, std::span(reinterpret_cast<const double*>(vectors.data()), 3 * vectors.size()), 3);
}

void VtkXmlWriter::points(std::span<const Vec3> points) {
  print("<Points>\n");
  vectors("Points", points);
  print("</Points>\n");
}

void VtkXmlWriter::info_arrays(const MeshInfo& info) {
  numbers("unit", info.unit);
  numbers("frame", info.frame);
  numbers("lumesh_info", info_to_json(info));
}

void VtkXmlWriter::commit() {
  print("</{}>\n</VTKFile>\n", dataset_type_);
  file_.commit();
}

}  // namespace lumesh::io
