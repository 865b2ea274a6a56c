#include <fmt/core.h>

#include "case_keys.hpp"

namespace lumesh {
namespace pipeline {
namespace {

/// As TOML wants it. Single quotes hold anything but themselves and line ends.
std::string toml_text(const std::string& text) {
  if (text.find_first_of("'\n\r\t") == std::string::npos) return "'" + text + "'";
  std::string escaped;
  for (const char c : text) {
    if (c == '"' || c == '\\') escaped += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      escaped += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      escaped += c;
  }
  return '"' + escaped + '"';
}

/// The shortest text that reads as the same number.
std::string number(double value) {
  return fmt::format("{}", value);
}

template <class Items, class Text>
std::string list_of(const Items& items, const Text& text) {
  std::string list;
  for (const auto& item : items) list += (list.empty() ? "" : ", ") + text(item);
  return "[" + list + "]";
}

/// Empty for what has no value.
struct ValueText {
  std::string operator()(const bool* v) const { return *v ? "true" : "false"; }
  std::string operator()(const int* v) const { return std::to_string(*v); }
  std::string operator()(const std::size_t* v) const { return std::to_string(*v); }
  std::string operator()(const double* v) const { return number(*v); }
  std::string operator()(const std::optional<double>* v) const { return *v ? number(**v) : ""; }
  std::string operator()(const std::string* v) const { return toml_text(*v); }
  std::string operator()(const std::vector<int>* v) const {
    return list_of(*v, [](int i) { return std::to_string(i); });
  }
  std::string operator()(const std::vector<std::string>* v) const { return list_of(*v, toml_text); }
  std::string operator()(const std::vector<CutPlane>* v) const {
    return list_of(*v, [](const CutPlane& plane) {
      const Vec3 &p = plane.point_mm, &n = plane.normal;
      return list_of(std::array{p[0], p[1], p[2], n[0], n[1], n[2]}, number);
    });
  }
  std::string operator()(const std::vector<Vec3>* v) const {
    return list_of(*v, [](const Vec3& p) { return list_of(std::array{p[0], p[1], p[2]}, number); });
  }
  std::string operator()(const Index3* v) const {
    return fmt::format("[{}, {}, {}]", (*v)[0], (*v)[1], (*v)[2]);
  }
  std::string operator()(const Vec3* v) const {
    return list_of(std::array{(*v)[0], (*v)[1], (*v)[2]}, number);
  }
  std::string operator()(const Choice& choice) const { return toml_text(choice.words[choice.get()]); }
  std::string operator()(const FilePath& file) const { return toml_text(*file.path); }
};

}  // namespace

std::string section_text(const Case& wanted, const std::string& section) {
  Case c = wanted;
  std::string text;
  for (const Key& key : keys_of(c)) {
    if (key.section != section) continue;
    const std::string value = std::visit(ValueText{}, key.target);
    const std::string line =
        value.empty() ? fmt::format("# {} =", key.name) : fmt::format("{} = {}", key.name, value);
    text += fmt::format("{:<32} # {}\n", line, key.meaning);
  }
  return text;
}

}  // namespace pipeline

std::string case_text(const Case& wanted) {
  Case c = wanted;
  std::string text = pipeline::section_text(wanted, "");
  std::string section;
  for (const pipeline::Key& key : pipeline::keys_of(c)) {
    if (key.section == section) continue;
    section = key.section;
    text += fmt::format("\n[{}]  # {}\n{}", section, pipeline::section_meaning(section),
                        pipeline::section_text(wanted, section));
  }
  return text;
}

}  // namespace lumesh
