#include "face_ids.hpp"

#include <algorithm>
#include <set>

#include "lumesh/mesh/face_numbers.hpp"

namespace lumesh::io {

std::vector<std::int32_t> model_face_ids(const MeshInfo& info) {
  const std::vector<Patch>& patches = info.patches;
  std::vector<std::int32_t> ids(patches.size(), 0);
  std::set<std::int32_t> taken;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const std::int32_t number = face_number_of(patches[p], info);
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
