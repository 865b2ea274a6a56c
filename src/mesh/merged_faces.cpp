#include <algorithm>
#include <set>
#include <utility>

#include "lumesh/mesh/patch_list.hpp"
#include "merged_names.hpp"

namespace lumesh::detail {
namespace {

constexpr std::uint32_t kNoContact = ~0U;

/// A patch of a part.
struct PatchUse {
  std::size_t faces = 0, contacts = 0;
  std::set<std::array<Label, 2>> pairs;      ///< Of labels, at the contacts.
  std::uint32_t first_contact = kNoContact;  ///< Any of them.

  [[nodiscard]] bool is_all_contacts() const { return faces > 0 && faces == contacts; }
};

std::array<Label, 2> pair_of(const Contact& contact) {
  return {std::min(contact.labels[0], contact.labels[1]), std::max(contact.labels[0], contact.labels[1])};
}

/// Collects the faces of all parts.
class FaceMerger {
 public:
  FaceMerger(std::span<const MergePart> parts, const MergedLabels& labels, const JoinedPoints& joined,
             std::span<const Contact> contacts, MixedMesh& mesh)
      : parts_(parts),
        labels_(labels),
        joined_(joined),
        contacts_(contacts),
        mesh_(mesh),
        patches_at_(contacts.size(), {-1, -1}),
        is_placed_(contacts.size(), 0) {}

  void run() {
    for (std::size_t p = 0; p < parts_.size(); ++p) look_at(p);
    for (std::size_t p = 0; p < parts_.size(); ++p) number_patches(p);
    for (std::size_t p = 0; p < parts_.size(); ++p) add_faces(p);
    for (std::uint32_t c = 0; c < contacts_.size(); ++c) add_contact(c);
  }

 private:
  template <class Visit>
  void for_each_face(std::size_t part, const Visit& visit) const {
    const MixedMesh& mesh = *parts_[part].mesh;
    const std::vector<std::uint32_t>& numbers = joined_.numbers[part];
    for_each_patch_face(mesh, [&](const auto& corners, std::int32_t patch) {
      FaceCorners face = face_of(corners);
      for (std::uint32_t& v : face) v = numbers[v];
      visit(face, patch);
    });
  }
  [[nodiscard]] std::uint32_t contact_at(const FaceCorners& face) const {
    const Contact* found = find_contact(contacts_, face);
    return found == nullptr ? kNoContact : static_cast<std::uint32_t>(found - contacts_.data());
  }

  /// Counts the uses of a part's patches.
  void look_at(std::size_t part) {
    std::vector<PatchUse>& uses = uses_.emplace_back(parts_[part].mesh->info.patches.size());
    for_each_face(part, [&](const FaceCorners& face, std::int32_t patch) {
      if (patch < 0 || static_cast<std::size_t>(patch) >= uses.size()) return;
      PatchUse& use = uses[static_cast<std::size_t>(patch)];
      ++use.faces;
      const std::uint32_t c = contact_at(face);
      if (c == kNoContact) return;
      ++use.contacts;
      use.pairs.insert(pair_of(contacts_[c]));
      use.first_contact = std::min(use.first_contact, c);
      patches_at_[c][contacts_[c].parts[0] == part ? 0 : 1] = patch;
    });
  }

  /// The name that the first part with a whole patch here gives it, unless another patch keeps that; else
  /// that of the labels.
  [[nodiscard]] std::string interface_name(std::uint32_t c) const {
    const auto [low, high] = pair_of(contacts_[c]);
    for (std::size_t side = 0; side < 2; ++side) {
      const std::int32_t patch = patches_at_[c][side];
      if (patch < 0) continue;
      const std::uint32_t part = contacts_[c].parts[side];
      const PatchUse& use = uses_[part][static_cast<std::size_t>(patch)];
      if (!use.is_all_contacts()) continue;
      const std::string& name = parts_[part].mesh->info.patches[static_cast<std::size_t>(patch)].name;
      if (side > 0 && remains_outside(name)) continue;
      return use.pairs.size() == 1 ? name : name + "_" + std::to_string(low) + "_" + std::to_string(high);
    }
    return name_between(low, high);
  }
  /// Whether faces of a patch of this name stay on the outside or between labels of a part.
  [[nodiscard]] bool remains_outside(const std::string& name) const {
    for (std::size_t p = 0; p < parts_.size(); ++p)
      for (std::size_t q = 0; q < uses_[p].size(); ++q)
        if (!uses_[p][q].is_all_contacts() && parts_[p].mesh->info.patches[q].name == name) return true;
    return false;
  }
  std::int32_t interface_patch(std::uint32_t c) {
    return patch_for({interface_name(c), PatchKind::kInterface, pair_of(contacts_[c])});
  }
  [[nodiscard]] bool is_within_one_label(std::uint32_t c) const {
    return contacts_[c].labels[0] == contacts_[c].labels[1];
  }

