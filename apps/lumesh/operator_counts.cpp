#include "operator_counts.hpp"

namespace lumesh::cli {
namespace {

nlohmann::ordered_json count_json(const operators::OperatorCount& count) {
  return {{"applied", count.applied}, {"rejected", count.rejected}, {"contended", count.contended}};
}

}  // namespace

nlohmann::ordered_json counts_json(const operators::OperatorCounts& counts) {
  return {{"insertion", count_json(counts.insertion)},
          {"collapse", count_json(counts.collapse)},
          {"edge_removal", count_json(counts.edge_removal)},
          {"face_swap", count_json(counts.face_swap)},
          {"smoothing", count_json(counts.smoothing)}};
}

}  // namespace lumesh::cli
