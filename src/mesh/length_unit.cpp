#include "lumesh/mesh/length_unit.hpp"

#include <array>

namespace lumesh {

double unit_in_mm(std::string_view unit) {
  return unit == "mm"   ? 1
         : unit == "cm" ? 10
         : unit == "m"  ? 1000
         : unit == "um" ? 0.001
         : unit == "in" ? 25.4
                        : 0;
}

std::string unit_called(std::string_view word) {
  struct Name {
    std::string_view word, unit;
  };
  static constexpr std::array<Name, 11> kNames = {{{"millimeter", "mm"},
                                                   {"millimetre", "mm"},
                                                   {"centimeter", "cm"},
                                                   {"centimetre", "cm"},
                                                   {"meter", "m"},
                                                   {"metre", "m"},
                                                   {"micrometer", "um"},
                                                   {"micrometre", "um"},
                                                   {"micron", "um"},
                                                   {"inch", "in"},
                                                   {"inche", "in"}}};
  std::string_view one = word;
  if (one.size() > 1 && one.ends_with('s')) one.remove_suffix(1);
  for (const Name& name : kNames)
    if (name.word == one) return std::string(name.unit);
  return std::string(word);
}

std::vector<std::pair<std::string, std::string>> length_units(bool has_file) {
  std::vector<std::pair<std::string, std::string>> words = {
      {"mm", "mm"}, {"cm", "cm"}, {"m", "m"}, {"um", "um"}, {"in", "in"}};
  if (has_file) words.insert(words.begin(), {"file", ""});
  return words;
}

MeshInUnit::MeshInUnit(const MeshView& mesh, const std::string& unit) : view_(mesh) {
  const double from_mm = unit_in_mm(mesh.info->unit), to_mm = unit_in_mm(unit);
  if (from_mm == to_mm || from_mm == 0 || to_mm == 0) return;
  info_ = *mesh.info;
  info_.unit = unit;
  view_.info = &info_;
  points_.assign(mesh.points.begin(), mesh.points.end());
  for (Vec3& p : points_) p = p * from_mm / to_mm;
  view_.points = points_;
  metric_.assign(mesh.metric.begin(), mesh.metric.end());
  const double f = to_mm / from_mm * (to_mm / from_mm);
  for (SymTensor& m : metric_) m = {m.xx * f, m.xy * f, m.xz * f, m.yy * f, m.yz * f, m.zz * f};
  view_.metric = metric_;
}

}  // namespace lumesh
