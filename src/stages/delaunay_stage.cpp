#include "lumesh/stages/delaunay_stage.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lumesh/core/option.hpp"
#include "lumesh/delaunay/sizing_beside.hpp"
#include "lumesh/domain/domain.hpp"
#include "lumesh/domain/opening_sizes.hpp"
#include "lumesh/operators/settling.hpp"
#include "lumesh/parallel/sum.hpp"
#include "vertices_outside.hpp"

namespace lumesh {

void DelaunayRequest::describe(OptionList& list) {
  delaunay.describe(list);
  sizes.describe(list);
  list.flag("improve", improves, "Swaps and moves after refinement, without which slivers stay");
  improvement.describe_targets(list);
}

void DelaunayRequest::validate() const {
  delaunay.validate();
  sizes.validate();
  improvement.validate();
}

namespace {

std::uint64_t count_to_refine(const TetMesh& mesh, const Sizing& sizing) {
  constexpr std::size_t kBlock = 4096;
  return parallel::sum<std::uint64_t>(mesh.tet_count(), kBlock, [&](std::size_t i) {
    const TetId t(static_cast<std::uint32_t>(i));
    return sizing.wants_finer({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), mesh.corner(t, 3)});
  });
}

/// Improvement makes nothing that a criterion would refine.
void improve_within(const Domain& domain, const DelaunayRequest& request, const Sizing* criterion,
                    DelaunayMesh& made, Context& context) {
  ImproveOptions improvement = request.improvement;
  improvement.place = operators::places_in_domain(made.mesh, domain);
  improvement.keep_within = operators::within_cuts_of(domain);
  improvement.stays = operators::fixed_points_of(domain);
  improvement.lift = request.delaunay.lift;
  improvement.settles_all = made.report.held_back > 0;
  if (criterion != nullptr)
    improvement.refusal = [criterion](const std::array<Vec3, 4>& tet) { return criterion->wants_finer(tet); };
  context.phase("improvement", [&] { made.improved = improve(made.mesh, improvement, context); });
  made.is_complete = made.improved->complete;
  if (const DihedralRange& after = made.improved->after; made.is_complete && after.tets_outside > 0)
    made.report.notes.push_back(fmt::format(
        "{} of {} tetrahedra have dihedral angles outside {:g} to {:g} degrees, from {:.4g} to {:.4g}, that "
        "improvement could not bring within the targets",
        after.tets_outside, made.mesh.tet_count(), improvement.min_dihedral_deg, improvement.max_dihedral_deg,
        after.min_deg, after.max_deg));
}

/// A wall with creases has a patch for each part while it is meshed; in the end patches of one name are one.
void join_patches_of_one_name(TetMesh& mesh) {
  const std::vector<Patch> patches = mesh.info().patches;
  std::map<std::string, std::uint32_t> number;
  std::vector<PatchId> joined;
  mesh.info().patches.clear();
  for (const Patch& patch : patches) {
    const auto [at, is_new] =
        number.try_emplace(patch.name, static_cast<std::uint32_t>(mesh.info().patches.size()));
    if (is_new) mesh.info().patches.push_back(patch);
    joined.emplace_back(at->second);
  }
  if (mesh.info().patches.size() == patches.size()) return;
  for (std::uint32_t t = 0; t < mesh.tet_count(); ++t)
    for (int face = 0; face < 4; ++face) {
      const PatchId patch = mesh.patch(TetId(t), face);
      if (!patch.valid()) continue;
      if (mesh.link(TetId(t), face).is_boundary())
        mesh.set_link(TetId(t), face, FaceLink::boundary(joined[patch.value]));
      else
        mesh.set_interface_patch(TetId(t), face, joined[patch.value]);
    }
  const BoundaryFaces faces = mesh.boundary_faces();
  mesh.classify_vertices({faces.triangles, faces.patches});
}

void note_vertices_outside(const Domain& domain, DelaunayMesh& made) {
  constexpr double kLittleBeyond = 0.01;  // Of the resolution.
  std::string outside = note_on_vertices_outside(
      made.mesh.points(), operators::within_cuts_of(domain), kLittleBeyond * domain.resolution_mm(),
      fmt::format("another {} may help", option_name("edge_length")));
  if (!outside.empty()) made.report.notes.push_back(std::move(outside));
}

std::uint64_t count_fixed_points(const Domain& domain, const TetMesh& mesh) {
  const std::span<const Vec3> points = mesh.points();
  return static_cast<std::uint64_t>(
      std::ranges::count_if(points, [&](const Vec3& p) { return domain.is_fixed(p); }));
}

/// Counts the tetrahedra that the criterion would still refine, and notes that they are many.
void note_tets_to_refine(const Sizing& criterion, DelaunayMesh& made) {
  constexpr double kMany = 0.01;
  const std::uint64_t asks = made.report.criterion_asks = count_to_refine(made.mesh, criterion);
  if (static_cast<double>(asks) <= kMany * made.mesh.tet_count()) return;
  made.report.notes.push_back(
      fmt::format("the criterion would still refine {} of {} tetrahedra, next to surfaces for the most "
                  "part, whose points stand as `delta` says; a smaller one leaves fewer",
                  asks, made.mesh.tet_count()));
}

/// Sizes at openings: these, and growing with the distance from them.
class SizingAtOpenings final : public SizingBeside {
 public:
  SizingAtOpenings(std::span<const OpeningSize> sizes, const Sizing* asked)
      : SizingBeside(asked), sizes_(sizes.begin(), sizes.end()) {}

