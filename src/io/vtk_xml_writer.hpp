#pragma once
/// @file VTK XML files with inline base64 of zlib blocks, the encoding that ParaView, VTK and meshio all
/// read.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "lumesh/core/types.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "output_file.hpp"

namespace lumesh::io {

/// Name, type and shape of a data array.
struct XmlArray {
  std::string_view name;
  std::string_view type;       ///< VTK's: Int8, UInt8, Int32, Int64, Float64.
  std::size_t components = 1;  ///< Values per tuple.
  std::size_t tuples = 0;
  std::span<const std::string_view> component_names = {};  ///< One per component, or none.
};

/// Bytes per value of a VTK type; 0 if unknown.
[[nodiscard]] std::size_t xml_type_bytes(std::string_view type);

/// VTK's type of numbers. Indices of points are below 2^31 by far, so their bits serve as Int32.
template <class Number>
constexpr std::string_view xml_type_of() {
  if constexpr (std::is_same_v<Number, double>) return "Float64";
  if constexpr (std::is_same_v<Number, char>) return "Int8";
  if constexpr (std::is_same_v<Number, std::uint8_t>) return "UInt8";
  if constexpr (std::is_same_v<Number, std::int64_t>) return "Int64";
  if constexpr (std::is_same_v<Number, std::int32_t> || std::is_same_v<Number, std::uint32_t>) return "Int32";
}

/// Text as it may stand in an attribute or between elements; control characters become _.
[[nodiscard]] std::string xml_escaped(std::string_view text);

/// Writes the elements of one file in order. Opened elements must be closed by the caller.
class VtkXmlWriter {
 public:
  /// Fills `out` with the bytes of tuples [first, last).
  using Fill = std::function<void(std::size_t first, std::size_t last, std::byte* out)>;

  VtkXmlWriter(const std::filesystem::path& path, std::string_view dataset_type);

  template <class... Args>
  void print(fmt::format_string<Args...> format, Args&&... args) {
    file_.print(format, std::forward<Args>(args)...);
  }
  /// Ends the field data, and begins what holds the cells.
  void begin_cells(std::size_t points, std::size_t cells) {
    print("</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", points, cells);
  }
  /// Begins what holds the lines or polygons of a file of PolyData.
  void begin_poly_data(std::size_t points, std::size_t lines, std::size_t polygons) {
    print("<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" ",
          points, lines);
    print("NumberOfPolys=\"{}\">\n", polygons);
  }
  /// The element `kind`, Lines or Polys: corners of cells, and where each cell's end.
  template <class Corners>
  void cells(std::string_view kind, const Corners& corners, const std::vector<std::int64_t>& ends) {
    print("<{}>\n", kind);
    numbers("connectivity", corners);
    numbers("offsets", ends);
    print("</{}>\n", kind);
  }
  /// Compresses blocks in parallel; memory: the compressed array.
  void array(const XmlArray& shape, const Fill& fill);
  /// The same of numbers that lie in memory as in the file.
  template <class Numbers>
  void numbers(std::string_view name, const Numbers& all, std::size_t components = 1) {
    using Number = std::remove_cv_t<typename Numbers::value_type>;
    array({name, xml_type_of<Number>(), components, all.size() / components},
          [&](std::size_t first, std::size_t last, std::byte* out) {
            std::memcpy(out, all.data() + first * components, (last - first) * components * sizeof(Number));
          });
  }
  void vectors(std::string_view name, std::span<const Vec3> vectors);
  void points(std::span<const Vec3> points);
  /// FieldData arrays `unit`, `frame` and `lumesh_info` (JSON, with provenance), as bytes of text; for inside
  /// <FieldData>.
  void info_arrays(const MeshInfo& info);
  void commit();

 private:
  OutputFile file_;
  std::string_view dataset_type_;
};

}  // namespace lumesh::io
