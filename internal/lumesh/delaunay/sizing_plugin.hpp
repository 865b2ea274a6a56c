#pragma once
/// @file Sizes from a shared library of the user (lumesh/sizing.h).

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/delaunay/sizing.hpp"
#include "lumesh/parallel/counters.hpp"

namespace lumesh {

/// Path and options of a plugin, as `--sizing` names them.
struct PluginName {
  std::filesystem::path path;
  std::string options;  ///< The text after the colon, or "".
};

/// Splits "path[:options]" at the first colon before which stands the name of a file that exists, so that
/// names and options may hold colons; if there is none, at the first colon.
[[nodiscard]] PluginName split_plugin_name(std::string_view text);

/// A loaded plugin. Its answers are not trusted: one that makes no sense counts as kAnySize, and so does an
/// exception; warnings() tells their number. Const calls from any thread. Cost: that of the plugin and
/// about 10 ns for the count.
class PluginSizing final : public Sizing {
 public:
  /// Loads the library and has it read its options.
  /// @param text  "path[:options]"; a path without folder is in the working directory.
  /// @throws Error{kBadInput} in one line that names the file and what to do, if the file is missing or is no
  /// shared library, lacks functions, is made for another version, or refuses its options.
  explicit PluginSizing(std::string_view text);
  ~PluginSizing() override;

  /// The plugin's lumesh_size_at(), or infinity if it has none. It does not see labels.
  [[nodiscard]] double size_at(const Vec3& point_mm, Label label) const override;
  /// The plugin's lumesh_should_be_adapted(), or false if it has none.
  [[nodiscard]] bool wants_finer(const std::array<Vec3, 4>& corners_mm) const override;
  [[nodiscard]] bool has_criterion() const override;
  /// Warnings of bad answers, exceptions, and calls that take more than 5 us on average.
  [[nodiscard]] std::vector<std::string> warnings() const override;

 private:
  struct Library;
  enum Count : std::size_t { kCalls, kBadAnswers, kExceptions, kTimedCalls, kNanoseconds, kCounts };
  struct Thrown {
    Vec3 point = Vec3::Zero();
    std::array<char, 160> text = {};  ///< Ended by 0.
  };

  template <class Call, class Answer>
  [[nodiscard]] Answer ask(const Vec3& where, Answer no_answer, const Call& call) const;

  std::unique_ptr<Library> library_;
  mutable parallel::Counters<kCounts> counts_;
  mutable parallel::FirstValue<Vec3> first_bad_;
  mutable parallel::FirstValue<Thrown> first_thrown_;
};

}  // namespace lumesh
