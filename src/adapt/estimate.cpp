#include "lumesh/adapt/estimate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "lumesh/core/error.hpp"
#include "lumesh/core/memory.hpp"
#include "lumesh/mesh/tet_mesh.hpp"

namespace lumesh {

void check_fits_memory(double complexity) {
  if (!std::isfinite(complexity))
    throw Error(ErrorKind::kBadInput,
                "the metric's complexity is not a finite number; its sizes are too small or vary too wildly");
  const double tets = kTetsPerComplexity * complexity;
  const double available = static_cast<double>(available_memory_bytes());
  if (tets < TetMesh::kMaxTets && tets * kBytesPerAdaptedTet < available) return;
  const double max_tets = std::min<double>(available / kBytesPerAdaptedTet, TetMesh::kMaxTets);
  throw Error(ErrorKind::kMemory,
              fmt::format("the metric asks for about {:.2g} tetrahedra ({:.2g} GB; {:.2g} GB are free); a "
                          "complexity of {:.1g} would fit",
                          tets, tets * kBytesPerAdaptedTet / 1e9, available / 1e9,
                          0.5 * max_tets / kTetsPerComplexity));
}

}  // namespace lumesh