 private:
  [[nodiscard]] double own_size_at(const Vec3& point_mm, Label /*label*/) const override {
    constexpr double kGrowth = 0.3;
    double size_mm = kAnySize;
    for (const OpeningSize& size : sizes_)
      size_mm = std::min(size_mm, size.edge_mm + kGrowth * size.distance_mm(point_mm));
    return size_mm;
  }

  std::vector<OpeningSize> sizes_;
};

DelaunayMesh mesh_once(const Domain& domain, const DelaunayRequest& request, const Sizing* sizing,
                       Context& context) {
  DelaunayOptions options = request.delaunay;
  options.sizing = sizing;
  options.team = request.improvement.team;
  DelaunayResult result = mesh_delaunay(domain, options, context);
  DelaunayMesh made{std::move(result.mesh), std::move(result.report), {}, true};
  made.is_complete = made.report.complete;
  const Sizing* const criterion = sizing != nullptr && sizing->has_criterion() ? sizing : nullptr;
  if (request.improves && made.is_complete) improve_within(domain, request, criterion, made, context);
  join_patches_of_one_name(made.mesh);
  note_vertices_outside(domain, made);
  if (!domain.fixed_points().empty()) made.report.fixed_points_kept = count_fixed_points(domain, made.mesh);
  if (criterion != nullptr) note_tets_to_refine(*criterion, made);
  return made;
}

/// Share of the tetrahedra that improvement could not bring within the targets.
double bad_share(const DelaunayMesh& made) {
  return made.improved ? static_cast<double>(made.improved->after.tets_outside) / made.mesh.tet_count() : 0;
}

/// Limits of a mesh that is made again: not many more cells than the first one, and about as few bad ones.
struct LimitsOfRemaking {
  static constexpr double kBad = 0.01;
  std::size_t max_cells = 0;
  double max_bad_share = kBad;

  void note_first(const DelaunayMesh& first) {
    max_cells = max_cells_made_again(first.mesh.tet_count());
    max_bad_share = std::max(kBad, bad_share(first));
  }
  [[nodiscard]] bool hold(const DelaunayMesh& made) const {
    return made.mesh.tet_count() <= max_cells && bad_share(made) <= max_bad_share;
  }
};

}  // namespace

DelaunayMesh make_delaunay_mesh(const Domain& domain, const DelaunayRequest& request, const Sizing* sizing,
                                Context& context) {
  LimitsOfRemaking limits;
  auto best = best_at_openings(
      domain, context,
      [&](const OpeningSizes& at_openings) {
        const SizingAtOpenings finer(at_openings.sizes(), sizing);
        const bool is_first = at_openings.sizes().empty();
        DelaunayMesh made = mesh_once(domain, request, is_first ? sizing : &finer, context);
        if (is_first) limits.note_first(made);
        return made;
      },
      [](const OpeningSizes& sizes, const DelaunayMesh& made) {
        return sizes.faults_in(made.mesh.view(made.mesh.boundary_faces()));
      },
      [&](const DelaunayMesh& made) { return limits.hold(made); },
      [](const DelaunayMesh& made) { return made.is_complete; });
  best.mesh.is_complete = best.is_complete;
  return std::move(best.mesh);
}

}  // namespace lumesh
