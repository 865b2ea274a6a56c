#include "lumesh/io/point_data_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string_view>

#include "file_fault.hpp"
#include "format_table.hpp"
#include "lumesh/core/trimmed.hpp"
#include "mesh_formats.hpp"
#include "text_scanner.hpp"
#include "text_table.hpp"

namespace lumesh {

namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

constexpr std::string_view kAround = " \t\r\"";  // Fields.

/// Splits lines at what the first one uses: commas, semicolons, or blanks.
class RowSplitter {
 public:
  explicit RowSplitter(std::string_view first_line) {
    for (const char separator : {',', ';'})
      if (separator_ == ' ' && first_line.find(separator) != std::string_view::npos) separator_ = separator;
  }

  [[nodiscard]] std::vector<std::string_view> fields_of(std::string_view line) const {
    std::vector<std::string_view> fields;
    std::size_t begin = 0;
    bool quoted = false;
    for (std::size_t at = 0; at <= line.size(); ++at) {
      const bool at_end = at == line.size();
      if (!at_end && line[at] == '"') quoted = !quoted;
      if (!at_end && (quoted || !separates(line[at]))) continue;
      const std::string_view field = trimmed(line.substr(begin, at - begin), kAround);
      if (separator_ != ' ' || !field.empty()) fields.push_back(field);
      begin = at + 1;
    }
    return fields;
  }

 private:
  [[nodiscard]] bool separates(char c) const {
    return c == separator_ || (separator_ == ' ' && (c == '\t' || c == '\r'));
  }
  char separator_ = ' ';
};

/// Columns of a text, and what they are called.
struct TextTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
};

struct ColumnName {
  std::string base;
  std::size_t axis = 0;
};

/// The vectors that a column is a component of, if its name says so.
std::optional<ColumnName> component_of(const std::string& name) {
  constexpr std::array<std::string_view, 3> kPlain = {"u", "v", "w"};
  constexpr std::array<std::array<std::string_view, 3>, 3> kSuffixes = {
      {{":0", ":1", ":2"}, {"_0", "_1", "_2"}, {"_x", "_y", "_z"}}};
  const std::string lower = lower_case(name);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (lower == kPlain[axis]) return ColumnName{"velocity", axis};
    for (const auto& suffixes : kSuffixes)
      if (lower.size() > 2 && lower.ends_with(suffixes[axis]))
        return ColumnName{name.substr(0, name.size() - 2), axis};
  }
  return std::nullopt;
}

/// Vectors where all three components are there; what is left over is scalars.
void keep_columns(const TextTable& table, const io::PlaceColumns& places, PointData& data) {
  constexpr std::size_t kNone = ~std::size_t{0};
  std::map<std::string, std::array<std::size_t, 3>> components;
  for (std::size_t c = 0; c < table.names.size(); ++c)
    if (const auto component = component_of(table.names[c]))
      components.try_emplace(component->base, std::array{kNone, kNone, kNone})
          .first->second[component->axis] = c;
  std::vector<std::uint8_t> used(table.names.size(), 0);
  for (const std::size_t c : places) used[c] = 1;
  for (const auto& [base, columns] : components) {
    const auto is_free = [&](std::size_t c) { return c != kNone && used[c] == 0; };
    if (!std::ranges::all_of(columns, is_free)) continue;
    std::vector<Vec3>& vectors = data.vectors[base];
    vectors.resize(data.points.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      used[columns[axis]] = 1;
      for (std::size_t i = 0; i < vectors.size(); ++i)
        vectors[i][static_cast<Eigen::Index>(axis)] = table.columns[columns[axis]][i];
    }
  }
  for (std::size_t c = 0; c < table.names.size(); ++c)
    if (used[c] == 0) data.scalars[table.names[c]] = table.columns[c];
}

TextTable read_table(const std::filesystem::path& path, std::string_view content) {
  TextTable table;
  std::optional<RowSplitter> splitter;
  io::for_each_line(content, [&](std::string_view line, std::size_t number) {
    if (const auto text = trimmed(line, kAround); text.empty() || text.starts_with('#')) return;
    if (!splitter) {
      splitter.emplace(line);
      for (const std::string_view name : splitter->fields_of(line)) table.names.emplace_back(name);
      table.columns.resize(table.names.size());
      if (table.names.size() < 3 || io::real_from(table.names[0]))
        io::fail(path, fmt::format("line {}: names of columns are wanted, such as x,y,z,u,v,w", number));
      return;
    }
    const std::vector<std::string_view> fields = splitter->fields_of(line);
    if (fields.size() != table.names.size())
      io::fail(path, fmt::format("line {}: has {} values for {} columns", number, fields.size(),
                                 table.names.size()));
    for (std::size_t c = 0; c < fields.size(); ++c)
      table.columns[c].push_back(io::real_from(fields[c]).value_or(kNotANumber));
  });
  return table;
}

template <class Arrays>
std::string list_of(const Arrays& arrays) {
  constexpr std::size_t kMaxListed = 8;
  std::string text;
  std::size_t listed = 0;
  for (const auto& [name, values] : arrays) {
    if (listed++ == kMaxListed) return text + ", ...";
    // Names come from a file that may be damaged.
    text += text.empty() ? "" : ", ";
    for (const char c : name.substr(0, 40)) text += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return text.empty() ? "none" : text;
}

template <class Arrays>
const auto& array_named(const Arrays& arrays, const std::string& name, const std::string& usual,
                        std::string_view kind) {
  const auto found = arrays.find(name.empty() ? usual : name);
  if (found != arrays.end()) return found->second;
  if (name.empty() && arrays.size() == 1) return arrays.begin()->second;
  const std::string fault = !name.empty()    ? fmt::format("has no point array \"{}\" of {}", name, kind)
                            : arrays.empty() ? fmt::format("has no point array of {}", kind)
                                             : fmt::format("has several point arrays of {}, name one", kind);
  throw Error(ErrorKind::kBadInput, fmt::format("{}; arrays there: {}", fault, list_of(arrays)));
}

}  // namespace

PointData io::read_text_point_data(const std::filesystem::path& path) {
  const std::string content = io::read_whole_file(path);
  const TextTable table = read_table(path, content);
  PointData data;
  if (table.names.empty()) return data;
  const io::PlaceColumns places = io::place_columns({table.names.begin(), table.names.end()});
  for (std::size_t i = 0; i < table.columns[0].size(); ++i) {
    data.points.emplace_back(table.columns[places[0]][i], table.columns[places[1]][i],
                             table.columns[places[2]][i]);
    if (!data.points.back().allFinite()) io::fail(path, fmt::format("point {} is not finite", i));
  }
  keep_columns(table, places, data);
  return data;
}

PointData read_point_data(const std::filesystem::path& path) {
  io::check_file(path);
  PointData data = io::format_of(path, FileUse::kPointData).code.read_point_data(path);
  if (data.points.empty()) io::fail(path, "holds no points");
  return data;
}

const std::vector<Vec3>& vectors_named(const PointData& data, const std::string& name,
                                       const std::string& usual) {
  return array_named(data.vectors, name, usual, "vectors");
}

const std::vector<double>& scalars_named(const PointData& data, const std::string& name) {
  return array_named(data.scalars, name, "", "numbers");
}

}  // namespace lumesh
