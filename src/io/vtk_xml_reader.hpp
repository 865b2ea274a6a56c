#pragma once
/// @file VTK XML files of any encoding: text, base64 or appended raw bytes, plain or zlib.

#include <cstdint>
#include <filesystem>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/core/types.hpp"
#include "polygons.hpp"

namespace lumesh::io {

/// A parsed file and its arrays on demand. Every failure throws Error{kBadInput} that names the file.
class VtkXmlReader {
 public:
  /// @param dataset_type  What the file must hold, such as "UnstructuredGrid".
  VtkXmlReader(const std::filesystem::path& path, std::string_view dataset_type);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// The dataset element; its one <Piece> is piece().
  [[nodiscard]] pugi::xml_node dataset() const { return dataset_; }
  [[nodiscard]] pugi::xml_node piece() const { return piece_; }
  /// The array called `name` below a parent element, or an empty node.
  [[nodiscard]] static pugi::xml_node find_array(const pugi::xml_node& parent, std::string_view name);
  /// A count attribute of the piece, such as NumberOfPoints.
  [[nodiscard]] std::size_t count(const char* attribute) const;

  /// Values of an array. Integers refuse files with fractions; `what` names the array in messages.
  [[nodiscard]] std::vector<double> doubles(const pugi::xml_node& array, const char* what) const;
  [[nodiscard]] std::vector<std::int64_t> integers(const pugi::xml_node& array, const char* what) const;
  /// The piece's points, finite numbers each.
  [[nodiscard]] std::vector<Vec3> points() const;
  /// Cells of a kind of the piece, such as Polys.
  [[nodiscard]] CellCorners cells(const char* kind) const;
  /// Bytes as text, for arrays that hold characters.
  [[nodiscard]] std::string text(const pugi::xml_node& array) const;

  [[noreturn]] void fail(const std::string& what) const;

 private:
  [[nodiscard]] std::vector<unsigned char> bytes(const pugi::xml_node& array, const char* what) const;
  [[nodiscard]] std::vector<unsigned char> unpack(std::string_view raw, const char* what) const;
  [[nodiscard]] std::uint64_t header_word(std::string_view raw, std::size_t index, const char* what) const;
  /// Checks the size of an array that is about to be unpacked.
  void check_size(std::uint64_t bytes, const char* what) const;
  template <class Value>
  [[nodiscard]] std::vector<Value> values(const pugi::xml_node& array, const char* what) const;
  void split_appended();
  [[nodiscard]] std::string_view appended_text(std::size_t offset, const char* what) const;

  std::filesystem::path path_;
  std::string content_;
  std::string_view appended_;  ///< After the underscore.
  bool appended_is_base64_ = false;
  bool packed_ = false;  ///< zlib blocks.
  std::size_t header_bytes_ = 4;
  mutable std::uint64_t unpacked_bytes_ = 0;  ///< Of all arrays so far.
  pugi::xml_document document_;
  pugi::xml_node dataset_;
  pugi::xml_node piece_;
};

}  // namespace lumesh::io
