#include "lumesh/stages/delaunay_stage.hpp"

#include <utility>

#include "lumesh/core/option.hpp"

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

DelaunayMesh make_delaunay_mesh(const Domain& domain, const DelaunayRequest& request, const Sizing* sizing,
                                Context& context) {
  DelaunayOptions options = request.delaunay;
  options.sizing = sizing;
  options.team = request.improvement.team;
  DelaunayResult result = mesh_delaunay(domain, options, context);
  DelaunayMesh made{std::move(result.mesh), std::move(result.report), {}, true};
  made.is_complete = made.report.complete;
  if (!request.improves || !made.is_complete) return made;
  ImproveOptions improvement = request.improvement;
  improvement.place = operators::places_in_domain(made.mesh, domain);
  improvement.keep_within = operators::within_cuts_of(domain);
  improvement.lift = options.lift;
  improvement.settles_all = made.report.held_back > 0;
  context.phase("improvement", [&] { made.improved = improve(made.mesh, improvement, context); });
  made.is_complete = made.improved->complete;
  return made;
}

}  // namespace lumesh
