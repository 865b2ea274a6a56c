#include "table.hpp"

#include <fmt/core.h>

#include <cmath>

#include "references.hpp"

namespace lumesh::boundary {

std::string number(double value, int digits) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits);
}

std::string Tally::judge(const char* name, double figure, double reference, int digits, double slack) {
  const Verdict verdict = compare(figure, reference, slack);
  if (verdict != Verdict::kNoReference) ++compared_;
  if (verdict == Verdict::kGood) ++good_;
  if (verdict == Verdict::kWorse) worse_ += std::string(worse_.empty() ? "" : " ") + name;
  return number(figure, digits) + "/" + number(reference, digits);
}

std::string Tally::judge_bound(const char* name, double figure, double bound, int digits) {
  ++compared_;
  if (figure <= bound)
    ++good_;
  else
    worse_ += std::string(worse_.empty() ? "" : " ") + name;
  return number(figure, digits) + "/" + number(bound, digits);
}

std::string Tally::verdict() const {
  if (compared_ == 0) return "-";
  return worse_.empty() ? "ok" : "WORSE: " + worse_;
}

}  // namespace lumesh::boundary