  /// Gives every patch of a part a number, in the part's order; those without faces left have none.
  void number_patches(std::size_t part) {
    std::vector<std::int32_t>& numbers = numbers_.emplace_back(uses_[part].size(), -1);
    for (std::size_t q = 0; q < numbers.size(); ++q) {
      const PatchUse& use = uses_[part][q];
      Patch patch = parts_[part].mesh->info.patches[q];
      for (Label& label : patch.labels) label = merged_label(part, label);
      if (!use.is_all_contacts())
        numbers[q] = patch_for(patch);
      else if (!is_within_one_label(use.first_contact))
        numbers[q] = interface_patch(use.first_contact);
    }
  }
  [[nodiscard]] Label merged_label(std::size_t part, Label label) const {
    const auto found = labels_.numbers[part].find(label);
    return found == labels_.numbers[part].end() ? label : found->second;
  }
  /// Patches of one name and kind are one; those of another kind get a name of their own.
  std::int32_t patch_for(const Patch& wanted) {
    std::vector<Patch>& patches = mesh_.info.patches;
    const auto [place, is_new] =
        by_name_.try_emplace({wanted.name, wanted.kind}, static_cast<std::int32_t>(patches.size()));
    if (is_new)
      patches.push_back({free_patch_name(patches, wanted.name), wanted.kind, wanted.labels, wanted.flow});
    return place->second;
  }

  void add_faces(std::size_t part) {
    const std::vector<std::int32_t>& numbers = numbers_[part];
    for_each_face(part, [&](const FaceCorners& face, std::int32_t patch) {
      if (const std::uint32_t c = contact_at(face); c != kNoContact) return add_contact(c);
      const bool known = patch >= 0 && static_cast<std::size_t>(patch) < numbers.size();
      append_face(face, known ? numbers[static_cast<std::size_t>(patch)] : patch, mesh_);
    });
  }
  /// Once, out of the cell of the lower label.
  void add_contact(std::uint32_t c) {
    if (is_placed_[c] != 0 || is_within_one_label(c)) return;
    is_placed_[c] = 1;
    const Contact& contact = contacts_[c];
    append_face(contact.outward[contact.labels[0] < contact.labels[1] ? 0 : 1], interface_patch(c), mesh_);
  }

  std::span<const MergePart> parts_;
  const MergedLabels& labels_;
  const JoinedPoints& joined_;
  std::span<const Contact> contacts_;
  MixedMesh& mesh_;
  std::vector<std::vector<PatchUse>> uses_;              // Of each part's patches.
  std::vector<std::vector<std::int32_t>> numbers_;       // Of each part's patches, in the merged mesh.
  std::vector<std::array<std::int32_t, 2>> patches_at_;  // Of each contact, by the parts' numbers; -1: none.
  std::map<std::pair<std::string, PatchKind>, std::int32_t> by_name_;  // Of patches, as they were wanted.
  std::vector<std::uint8_t> is_placed_;                                // Of each contact.
};

}  // namespace

void merge_faces(std::span<const MergePart> parts, const MergedLabels& labels, const JoinedPoints& joined,
                 std::span<const Contact> contacts, MixedMesh& mesh) {
  FaceMerger(parts, labels, joined, contacts, mesh).run();
}

}  // namespace lumesh::detail
