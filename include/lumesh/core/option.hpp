#pragma once
/// @file Options of a stage, each described once: name, values, unit, default and meaning. The command line,
/// case files, `lumesh options`, the tables of the documentation and the checks of ranges all read these
/// descriptions.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace lumesh {

/// Uses of files that are read and written; the formats of each stand in src/io/file_formats.cpp.
enum class FileUse : std::uint8_t {
  kRead,          ///< read_mesh().
  kReadVolume,    ///< Reading where cells are wanted.
  kWrite,         ///< write_mesh().
  kWriteVolume,   ///< Writing of the volume, not the boundary alone.
  kWriteMixed,    ///< Such a volume of prisms and pyramids, too, not of tetrahedra alone.
  kWriteSurface,  ///< write_surface().
  kWordNames,     ///< Writing where names of patches become words (mesh/patch_words.hpp).
  kWriteSingle,   ///< Writing where places are rounded to single precision.
  kLabelAlias,    ///< MeshWriteOptions::compat.
  kPatchArray,    ///< Reading of patches by an array that is named.
  kCarryMetric,   ///< A metric or sizes in the mesh's own file.
  kMetricAlone,   ///< read_metric() and write_metric().
  kPoints,        ///< read_points().
  kPointData,     ///< read_point_data().
  kLines,         ///< read_polylines() and write_polylines().
  kReadImage,     ///< read_image().
  kWriteImage,    ///< write_image().
};

/// The finite numbers that an option takes.
struct OptionRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool excludes_min = false, includes_infinity = false;

  [[nodiscard]] bool contains(double value) const;
  /// The range in words, such as "between 1 and 3" or "greater than 0"; empty if every number is in it.
  [[nodiscard]] std::string text() const;
};
[[nodiscard]] inline OptionRange any_number() {
  return {};
}
[[nodiscard]] inline OptionRange between(double min, double max) {
  return {min, max};
}
[[nodiscard]] inline OptionRange at_least(double min) {
  return {.min = min};
}
[[nodiscard]] inline OptionRange above(double min) {
  return {.min = min, .excludes_min = true};
}

/// One word of several.
struct OptionWord {
  std::vector<std::string> words;
  /// Other spellings of a word, mostly the paper's numbers: "0" for "frozen".
  std::map<std::string, std::string, std::less<>> synonyms;
  std::function<std::size_t()> get;  ///< The index of the word that is chosen.
  std::function<void(std::size_t)> set;

  /// The index of the word that `text` spells, if any.
  [[nodiscard]] std::optional<std::size_t> index_of(std::string_view text) const;
  /// Fault of a text that spells none: "must be one of "a", "b", not "c"".
  [[nodiscard]] std::string complaint(std::string_view text) const;
};

/// A file that is read, or one of a few words that stand for data of another stage.
struct OptionPath {
  std::string* path;
  std::vector<std::string> words;  ///< Not paths, such as "centerline".
};

/// A value of its own type that a text stands for, such as a length in mm or in radii.
struct OptionParsed {
  std::function<std::string()> get;  ///< The text of the value; empty for none.
  /// @throws Error{kUsage} for texts that stand for no value; the message does not name the option.
  std::function<void(const std::string&)> set;
};

/// Rows of so many numbers each, such as the point and normal of cut planes.
struct OptionRows {
  std::size_t width;
  std::string example;  ///< One row as a user writes it: "12.5,-40,8".
  bool is_single;       ///< Exactly one row, written without brackets of its own; a number alone fills it.
  std::function<std::vector<std::vector<double>>()> get;
  /// @throws Error{kUsage} for numbers that make no sense together; the message does not name the option.
  std::function<void(const std::vector<std::vector<double>>&)> set;
  std::size_t least = 0;  ///< Numbers that a row has to have, which is none that a number fills; 0: width.
  std::string placeholder = "X,Y,Z";
  bool may_be_none = true;  ///< False where there always is a row, as the size of a phantom.

