#include "lumesh/core/nearest_word.hpp"

#include <algorithm>
#include <numeric>

namespace lumesh {
namespace {

/// Insertions, deletions and exchanges that lead from one word to the other (Levenshtein 1966).
std::size_t edit_distance(const std::string& from, const std::string& to) {
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::size_t exchanged = diagonal + (from[i] == to[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({exchanged, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string nearest_word(const std::string& wrong, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, wrong.size() / 2);  // More is another word.
  for (const std::string& word : known) {
    const bool begins = wrong.size() > 1 && word.starts_with(wrong);
    const std::size_t distance = begins ? 0 : edit_distance(wrong, word);
    if (distance > least || (distance == least && !nearest.empty())) continue;
    nearest = word;
    least = distance;
  }
  return nearest;
}

}  // namespace lumesh
