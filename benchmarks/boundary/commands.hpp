#pragma once
/// @file The parts of this benchmark, each of which prints a table and writes one line of JSON per image.

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

namespace lumesh::boundary {

struct RunOptions {
  std::string only = {};       ///< Regular expression that part of a case's name has to match; empty: all.
  std::string json_path = {};  ///< Empty: none.
  int seeds = 5;               ///< Random places for each shape.
  int first_seed = 1;
};

/// Lines of JSON, written as they come; to nowhere without a path.
class JsonLines {
 public:
  /// @throws Error{kBadInput} if the file cannot be opened.
  explicit JsonLines(const std::string& path);
  void write(const nlohmann::ordered_json& line);

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Closer> file_;
};

[[nodiscard]] bool matches(const std::string& name, const RunOptions& options);

/// Root mean square or mean of the figures of one case over its seeds; those that are NaN are left out.
class Summary {
 public:
  void add(double value);
  [[nodiscard]] double root_mean_square() const;
  [[nodiscard]] double mean() const;

 private:
  double sum_ = 0, squares_ = 0;
  int count_ = 0;
};

void run_field(const RunOptions& options);
void run_mesh(const RunOptions& options);
/// Sections at the border of vessels that others face, and how far places are from voxels of their label.
void run_openings(const RunOptions& options);
/// Topology of meshes of random label images; `only` picks meshers.
void run_topology(const RunOptions& options);
/// Time and memory of the field alone, from 0.1 to 10 million voxels in the band; reads only `json_path`.
void run_cost(const RunOptions& options);

}  // namespace lumesh::boundary
