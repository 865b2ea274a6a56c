#include "lumesh/stages/opening_request.hpp"

#include <fmt/core.h>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/domain/walls_in_planes.hpp"
#include "rim_vertices.hpp"

namespace lumesh {

std::vector<PatchRenaming> OpeningRequest::renamings(std::span<const Opening> openings,
                                                     std::span<const Opening> beginnings) const {
  if (names.empty()) return {};
  return with_patches(renamings_from(names), named_openings(openings), named_openings(beginnings));
}

void OpeningRequest::require(const std::string& path, const OpeningsCompared& openings,
                             const std::vector<std::string>& without_name) const {
  if (!without_name.empty()) throw Error(ErrorKind::kNotReached, path + ": " + without_name.front());
  if (!is_strict) return;
  if (openings.openings.empty())
    throw Error(ErrorKind::kNotReached, fmt::format("{}: has no opening; {} makes one (lumesh info lists "
                                                    "where vessels end)",
                                                    path, option_name("cut_at")));
  const std::vector<std::string> faults = faults_of(openings);
  if (!faults.empty())
    throw Error(
        ErrorKind::kNotReached,
        fmt::format("{}: {}{}", path, faults.front(),
                    faults.size() > 1 ? fmt::format("; {} openings are wrong in all", faults.size()) : ""));
}

OpeningsCompared checked_openings(const MeshView& mesh, const Domain& domain,
                                  std::span<const Opening> openings, Context& context) {
  if (domain.cut_planes().empty() && domain.flat_ends().empty()) return {};
  OpeningsCompared compared = context.phase("openings", [&] { return compare_openings(mesh, openings); });
  for (const std::string& doubt : doubts_about(compared)) context.warn(doubt);
  for (const std::string& doubt : doubts_about(walls_in_planes(mesh, domain))) context.warn(doubt);
  for (const std::string& note : notes_on_rims(mesh, domain)) context.warn(note);
  return compared;
}

}  // namespace lumesh