  [[nodiscard]] bool takes(std::size_t count) const {
    return count <= width && count >= (least > 0 ? least : width);
  }
  [[nodiscard]] std::string width_text() const;  ///< "3 numbers", "1 to 2 numbers".
  /// Whether the command line has the numbers of a row as words of their own, not with commas between them.
  [[nodiscard]] bool are_words() const;
  /// The finite numbers of "12.5,-40,8"; none of other texts, and of rows of another width.
  [[nodiscard]] std::optional<std::vector<double>> row_from(std::string_view text) const;
};

/// Files with a label each, in the order in which they are given.
using LabelledFiles = std::vector<std::pair<std::string, int>>;
struct OptionLabelledFiles {
  LabelledFiles* files;
};

/// Labels by their numbers or names.
struct OptionLabels {
  std::vector<std::string>* words;
};

/// The place where an option's value is kept. A map holds numbers of single labels.
using OptionTarget = std::variant<bool*, int*, std::size_t*, double*, std::optional<double>*, std::string*,
                                  std::vector<std::string>*, std::map<int, double>*, OptionWord, OptionPath,
                                  OptionParsed, OptionRows, OptionLabels, OptionLabelledFiles>;

/// One option. The functions that return the option itself complete its description.
struct Option {
  std::string name;  ///< Words as in case files, joined by underscores.
  OptionTarget target;
  OptionRange range;      ///< Range of numbers.
  std::string meaning;    ///< A phrase without a full stop.
  std::string unit = {};  ///< "mm", "degrees"; empty: none.
  std::vector<std::string> aliases = {};
  /// Where 0 is taken beside the range: the words for what it stands for ("2.5 voxels"), and the value that
  /// the target then gets.
  std::optional<std::string> zero_text = {};
  double zero_value = 0;
  std::string default_text = {};  ///< Text for a number that is not given: what it is then; empty: none.
  std::optional<FileUse> file_use = {};  ///< Use of the files that are named, whose formats the help lists.
  std::vector<std::string> excluded = {},
                           needed = {};  ///< Names of options not to be given with this one, or only with it.

  Option& alias(std::string other) {
    aliases.push_back(std::move(other));
    return *this;
  }
  Option& in(std::string of_unit) {
    unit = std::move(of_unit);
    return *this;
  }
  Option& zero(std::string text, double value = 0) {
    zero_text = std::move(text);
    zero_value = value;
    return *this;
  }
  Option& by_default(std::string text) {
    default_text = std::move(text);
    return *this;
  }
  Option& of_files(FileUse use) {
    file_use = use;
    return *this;
  }
  Option& excludes(std::string other) {
    excluded.push_back(std::move(other));
    return *this;
  }
  Option& needs(std::string other) {
    needed.push_back(std::move(other));
    return *this;
  }

  [[nodiscard]] bool is_called(std::string_view text) const;
  /// The option where the 0 of what is not given is none of its values.
  [[nodiscard]] Option without_zero() const;
  /// Fault of a number: "must lie between 1 and 3, not at 5"; empty if there is none.
  [[nodiscard]] std::string complaint(double value) const;
  /// Range and unit in words: "mm, at least 0".
  [[nodiscard]] std::string domain_text() const;
  /// The value that the target has, as a user reads it: a number, a word, "on" or "off", "2.5 voxels";
  /// "none" for what is empty.
  [[nodiscard]] std::string value_text() const;
  /// The value of a number; none for other targets and for numbers that are not given.
  [[nodiscard]] std::optional<double> number() const;
};

