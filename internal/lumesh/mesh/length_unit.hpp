#pragma once
/// @file Units of lengths in files.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lumesh/mesh/mixed_mesh.hpp"

namespace lumesh {

/// "mm", "cm", "m", "um" or "in" in millimetres; 0 for any other word.
[[nodiscard]] double unit_in_mm(std::string_view unit);

/// The unit that a word in small letters stands for, such as "mm" for "millimetres"; the word where none
/// does.
[[nodiscard]] std::string unit_called(std::string_view word);

/// These words, each for itself, as choices of an option. @param has_file  And "file" for an empty one.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> length_units(bool has_file);

/// A mesh in another unit than its own, for writers. Wanted edge lengths in the metric stay.
class MeshInUnit {
 public:
  /// @param mesh  Is looked at as long as this lives.
  /// @param unit  As it is if one of the two units is not known to unit_in_mm().
  MeshInUnit(const MeshView& mesh, const std::string& unit);
  MeshInUnit(const MeshInUnit&) = delete;
  MeshInUnit& operator=(const MeshInUnit&) = delete;

  [[nodiscard]] const MeshView& view() const { return view_; }

 private:
  MeshInfo info_;
  std::vector<Vec3> points_;
  std::vector<SymTensor> metric_;
  MeshView view_;
};

}  // namespace lumesh
