#include "lumesh/delaunay/delaunay.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "crossed_rims.hpp"
#include "estimate.hpp"
#include "exterior_removal.hpp"
#include "flat_tets.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/delaunay/sizing_beside.hpp"
#include "lumesh/domain/usual_edge.hpp"
#include "lumesh/operators/delaunay_kernel.hpp"
#include "lumesh/operators/settling.hpp"
#include "out_of_bounds.hpp"
#include "refinement.hpp"
#include "relaxing.hpp"
#include "seeds.hpp"
#include "thinning.hpp"
#include "topology.hpp"

namespace lumesh {

namespace {

/// @throws Error{kBadInput} for a delta, or what stands for it, of which the object is too small.
void check_fits(const DelaunayOptions& options, const Domain& domain) {
  const double largest = domain.bounds_mm().sizes().maxCoeff();
  if (!(largest > 0)) throw Error(ErrorKind::kBadInput, "there is nothing to mesh");
  const double delta_mm = delaunay_delta_mm(options, domain);
  if (delta_mm <= largest) return;
  const bool is_edge = !(options.delta_mm > 0);
  throw Error(ErrorKind::kBadInput,
              fmt::format("{} ({:g} mm) is larger than the object, which is {:.4g} mm long; choose one a "
                          "good deal smaller",
                          is_edge ? "the edge length" : "delta",
                          is_edge ? delaunay::kEdgePerSpacing * delta_mm : delta_mm, largest));
}

/// Drops seeds as `seeding` says: none, those inside, or all but some on the boundary.
/// @return The candidates that the rules have to find most of, as they were.
std::vector<delaunay::BoundaryCandidate> drop_seeds(delaunay::Seeds& seeds, Seeding seeding,
                                                    const Box3& box) {
  if (seeding == Seeding::kLattice) return {};
  seeds.inner.clear();
  if (seeding == Seeding::kSurface) return {};
  constexpr double kFewAcross = 6;
  std::vector<delaunay::BoundaryCandidate> all = seeds.boundary;
  for (delaunay::BoundaryCandidate& one : seeds.boundary)
    one.spacing = std::max(one.spacing, box.sizes().maxCoeff() / kFewAcross);
  return all;
}

/// At least one round: it finds out what is inside.
/// @param to_find  Places of boundaries that all are to be known in the end. @return false if it was stopped.
bool refined(delaunay::Refinement& refinement, std::span<const delaunay::BoundaryCandidate> to_find,
             const DelaunayOptions& options, DelaunayReport& report, Context& context) {
  do {
    report.rounds.push_back(refinement.run_round());
    context.results_exist();
    DelaunayRound& last = report.rounds.back();
    if (last.inserted + last.removed > 0) continue;
    if (!refinement.has_cleared()) last.inserted = refinement.complete(to_find);
    if (last.inserted > 0) continue;
    last.removed = refinement.clear();
    if (last.removed == 0) return true;
  } while (static_cast<int>(report.rounds.size()) < options.max_rounds && !context.cancelled());
  refinement.name_materials();
  report.rules_hold = false;
  if (!context.cancelled())
    report.notes.push_back(
        fmt::format("refinement stopped after {} rounds with rules unmet ({} points in the last): where "
                    "parts are thin, or a "
                    "criterion asks for more than points can give, bounds on shapes and sizes may not hold",
                    report.rounds.size(), report.rounds.back().inserted));
  return !context.cancelled();
}

/// A triangulation that holds the object and all seeds.
TetMesh hull_around(Box3 box, std::span<const Vec3> outer) {
  for (const Vec3& p : outer) box.extend(p);
  return operators::triangulation_around(box.center(), 0.5 * box.diagonal().norm());
}

/// The sizes that are asked for, but no faster growth from the boundary than shapes can follow: with a larger
/// size right behind the boundary nothing would be there for small parts to be found by, nor for angles to
/// become good on, and the rules would fill in more points than the growth needs.
class GradedSizing final : public SizingBeside {
 public:
  GradedSizing(const Domain& domain, double edge_mm, const Sizing* asked)
      : SizingBeside(asked),
        graded_(size_from_boundary(domain, {.at_boundary_mm = edge_mm, .growth = delaunay::kGrowthInwards})) {
  }

 private:
  [[nodiscard]] double own_size_at(const Vec3& point_mm, Label label) const override {
    return graded_->size_at(point_mm, label);
  }

