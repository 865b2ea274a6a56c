#pragma once
/// @file What is meshed: the labels of an image, or the inside of a surface.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lumesh/centerline/centerline.hpp"
#include "lumesh/core/context.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/domain/openings.hpp"
#include "lumesh/domain/surface_domain.hpp"
#include "lumesh/field/field_options.hpp"
#include "lumesh/mesh/polylines.hpp"
#include "lumesh/mesh/tet_mesh.hpp"
#include "lumesh/stages/image_shape.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh {

struct DomainInput {
  std::string path;
  bool is_surface = false;  ///< Else an image.
  ImageSelection selection;
  InputCuts cuts;
  LabelFieldOptions field;  ///< Options of an image.
  SurfaceInputOptions surface;
};

/// An image or a surface as it is read, and what meshers ask of it, made when it is first asked for. Errors
/// name the file.
class DomainRead {
 public:
  DomainRead(DomainInput input, Context& context);

  /// Reads the file, and cuts and extends a surface.
  void read();
  /// Cuts an image off, without its extensions; warns of small pieces.
  void cut_image();

  /// Domain to mesh: the image's with its extensions, or that of the surface.
  [[nodiscard]] const Domain& domain();
  [[nodiscard]] const std::shared_ptr<const ImageDomain>& domain_of_image();
  [[nodiscard]] const SurfaceDomain& domain_of_surface();
  [[nodiscard]] const std::vector<Opening>& openings();
  /// Openings before they were extended, where the extensions begin; none where none was. Known once the
  /// domain was asked for.
  [[nodiscard]] std::span<const Opening> beginnings() const;
  /// Axes of all vessels.
  [[nodiscard]] Polylines axes(const CenterlineOptions& options) const;

  /// Warns of a surface whose unit is in doubt, and names what was closed of it.
  void look_at_surface();
  /// Lines on openings of an image that its voxels do not show, or that two vessels seem to share.
  [[nodiscard]] std::vector<std::string> doubts_about_openings();
  /// A line if no vessel has an opening, else empty.
  [[nodiscard]] std::string closed_vessels();
  /// Lines on differences of a mesh from the image, as differences() and note_of_folds(), or ones where its
  /// outside has other pieces or another Euler number than the surface, or its volume is more than 2 % off.
  /// @param faces  The mesh's boundary faces.
  [[nodiscard]] std::vector<std::string> differences_from(const TetMesh& mesh, const BoundaryFaces& faces);
  /// Lines as those of differences_of_lattice() and note_of_folds().
  [[nodiscard]] std::vector<std::string> differences_from_lattice(const MeshView& mesh);
  /// A line as that of sealed_pieces_warning(), but on small pieces only where none were told of before.
  [[nodiscard]] std::string sealed_pieces(const MeshView& mesh) const;
  /// All that is to be known before meshing, with its warnings.
  struct Survey {
    Polylines axes;              ///< Axes of the vessels, where they are wanted.
    std::string closed_vessels;  ///< A line for later; see closed_vessels().
  };
  [[nodiscard]] Survey survey(bool needs_axes);
  /// Frees the voxels of an image, whose domain and shape are kept. Only these can be asked for then.
  void drop_image();

  /// Rims closed of a surface.
  [[nodiscard]] std::span<const surfaces::ClosedRim> closed() const;

  std::string name;                       ///< Name of what is meshed: the path, unless it is none.
  std::optional<LabelImage> image;        ///< Without what is cut off.
  ImageFrame given_frame = {};            ///< Frame of the image before it was extended.
  std::vector<CutPlane> cut_planes = {};  ///< Planes that cut the image.
  std::optional<SurfaceInput> surface;    ///< The surface, where there is no image.
  /// The domain of the image, once it was asked for.
  [[nodiscard]] const ImageDomain* image_domain() const { return image_domain_.get(); }

 private:
  /// The domain with the names of openings that frames before have.
  [[nodiscard]] std::shared_ptr<const ImageDomain> named_by_frames(std::shared_ptr<const ImageDomain> domain);
  [[nodiscard]] const ImageShape& shape();
  [[nodiscard]] std::vector<std::string> with_folds(std::vector<std::string> differences,
                                                    const MeshView& mesh);

  DomainInput input_;
  Context& context_;
  std::shared_ptr<const SurfaceDomain> surface_domain_;
  std::shared_ptr<const ImageDomain> image_domain_;
  std::optional<std::vector<Opening>> openings_;
  std::vector<Opening> image_beginnings_;  ///< Openings of an image before they were extended.
  std::optional<ImageShape> shape_;
  bool has_small_pieces_ = false;
};

/// Reads it, and cuts an image off.
[[nodiscard]] DomainRead read_domain(const DomainInput& input, Context& context);

}  // namespace lumesh
