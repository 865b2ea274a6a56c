#include "case_stage.hpp"

#include <array>

namespace lumesh::pipeline {

const CaseStageNames& names_of(CaseStage stage) {
  static constexpr std::array<CaseStageNames, 6> kNames = {{{"input", "Input", "input"},
                                                            {"centerline", "Centerline", "centerline"},
                                                            {"mesh", "First mesh", nullptr},
                                                            {"metric", "Metric", "metric"},
                                                            {"adapted", "Adapted mesh", "adapt"},
                                                            {"layers", "Boundary layers", "layers"}}};
  return kNames[static_cast<std::size_t>(stage)];
}

const char* section_of(Mesher mesher) {
  return mesher == Mesher::kLattice ? "lattice" : "delaunay";
}

std::vector<std::string> sections_of(CaseStage stage, Mesher mesher) {
  const char* const own = names_of(stage).section;
  return {own != nullptr ? own : section_of(mesher), "input"};
}

}  // namespace lumesh::pipeline
