#pragma once
/// @file Options for how fine a mesh shall be from place to place.

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "domain_input.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/delaunay/built_in_sizings.hpp"

namespace lumesh::cli {

struct SizingOptions {
  std::vector<std::string> label_sizes;  ///< LABEL=MM each.
  std::string plugin;                    ///< Path[:options].
  std::string points_path, image_path, mesh_path;
  PointSizeOptions points;
  BoundarySizeOptions boundary;  ///< Not wanted while the size there is 0.
};

/// --label-size, --size-points, --size-boundary, --size-image, --size-mesh, --sizing and what belongs to
/// them.
void add_sizing_options(CLI::App& command, SizingOptions& options);

/// What the options name, once its files are read.
class SizingInput {
 public:
  /// @throws Error that names option or file, before anything large is read.
  SizingInput(SizingOptions options, Context& context);

  /// The smallest of all sizes that are wanted; null if none are.
  /// @param read  Its domain has to live as long as the result. @param input  What it was read from.
  /// @throws Error{kBadInput} for a label that the domain has not.
  [[nodiscard]] std::unique_ptr<Sizing> on(const DomainRead& read, const DomainInput& input) &&;

 private:
  SizingOptions options_;
  std::map<Label, double> sizes_of_labels_;
  std::vector<Vec3> points_;
  std::vector<std::unique_ptr<Sizing>> parts_;
};

}  // namespace lumesh::cli
