#include "commands.hpp"

#include <cmath>
#include <limits>
#include <regex>

#include "lumesh/core/error.hpp"

namespace lumesh::boundary {

JsonLines::JsonLines(const std::string& path) {
  if (path.empty()) return;
  file_.reset(std::fopen(path.c_str(), "w"));
  if (!file_) throw Error(ErrorKind::kBadInput, path + ": cannot be written");
}

void JsonLines::write(const nlohmann::ordered_json& line) {
  if (!file_) return;
  std::fputs((line.dump() + "\n").c_str(), file_.get());
  std::fflush(file_.get());
}

bool matches(const std::string& name, const RunOptions& options) {
  return options.only.empty() || std::regex_search(name, std::regex(options.only));
}

void Summary::add(double value) {
  if (std::isnan(value)) return;
  sum_ += value;
  squares_ += value * value;
  ++count_;
}

double Summary::root_mean_square() const {
  return count_ == 0 ? std::numeric_limits<double>::quiet_NaN() : std::sqrt(squares_ / count_);
}

double Summary::mean() const {
  return count_ == 0 ? std::numeric_limits<double>::quiet_NaN() : sum_ / count_;
}

}  // namespace lumesh::boundary
