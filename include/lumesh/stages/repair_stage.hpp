#pragma once
/// @file The stage `repair`: a surface with faults made one that can be meshed, and what was done to it.

#include <cstdint>
#include <string>

#include "lumesh/core/context.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/surface/reports.hpp"

namespace lumesh {

class OptionList;

enum class RepairMethod : std::uint8_t {
  kAuto,     ///< Local, and rebuilt where that fails.
  kLocal,    ///< repair_locally().
  kRebuild,  ///< Anew, from winding numbers on a grid.
};

/// A length in mm, or a share of the surface's diagonal.
struct ShareOrLength {
  double number = 1;
  bool is_percent = true;

  /// @throws Error{kUsage} unless it is greater than 0 and finite; the message does not name the option.
  void validate() const;
};

struct RepairRequest {
  RepairMethod method = RepairMethod::kAuto;
  ShareOrLength max_distance;

  bool in_single_precision = false;  ///< Whether it goes into a file that rounds, .stl; no option.

  void describe(OptionList& list);
  /// @throws Error{kUsage} that names the option.
  void validate() const;
  [[nodiscard]] double max_distance_mm(double diagonal_mm) const;
};

struct RepairOutcome {
  MixedMesh surface;          ///< In mm (LPS), with the patches of the given one.
  bool was_rebuilt = false;   ///< Else repaired locally.
  std::string local_failure;  ///< Why local repair was not enough; empty where it was, or was not tried.
  surfaces::RepairReport
      report;  ///< Of the local repair; of a rebuilt surface components, genus and moved_mm count.
  std::uint64_t given_components = 0;
  double max_distance_mm = 0;
  double spacing_mm = 0;  ///< Spacing of the grid of a rebuilt surface.
};

/// Repairs a surface of triangles. The result has no fault that `check` finds (surfaces::findings_of()).
/// @throws Error{kNotReached} with the place if that cannot be had within the distance, Error{kBadInput}.
[[nodiscard]] RepairOutcome repair_surface(const MixedMesh& surface, const RepairRequest& request,
                                           Context& context);
/// The same of a file, which errors name; warns of a unit that is in doubt. The provenance is the file's.
[[nodiscard]] RepairOutcome repair_file(const std::string& path, const RepairRequest& request,
                                        Context& context);

}  // namespace lumesh
