#include "face_ids.hpp"

#include <algorithm>
#include <set>
#include <string_view>

#include "lumesh/core/parse_number.hpp"

namespace lumesh::io {
namespace {

/// 0 if the name is no face_N with N > 0.
std::int32_t number_in(std::string_view name) {
  if (!name.starts_with(kNumberedFace)) return 0;
  name.remove_prefix(kNumberedFace.size());
  return name.starts_with('0') ? 0 : std::max(parse_number<std::int32_t>(name).value_or(0), 0);
}

}  // namespace

std::vector<std::int32_t> model_face_ids(std::span<const Patch> patches) {
  std::vector<std::int32_t> ids(patches.size(), 0);
  std::set<std::int32_t> taken;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const std::int32_t number = number_in(patches[p].name);
    if (number > 0 && taken.insert(number).second) ids[p] = number;
  }
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (ids[p] != 0) continue;
    ids[p] = static_cast<std::int32_t>(p) + 1;
    if (taken.contains(ids[p]))
      ids[p] = std::max(*taken.rbegin(), static_cast<std::int32_t>(patches.size())) + 1;
    taken.insert(ids[p]);
  }
  return ids;
}

}  // namespace lumesh::io
