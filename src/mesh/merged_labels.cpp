#include <algorithm>
#include <set>

#include "lumesh/mesh/parts.hpp"
#include "merged_names.hpp"

namespace lumesh::detail {
namespace {

std::string name_in(const std::map<Label, std::string>& names, Label label) {
  const auto found = names.find(label);
  return found == names.end() ? "" : found->second;
}

/// Takes the labels of one part after the other.
class LabelMerger {
 public:
  LabelMerger(EqualLabels equal_labels, Label highest) : equal_labels_(equal_labels), highest_(highest) {}

  void add(const MixedMesh& mesh) {
    const std::set<Label> present = labels_of(mesh);
    std::map<Label, Label>& numbers = merged_.numbers.emplace_back();
    std::set<Label> taken;  // By this part: its materials stay apart.
    const auto give = [&](Label label, Label number) {
      numbers[label] = number;
      taken.insert(number);
    };
    if (equal_labels_ == EqualLabels::kSame)
      for (const Label label : present) give(label, label);
    // Names first: they say what a label is.
    for (const Label label : present)
      if (numbers.contains(label))
        continue;
      else if (const Label same = number_named(name_in(mesh.info.label_names, label)); same != kBackground)
        if (!taken.contains(same)) give(label, same);
    for (const Label label : present) {
      if (numbers.contains(label)) continue;
      const std::string name = name_in(mesh.info.label_names, label);
      give(label, taken.contains(label) || !may_stay(label, name) ? ++highest_ : label);
    }
    for (const auto& [label, number] : numbers) note(label, number, name_in(mesh.info.label_names, label));
  }
  [[nodiscard]] MergedLabels take() { return std::move(merged_); }

 private:
  /// The number of a name in the parts so far; kBackground if there is none or names do not count.
  [[nodiscard]] Label number_named(const std::string& name) const {
    if (name.empty() || equal_labels_ != EqualLabels::kByName) return kBackground;
    const auto found =
        std::ranges::find_if(merged_.names, [&](const auto& entry) { return entry.second == name; });
    return found == merged_.names.end() ? kBackground : found->first;
  }
  [[nodiscard]] bool may_stay(Label label, const std::string& name) const {
    if (!known_.contains(label)) return true;
    if (equal_labels_ == EqualLabels::kApart) return false;
    return name.empty() || name_in(merged_.names, label).empty();
  }
  void note(Label label, Label number, const std::string& name) {
    known_.insert(number);
    if (!name.empty()) merged_.names.try_emplace(number, name);
    if (label != number) merged_.renumbered.push_back({merged_.numbers.size() - 1, label, number, name});
  }

  EqualLabels equal_labels_;
  Label highest_;
  std::set<Label> known_;
  MergedLabels merged_;
};

}  // namespace

MergedLabels merge_labels(std::span<const MergePart> parts, EqualLabels equal_labels) {
  Label highest = 0;
  for (const MergePart& part : parts)
    for (const Label label : labels_of(*part.mesh)) highest = std::max(highest, label);
  LabelMerger merger(equal_labels, highest);
  for (const MergePart& part : parts) merger.add(*part.mesh);
  return merger.take();
}

}  // namespace lumesh::detail
