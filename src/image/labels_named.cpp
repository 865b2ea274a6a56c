#include "lumesh/image/labels_named.hpp"

#include <algorithm>

#include "lumesh/core/error.hpp"

namespace lumesh {
namespace {

std::string first_labels(std::span<const Label> labels) {
  constexpr std::size_t kMax = 20;
  std::string list;
  for (std::size_t i = 0; i < std::min(kMax, labels.size()); ++i)
    list += (i > 0 ? ", " : "") + std::to_string(labels[i]);
  return labels.size() > kMax ? list + ", ..." : list;
}

}  // namespace

void require_labels(const std::string& option, const std::map<Label, double>& values,
                    std::span<const Label> present) {
  for (const auto& entry : values)
    if (!std::ranges::binary_search(present, entry.first))
      throw Error(ErrorKind::kBadInput, "has no label " + std::to_string(entry.first) + " to mesh, which " +
                                            option + " names; it has " + first_labels(present));
}

}  // namespace lumesh
