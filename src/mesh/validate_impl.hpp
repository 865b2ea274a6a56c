#pragma once
/// @file What the parts of validate() share.

#include <algorithm>
#include <string>
#include <vector>

#include "lumesh/mesh/validate.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::detail {

/// Problems of one block of elements: all counted, the first ones kept.
struct Findings {
  std::vector<std::string> first;
  std::size_t count = 0;

  void add(std::string problem) {
    if (first.size() < ValidationReport::kMaxListed) first.push_back(std::move(problem));
    ++count;
  }
};

inline void merge(ValidationReport& report, const Findings& findings) {
  for (const std::string& problem : findings.first)
    if (report.problems.size() < ValidationReport::kMaxListed) report.problems.push_back(problem);
  report.problem_count += findings.count;
}

/// Runs check(i, findings, scratch) for i in [0, count) in parallel; `scratch` is a Scratch kept for a block.
template <class Scratch, class Check>
void check_each(ValidationReport& report, std::size_t count, const Check& check) {
  constexpr std::size_t kBlock = 8192;
  merge(report, parallel::reduce_blocks(
                    count, kBlock, Findings(),
                    [&](std::size_t begin, std::size_t end) {
                      Findings findings;
                      Scratch scratch;
                      for (std::size_t i = begin; i < end; ++i) check(i, findings, scratch);
                      return findings;
                    },
                    [](Findings a, const Findings& b) {
                      for (const std::string& problem : b.first)
                        if (a.first.size() < ValidationReport::kMaxListed) a.first.push_back(problem);
                      a.count += b.count;
                      return a;
                    }));
}

struct NoScratch {};

/// Surfaces, topology and volumes of the labels. Needs sound vertices and adjacency.
void check_label_surfaces(const TetMesh& mesh, ValidationReport& report);

}  // namespace lumesh::detail
