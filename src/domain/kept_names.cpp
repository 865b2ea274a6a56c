#include "lumesh/domain/kept_names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <tuple>
#include <utility>

#include "lumesh/core/place_text.hpp"
#include "lumesh/mesh/patch_list.hpp"
#include "lumesh/mesh/patch_naming.hpp"

namespace lumesh {
namespace {

constexpr std::size_t kNoOpening = ~std::size_t{0};

struct OpeningPair {
  double off_mm;
  std::size_t known, found;
  auto operator<=>(const OpeningPair&) const = default;
};

/// For each opening that is found the known one at its place, or kNoOpening.
std::vector<std::size_t> known_at_places(const std::vector<Opening>& known,
                                         const std::vector<Opening>& found) {
  constexpr double kLikeNormal = 0.9;  // Cosine.
  std::vector<OpeningPair> pairs;
  for (std::size_t k = 0; k < known.size(); ++k)
    for (std::size_t f = 0; f < found.size(); ++f) {
      const Opening &before = known[k], &now = found[f];
      if (before.label != now.label || before.is_rim != now.is_rim) continue;
      if (before.normal.dot(now.normal) < kLikeNormal) continue;
      const double off_mm = (before.centre_mm - now.centre_mm).norm();
      if (off_mm <= before.radius_mm() + now.radius_mm()) pairs.push_back({off_mm, k, f});
    }
  std::ranges::sort(pairs);
  std::vector<std::size_t> of_found(found.size(), kNoOpening);
  std::vector<bool> is_taken(known.size(), false);
  for (const auto& [off_mm, k, f] : pairs) {
    if (is_taken[k] || of_found[f] != kNoOpening) continue;
    of_found[f] = k;
    is_taken[k] = true;
  }
  return of_found;
}

/// The first name of its kind that no opening has; an inlet is of the first frame.
std::string free_name(const Opening& opening, const PatchNaming& naming, const std::vector<Opening>& known) {
  std::set<std::string> names;
  for (const Opening& o : known) names.insert(o.name);
  const std::string label = "_" + naming.label(opening.label);
  const std::string suffix = opening.name.ends_with(label) ? label : "";
  for (std::size_t number = opening.is_rim ? 0 : 1;; ++number) {
    std::string name = (opening.is_rim ? wall_rim_name(number) : opening_name(number)) + suffix;
    if (!names.contains(name)) return name;
  }
}

/// Sets the names of a domain's openings, which are by falling area.
void set_names(const std::vector<Opening>& openings, ImageDomain& domain) {
  for (std::size_t cut = 0; cut < domain.cut_planes().size(); ++cut) {
    const CutPlane& plane = domain.cut_planes()[cut];
    std::vector<std::pair<Label, std::string>> names;
    for (const Opening& o : openings) {
      const bool is_within = !plane.is_bounded() || (o.centre_mm - plane.point_mm).norm() <= plane.radius_mm;
      constexpr double kSameNormal = 1 - 1e-12;
      if (is_within && o.normal.dot(plane.normal) > kSameNormal &&
          std::abs(plane.height(o.centre_mm)) < 1e-6 * domain.resolution_mm())
        names.emplace_back(o.label, o.name);
    }
    domain.name_openings(cut, std::move(names));
  }
}

}  // namespace

std::vector<std::string> keep_opening_names(std::vector<Opening>& known, ImageDomain& domain) {
  std::vector<Opening> found = find_openings(domain);
  const bool is_first = known.empty();
  const PatchNaming naming(domain.label_names());
  const std::vector<std::size_t> of_found = known_at_places(known, found);
  std::vector<std::string> notes;
  for (std::size_t k = 0; k < known.size(); ++k)
    if (std::ranges::find(of_found, k) == of_found.end())
      notes.push_back(fmt::format("{} at {}, which frames before have, is no opening of this one",
                                  known[k].name, place_text(known[k].centre_mm)));
  for (std::size_t f = 0; f < found.size(); ++f) {
    if (of_found[f] != kNoOpening) {
      found[f].name = known[of_found[f]].name;
      continue;
    }
    if (!is_first) {
      found[f].name = free_name(found[f], naming, known);
      notes.push_back(fmt::format("{} at {} is an opening that no frame before has", found[f].name,
                                  place_text(found[f].centre_mm)));
    }
    known.push_back(found[f]);
    known.back().squares = nullptr;
  }
  if (!is_first) set_names(found, domain);
  return notes;
}

}  // namespace lumesh