/// The options of a stage, in the order in which they are listed. They point into the struct that described
/// them, which has to live longer.
class OptionList {
 public:
  template <class Number>
  Option& number(std::string name, Number& target, const OptionRange& range, std::string meaning) {
    return add({std::move(name), &target, range, std::move(meaning)});
  }
  /// A switch. One that is on by default is turned off on the command line by --no-NAME.
  Option& flag(std::string name, bool& target, std::string meaning) {
    return add({std::move(name), &target, {}, std::move(meaning)});
  }
  Option& text(std::string name, std::string& target, std::string meaning) {
    return add({std::move(name), &target, {}, std::move(meaning)});
  }
  Option& texts(std::string name, std::vector<std::string>& target, std::string meaning) {
    return add({std::move(name), &target, {}, std::move(meaning)});
  }
  Option& labels(std::string name, std::vector<std::string>& words, std::string meaning) {
    return add({std::move(name), OptionLabels{&words}, {}, std::move(meaning)});
  }
  /// Numbers of single labels, LABEL=NUMBER each.
  Option& of_labels(std::string name, std::map<int, double>& target, const OptionRange& range,
                    std::string meaning) {
    return add({std::move(name), &target, range, std::move(meaning)});
  }
  Option& path(std::string name, std::string& target, std::string meaning,
               std::vector<std::string> words = {}) {
    return add({std::move(name), OptionPath{&target, std::move(words)}, {}, std::move(meaning)});
  }
  Option& parsed(std::string name, OptionParsed target, std::string meaning) {
    return add({std::move(name), std::move(target), {}, std::move(meaning)});
  }
  /// FILE=LABEL each.
  Option& labelled_files(std::string name, LabelledFiles& target, std::string meaning) {
    return add({std::move(name), OptionLabelledFiles{&target}, {}, std::move(meaning)});
  }
  Option& rows(std::string name, OptionRows target, std::string meaning) {
    return add({std::move(name), std::move(target), {}, std::move(meaning)});
  }
  /// @param values  Each word with the value that it stands for.
  template <class Value>
  Option& choice(std::string name, Value& target, const std::vector<std::pair<std::string, Value>>& values,
                 std::string meaning, std::map<std::string, std::string, std::less<>> synonyms = {}) {
    OptionWord word{{}, std::move(synonyms), {}, {}};
    for (const auto& [text, value] : values) word.words.push_back(text);
    word.get = [&target, values] {
      std::size_t i = 0;
      while (i + 1 < values.size() && values[i].second != target) ++i;
      return i;
    };
    word.set = [&target, values](std::size_t i) { target = values[i].second; };
    return add({std::move(name), std::move(word), {}, std::move(meaning)});
  }

  [[nodiscard]] const std::vector<Option>& all() const { return options_; }

 private:
  Option& add(Option option) {
    options_.push_back(std::move(option));
    return options_.back();
  }

  std::vector<Option> options_;
};

/// The options that `described`, a struct with the member describe(OptionList&), has.
template <class Described>
[[nodiscard]] OptionList options_of(Described& described) {
  OptionList list;
  described.describe(list);
  return list;
}

/// Takes "2=0.4" into the numbers of single labels. @return What is wrong with it; empty if nothing is.
[[nodiscard]] std::string add_label_number(std::string_view text, const Option& option,
                                           std::map<int, double>& numbers);

/// Takes "wall.nrrd=2" into files with labels. @return What is wrong with it; empty if nothing is.
[[nodiscard]] std::string add_labelled_file(std::string_view text, LabelledFiles& files);

/// Names of the options of a struct whose values are not those of another, in their order.
template <class Described>
[[nodiscard]] std::vector<std::string> differing_options(const Described& a, const Described& b) {
  Described first = a, second = b;
  const OptionList list = options_of(first), other = options_of(second);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < list.all().size(); ++i)
    if (list.all()[i].value_text() != other.all()[i].value_text()) names.push_back(list.all()[i].name);
  return names;
}

/// @throws Error{kUsage} that names the first option whose number is out of its range.
void require_ranges(const OptionList& list);

/// The same for the options of a struct. @param described  Is only read.
template <class Described>
void require_ranges_of(const Described& described) {
  Described copy = described;
  require_ranges(options_of(copy));
}

/// @throws Error{kUsage} if the number of this option is out of its range, or not given.
void require_given(const OptionList& list, std::string_view name);
template <class Described>
void require_given_of(const Described& described, std::string_view name) {
  Described copy = described;
  require_given(options_of(copy), name);
}

/// An option's name in a message, neutral to how a front end spells it: `name`.
[[nodiscard]] std::string option_name(std::string_view name);

/// A message with each neutral name as a front end spells it.
/// @param spelling  "--split-above" or "[adapt] split_above" for "split_above"; empty where it has no such
/// option.
[[nodiscard]] std::string with_spelled_options(std::string_view message,
                                               const std::function<std::string(std::string_view)>& spelling);

}  // namespace lumesh