  std::unique_ptr<Sizing> graded_;
};

/// None unless the size inside is larger than the edges of surfaces.
std::unique_ptr<Sizing> graded_sizing(const Domain& domain, const DelaunayOptions& options) {
  const double edge_mm = delaunay::kEdgePerSpacing * delaunay_delta_mm(options, domain);
  if (options.size_mm <= delaunay::kMuchLarger * edge_mm || domain.bounds_mm().isEmpty()) return nullptr;
  return std::make_unique<GradedSizing>(domain, edge_mm, options.sizing);
}

delaunay::Spacing spacing_of(const Domain& domain, const DelaunayOptions& options, const Sizing* graded) {
  const double delta_mm = delaunay_delta_mm(options, domain);
  const double size_mm = options.size_mm > 0 ? options.size_mm : delaunay::kEdgePerSpacing * delta_mm;
  const double surface_distance_mm =
      options.surface_distance_mm > 0 ? options.surface_distance_mm : std::numeric_limits<double>::infinity();
  return {domain, delta_mm, size_mm, surface_distance_mm, graded != nullptr ? graded : options.sizing};
}

/// Moves surface vertices onto the surface, however flat tetrahedra become: slivers are left to improvement.
std::size_t settle_in(const Domain& domain, const DelaunayOptions& options, TetMesh& mesh) {
  const auto always = [](std::size_t, const std::array<Vec3, 4>&, const std::array<Vec3, 4>&) {
    return true;
  };
  const operators::SettlingRules rules{.lift = options.lift,
                                       .may_become = always,
                                       .keep_within = operators::within_cuts_of(domain),
                                       .stays = operators::fixed_points_of(domain)};
  return operators::settle(mesh, operators::places_in_domain(mesh, domain), rules).held_back;
}

/// Where points are inserted before the rules ask for any.
struct AllSeeds {
  delaunay::Seeds lattice;
  std::vector<std::uint32_t> boundary;               ///< One of the candidates each, relaxed on the surfaces.
  std::vector<delaunay::BoundaryCandidate> to_find;  ///< What the rules have to find most of.
};

AllSeeds all_seeds(const Domain& domain, const delaunay::Spacing& spacing, Seeding seeding,
                   Context& context) {
  AllSeeds seeds;
  seeds.lattice = context.phase("lattice", [&] { return delaunay::lattice_seeds(spacing); });
  seeds.to_find = drop_seeds(seeds.lattice, seeding, domain.bounds_mm());
  context.phase("surface", [&] {
    seeds.boundary = delaunay::poisson_disk_subset(seeds.lattice.boundary);
    delaunay::relax(domain, seeds.boundary, seeds.lattice.boundary);
  });
  return seeds;
}

DelaunayReport report_on(const AllSeeds& seeds) {
  DelaunayReport report;
  report.inner_seeds = seeds.lattice.inner.size();
  report.outer_seeds = seeds.lattice.outer.size();
  report.boundary_seeds = seeds.boundary.size();
  return report;
}

/// Labels changed where the boundary would not be a manifold, flat at cuts, or within bounds.
/// @return The number of vertices at which it was pinched.
std::size_t relabelled(TetMesh& mesh, const Domain& domain, const std::vector<VertexId>& pinched) {
  const std::size_t count = delaunay::relabel_pinched(mesh, domain, pinched);
  delaunay::relabel_at_cuts(mesh, domain);
  delaunay::relabel_crossed_rims(mesh, domain);
  delaunay::relabel_flat(mesh, domain);
  delaunay::relabel_out_of_bounds(mesh, domain);
  return count;
}

void note_pinched(DelaunayReport& report) {
  if (report.pinched_vertices == 0) return;
  report.notes.push_back(fmt::format(
      "at {} vertices parts would have touched in a point or an edge only: tetrahedra there changed "
      "their label; a smaller `delta` leaves fewer",
      report.pinched_vertices));
}

}  // namespace

double delaunay_delta_mm(const DelaunayOptions& options, const Domain& domain) {
  if (options.delta_mm > 0) return options.delta_mm;
  const double edge_mm =
      options.edge_length_mm > 0 ? options.edge_length_mm : kUsualEdge * domain.resolution_mm();
  return edge_mm / delaunay::kEdgePerSpacing;
}

DelaunayResult mesh_delaunay(const Domain& domain, const DelaunayOptions& options, Context& context) {
  options.validate();
  check_fits(options, domain);
  const std::unique_ptr<Sizing> graded = graded_sizing(domain, options);
  const delaunay::Spacing spacing = spacing_of(domain, options, graded.get());
  const delaunay::EstimatedTets expected = delaunay::estimated_tets(spacing);
  delaunay::check_memory(expected);
  const AllSeeds seeds = all_seeds(domain, spacing, options.seeding, context);
  DelaunayResult result{hull_around(domain.bounds_mm(), seeds.lattice.outer), report_on(seeds)};
  DelaunayReport& report = result.report;
  delaunay::Refinement refinement(result.mesh, spacing, options);
  context.phase("insertion", [&] { refinement.insert_seeds(seeds.lattice, seeds.boundary); });
  report.complete = context.phase(
      "refinement", [&] { return refined(refinement, seeds.to_find, options, report, context); });
  report.pinched_vertices =
      context.phase("topology", [&] { return relabelled(result.mesh, domain, refinement.pinched()); });
  context.phase("exterior removal", [&] { delaunay::remove_exterior(result.mesh, domain); });
  if (report.complete)
    report.held_back = context.phase("settling", [&] { return settle_in(domain, options, result.mesh); });
  note_pinched(report);
  if (options.edge_length_mm > 0 || options.delta_mm > 0)
    if (std::string note = note_on_thin_parts(expected, spacing); !note.empty())
      report.notes.push_back(std::move(note));
  if (result.mesh.tet_count() == 0)
    throw Error(ErrorKind::kBadInput,
                "nothing of the object is left; choose a smaller `delta`, or other cut planes");
  return result;
}

double estimated_tetrahedra(const Domain& domain, const DelaunayOptions& options) {
  options.validate();
  const std::unique_ptr<Sizing> graded = graded_sizing(domain, options);
  return delaunay::estimated_tets(spacing_of(domain, options, graded.get())).all;
}

}  // namespace lumesh
