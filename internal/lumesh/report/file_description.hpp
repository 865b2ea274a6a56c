#pragma once
/// @file What an image or a mesh holds, for `info`: docs/stages/info.md describes the fields.

#include <string>

#include "lumesh/core/context.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh::report {

struct DescriptionRequest {
  std::string path;
  ImageSelection selection;
  InputCuts cuts;
};

struct FileDescription {
  std::string json;
  std::string text;  ///< The description as lines.
};

/// Reads a file and describes it. Warns of what is left out, such as openings of noise.
/// @throws Error{kBadInput} that names the file.
[[nodiscard]] FileDescription describe_file(const DescriptionRequest& request, Context& context);

}  // namespace lumesh::report
