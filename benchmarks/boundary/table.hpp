#pragma once
/// @file Figures beside their references, in one line of a table.

#include <string>

namespace lumesh::boundary {

/// "-" for NaN.
[[nodiscard]] std::string number(double value, int digits);

/// Counts the figures that have a reference, and those within its bounds.
class Tally {
 public:
  /// "figure/reference"; good within 1.2 times the reference and the slack.
  std::string judge(const char* name, double figure, double reference, int digits, double slack);
  /// "figure/bound"; good up to the bound.
  std::string judge_bound(const char* name, double figure, double bound, int digits);
  /// "ok", what is worse, or "-" if nothing has a reference.
  [[nodiscard]] std::string verdict() const;
  [[nodiscard]] int compared() const { return compared_; }
  [[nodiscard]] int good() const { return good_; }

 private:
  int compared_ = 0, good_ = 0;
  std::string worse_;
};

}  // namespace lumesh::boundary
