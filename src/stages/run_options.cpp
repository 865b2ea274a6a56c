#include "lumesh/stages/run_options.hpp"

#include <limits>

namespace lumesh {

Option& describe_threads(OptionList& list, int& threads) {
  return list.number("threads", threads, between(0, 4096), "Threads; 0: all cores");
}

void describe_time_limit(OptionList& list, double& limit_s) {
  list.number("time_limit", limit_s, above(0),
              "Stop then, with exit code 4; adapt, delaunay, improve, lattice and run write the best mesh so "
              "far, if there is one")
      .in("s")
      .zero("none", std::numeric_limits<double>::infinity());
}

void describe_names(OptionList& list, std::vector<std::string>& names) {
  list.texts("names", names,
             "PATCH=NAME, such as outlet_2=left_ica, X,Y,Z=NAME for the opening near a place in mm, "
             "AREAmm2=NAME for the one of about that area; NAME:KIND says what it is: inlet, outlet, wall or "
             "symmetry; lumesh info lists the openings of an image")
      .alias("name");
}

void describe_report(OptionList& list, std::string& path) {
  list.text("report", path, "Report with plots and pictures (.html); none: not written");
}

}  // namespace lumesh
