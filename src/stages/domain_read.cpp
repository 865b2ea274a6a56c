#include "lumesh/stages/domain_read.hpp"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "lumesh/core/counted.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/domain/kept_names.hpp"
#include "lumesh/domain/local_volumes.hpp"
#include "lumesh/geometry/self_crossings.hpp"
#include "lumesh/mesh/label_shapes.hpp"
#include "lumesh/quality/surface.hpp"
#include "lumesh/stages/folded_walls.hpp"
#include "lumesh/stages/input_cuts.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/mesh_output.hpp"
#include "lumesh/stages/surface_input.hpp"
#include "lumesh/stages/vessel_ends.hpp"
#include "lumesh/vessels/opening_sections.hpp"
#include "lumesh/vessels/vessel_axes.hpp"

namespace lumesh {

namespace {

struct Outside {
  std::uint64_t pieces = 0;
  std::int64_t euler = 0;
  double volume_mm3 = 0;  ///< Zero where the triangles do not tell it.

  Outside(std::span<const Vec3> points, std::span<const Cell<3>> triangles) {
    const quality::SurfaceTopology all = quality::analyse_surface(points, triangles);
    for (const quality::SurfaceComponent& piece : all.components) {
      ++pieces;
      euler += piece.euler;
      volume_mm3 += piece.enclosed_volume_mm3;
    }
    const bool has_sides = all.closed() && all.non_manifold_edges == 0;
    volume_mm3 = has_sides ? std::abs(volume_mm3) : 0;
  }
};

/// A line where narrow gaps were closed, or pieces lost, and one where the mesh fills another volume; none
/// elsewhere.
std::vector<std::string> differences_from_surface(const MixedMesh& surface, const TetMesh& mesh) {
  constexpr double kMuch = 0.02;
  const Outside given(surface.points, surface.triangles);
  const Outside made(mesh.points(), mesh.boundary_faces().triangles);
  std::vector<std::string> lines;
  if (made.pieces != given.pieces || made.euler != given.euler)
    lines.push_back(
        fmt::format("the outside of the mesh has {} and Euler number {}, of {} and {} of the surface: parts "
                    "closer than the elements are large were joined, or small ones lost; a smaller `delta` "
                    "keeps them",
                    counted(made.pieces, "piece"), made.euler, given.pieces, given.euler));
  double volume_mm3 = 0;
  for (const auto& [label, of_label_mm3] : volumes_of_labels(mesh)) volume_mm3 += of_label_mm3;
  const double change = given.volume_mm3 > 0 ? volume_mm3 / given.volume_mm3 - 1 : 0;
  if (std::abs(change) > kMuch)
    lines.push_back(fmt::format(
        "the mesh fills {:.1f} % {} than the surface, {:.4g} of {:.4g} mm3: its elements are large "
        "for the surface; a smaller `edge_length` helps",
        100 * std::abs(change), change < 0 ? "less" : "more", volume_mm3, given.volume_mm3));
  if (lines.empty()) return lines;
  const std::vector<SelfCrossing> crossings = find_self_crossings(surface.points, surface.triangles);
  if (!crossings.empty())
    lines.push_back(fmt::format(
        "the surface folds and crosses itself in {} of triangles, such as at {}, which may be why the mesh "
        "differs from it; repair it first (`lumesh repair`)",
        counted(crossings.size(), "pair"), place_text(crossings.front().place)));
  return lines;
}

}  // namespace

DomainRead::DomainRead(DomainInput input, Context& context)
    : name(input.path), input_(std::move(input)), context_(context) {}

void DomainRead::read() {
  context_.phase("read", [&] {
    if (input_.is_surface)
      surface = read_surface(input_.path, input_.selection.unit, input_.surface, input_.cuts, context_);
    else
      image = read_selected_image(input_.path, input_.selection, context_);
  });
}

void DomainRead::cut_image() {
  given_frame = image->frame();
  cut_planes = naming(
      name, [&] { return context_.phase("cuts", [&] { return cut_off(*image, input_.cuts, context_); }); });
  const std::string pieces =
      context_.phase("pieces", [&] { return small_pieces_warning(*image, cut_planes); });
  has_small_pieces_ = !pieces.empty();
  if (has_small_pieces_) context_.warn(pieces);
}

const Domain& DomainRead::domain() {
  if (surface) return domain_of_surface();
  return *domain_of_image();
}

const std::shared_ptr<const ImageDomain>& DomainRead::domain_of_image() {
  if (!image_domain_)
    image_domain_ = naming(name, [&] {
      InputCuts before = input_.cuts;
      before.extension = {};
      auto domain = named_by_frames(domain_of_cut(*image, cut_planes, before, input_.field, context_));
      if (!input_.cuts.extension.is_wanted()) return domain;
      image_beginnings_ = context_.phase("openings", [&] { return find_openings(*domain); });
      return extended_domain(*image, cut_planes, *domain, image_beginnings_, input_.cuts.extension, context_);
    });
  return image_domain_;
}

std::shared_ptr<const ImageDomain> DomainRead::named_by_frames(std::shared_ptr<const ImageDomain> domain) {
  if (!input_.selection.openings_of_frames) return domain;
  auto named = std::make_shared<ImageDomain>(*domain);
  const std::vector<std::string> notes = context_.phase(
      "openings", [&] { return keep_opening_names(*input_.selection.openings_of_frames, *named); });
  for (const std::string& note : notes) context_.warn(name + ": " + note);
  return named;
}

std::span<const Opening> DomainRead::beginnings() const {
  return surface ? surface->beginnings : image_beginnings_;
}

const SurfaceDomain& DomainRead::domain_of_surface() {
  if (!surface_domain_)
    surface_domain_ = naming(name, [&] {
      return context_.phase("domain", [&] { return surface->domain(input_.surface.domain); });
    });
  return *surface_domain_;
}

const std::vector<Opening>& DomainRead::openings() {
  if (!openings_) openings_ = find_openings(domain());
  return *openings_;
}

Polylines DomainRead::axes(const CenterlineOptions& options) const {
  return naming(name, [&] {
    return image ? axes_of_vessels(*image, cut_planes, options, context_)
                 : axes_of_vessels(surface->mesh, options, context_);
  });
}

void DomainRead::look_at_surface() {
  warn_of_unit(*surface, openings(), input_.selection.unit, name, context_);
  for (const std::string& note : domain_of_surface().patch_notes()) context_.warn(name + ": " + note);
  name_closed(surface->closed, domain().flat_ends());
  warn_of_filled_ends(surface->closed, context_);
}

std::vector<std::string> DomainRead::doubts_about_openings() {
  if (!image) return {};
  std::vector<std::string> doubts =
      doubts_about_sections(*image, domain().cut_planes(), openings(), input_.field.fidelity);
  if (input_.cuts.extension.is_wanted()) return doubts;  // The others were told before the extensions.
  if (const std::string volumes = doubt_about_volumes(*image, *domain_of_image()); !volumes.empty())
    doubts.push_back(volumes);
  for (std::string& doubt : doubts_about_shapes(*image, domain(), openings()))
    doubts.push_back(std::move(doubt));
  return doubts;
}

std::string DomainRead::closed_vessels() {
  return surface ? closed_surface_warning(domain())
                 : closed_vessel_warning(*image, cut_planes, openings(), context_);
}

DomainRead::Survey DomainRead::survey(bool needs_axes) {
  // The domain first: it refuses noise, whose shape takes long to tell.
  static_cast<void>(domain());
  context_.phase("openings", [&] { static_cast<void>(openings()); });
  if (surface) look_at_surface();
  for (const std::string& doubt : doubts_about_openings()) context_.warn(doubt);
  Survey found;
  if (needs_axes) found.axes = context_.phase("axes", [&] { return axes({}); });
  found.closed_vessels =
      surface ? closed_vessels() : context_.phase("ends", [&] { return closed_vessels(); });
  return found;
}

const ImageShape& DomainRead::shape() {
  if (!shape_) {
    shape_ = shape_of(*image, cut_planes);
    shape_->is_exact = input_.field.fidelity == BoundaryFidelity::kExact;
  }
  return *shape_;
}

std::vector<std::string> DomainRead::differences_from(const TetMesh& mesh, const BoundaryFaces& faces) {
  return context_.phase("check", [&] {
    if (surface) return differences_from_surface(surface->mesh, mesh);
    return with_folds(differences(shape(), mesh), mesh.view(faces));
  });
}

std::vector<std::string> DomainRead::differences_from_lattice(const MeshView& mesh) {
  return context_.phase("check", [&] { return with_folds(differences_of_lattice(shape(), mesh), mesh); });
}

std::string DomainRead::sealed_pieces(const MeshView& mesh) const {
  return sealed_pieces_warning(mesh, has_small_pieces_ ? kSmallPiece : 0);
}

std::vector<std::string> DomainRead::with_folds(std::vector<std::string> differences, const MeshView& mesh) {
  for (std::string& note : note_of_folds(mesh, *domain_of_image())) differences.push_back(std::move(note));
  return differences;
}

void DomainRead::drop_image() {
  if (!image) return;
  context_.phase("shape", [&] { static_cast<void>(shape()); });
  image.reset();
}

std::span<const surfaces::ClosedRim> DomainRead::closed() const {
  if (!surface) return {};
  return surface->closed;
}

DomainRead read_domain(const DomainInput& input, Context& context) {
  DomainRead given(input, context);
  given.read();
  if (given.image) given.cut_image();
  return given;
}

}  // namespace lumesh
