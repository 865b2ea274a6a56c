#pragma once
/// @file What meshes are measured against, for every front end.

#include <span>
#include <string>
#include <vector>

#include "lumesh/core/context.hpp"
#include "lumesh/image/phantom.hpp"
#include "lumesh/mesh/mixed_mesh.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/quality/evaluation.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {

/// The image that a mesh is measured against, with what is known of it. What does not suit a measurement is
/// left out: axes without an image or lines, and the truth about a whole object of which parts are cut off.
/// @param image, domain, phantom  Null: none. @param cuts  Of the image.
/// @param planes  That cut it. @param axes  Of its vessels.
[[nodiscard]] quality::EvaluationInput evaluation_input(const LabelImage* image, const ImageDomain* domain,
                                                        const Phantom* phantom, const InputCuts& cuts,
                                                        std::span<const CutPlane> planes,
                                                        const Polylines& axes);

/// Files that a mesh of a file is measured against.
struct EvaluationRequest {
  std::string image;                          ///< The image that the mesh was made from; empty: none.
  ImageSelection selection;                   ///< Voxels of that image that count.
  InputCuts cuts;                             ///< Cuts of that image.
  std::string centerline;                     ///< Axes of its vessels, or "none"; empty: found in the image.
  std::string reference;                      ///< Parameters of the phantom behind the image; empty: none.
  std::vector<double> required_dihedral_deg;  ///< Least and greatest that are good enough; empty: any.

  /// @throws Error{kUsage} that names the option.
  void validate() const;
  /// @param name  Of the mesh. @throws Error{kNotReached} if it is invalid, or its angles are not good
  /// enough.
  void require_met(const std::string& name, const quality::Evaluation& evaluation) const;
};

/// Measures a mesh, as quality::evaluate(). Its warnings begin with those of an image that hardly is the
/// mesh's, which are also warned of.
/// @param mesh  In mm (LPS). @param name  Of the mesh, for messages. @throws Error that names mesh or file.
[[nodiscard]] quality::Evaluation evaluate_mesh(const MixedMesh& mesh, const std::string& name,
                                                const EvaluationRequest& request, Context& context);

}  // namespace lumesh
