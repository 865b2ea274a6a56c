#pragma once
/// @file What stages left, kept on disk with a key of all that it depends on.

#include <filesystem>
#include <string>

#include "case_state.hpp"

namespace lumesh::pipeline {

class Checkpoints {
 public:
  /// @param folder  Made where something is to be kept; empty: nothing is.
  Checkpoints(std::filesystem::path folder, bool resumes) : folder_(std::move(folder)), resumes_(resumes) {}

  /// Whether what `stage` left is there under this key, as far as it is to be used.
  [[nodiscard]] bool has(const std::string& stage, const std::string& key) const;

  void keep_centerline(const CaseState& state, const std::string& key) const;
  void keep_mesh(const std::string& stage, const CaseState& state, const std::string& key) const;
  /// @throws Error{kBadInput} if the file is broken.
  void load_centerline(CaseState& state) const;
  void load_mesh(const std::string& stage, CaseState& state) const;
  /// What the user was warned of, which holds for whoever takes the checkpoint.
  void keep_warnings(const std::string& stage, const std::vector<std::string>& warnings) const;
  [[nodiscard]] std::vector<std::string> load_warnings(const std::string& stage) const;

 private:
  [[nodiscard]] std::filesystem::path file_of(const std::string& stage) const;
  void write_key(const std::string& stage, const std::string& key) const;

  std::filesystem::path folder_;
  bool resumes_;
};

/// Keys of all stages, by name: equal keys stand for equal results.
[[nodiscard]] std::map<std::string, std::string> stage_keys(const CaseState& state);

}  // namespace lumesh::pipeline
