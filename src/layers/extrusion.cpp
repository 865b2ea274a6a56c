#include "lumesh/layers/extrusion.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "lumesh/core/angles.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/geometry/predicates.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/mesh/all_cells.hpp"
#include "lumesh/mesh/edge_key.hpp"
#include "lumesh/mesh/tetrahedral_split.hpp"
#include "swept_section.hpp"

namespace lumesh {
namespace {

using layers::PatchFace;
using layers::SectionFinder;
using layers::SweptSection;

class Extruder {
 public:
  Extruder(const MixedMesh& mesh, LayerCells cells, const std::optional<LocalLength>& transition,
           const AxisOfEnd& axis_of_end)
      : cells_(cells), transition_(transition), axis_of_end_(axis_of_end) {
    result_.mesh = mesh;
    wall_edge_mm_ = mean_wall_edge_mm();
  }

  ExtrudedMesh make(std::span<const NamedLength> lengths) && {
    check_names(lengths);
    std::vector<bool> is_done(patches().size(), false);
    for (std::size_t p = 0; p < patches().size(); ++p) {
      if (patches()[p].kind != PatchKind::kOpening || is_done[p]) continue;
      SweptSection section = SectionFinder(mesh()).section_at(static_cast<std::int32_t>(p));
      for (const std::int32_t q : section.patches) is_done[static_cast<std::size_t>(q)] = true;
      if (section.faces.empty() || !(wanted_mm(section, lengths) > 0)) continue;
      take_axis_of_end(section);
      const double length_mm = wanted_mm(section, lengths);  // Of the radius across that axis.
      extend(std::move(section), length_mm);
    }
    return std::move(result_);
  }

 private:
  [[nodiscard]] const MixedMesh& mesh() const { return result_.mesh; }
  [[nodiscard]] const std::vector<Patch>& patches() const { return mesh().info.patches; }
  [[nodiscard]] const Patch& patch(std::int32_t p) const { return patches()[static_cast<std::size_t>(p)]; }
  [[nodiscard]] const Vec3& point(std::uint32_t v) const { return mesh().points[v]; }

  /// Mean length of the edges of all walls; 0 without any.
  [[nodiscard]] double mean_wall_edge_mm() const {
    double sum_mm = 0;
    std::size_t count = 0;
    for_each_patch_face(mesh(), [&](std::span<const std::uint32_t> face, std::int32_t p) {
      if (patch(p).kind != PatchKind::kWall) return;
      for_each_edge_of(face,
                       [&](std::uint32_t a, std::uint32_t b) { sum_mm += (point(a) - point(b)).norm(); });
      count += face.size();
    });
    return count == 0 ? 0 : sum_mm / static_cast<double>(count);
  }

  void check_names(std::span<const NamedLength> lengths) const {
    std::vector<std::string> names;
    for (const Patch& p : patches())
      if (p.kind == PatchKind::kOpening) names.push_back(p.name);
    if (names.empty())
      throw Error(ErrorKind::kBadInput, fmt::format("{}: the mesh has no openings", option_name("extend")));
    check_names_of(lengths, names, "the mesh");
  }

  [[nodiscard]] double wanted_mm(const SweptSection& s, std::span<const NamedLength> lengths) const {
    std::vector<std::string> names;
    for (const std::int32_t p : s.patches) names.push_back(patch(p).name);
    return length_wanted_mm(lengths, names, s.radius_mm);
  }

  /// Rough walls lead an extension off the vessel.
  void take_axis_of_end(SweptSection& s) {
    constexpr double kMinOfNormal = 0.4;
    if (!axis_of_end_ || (!s.is_rough && is_near(s.axis, s.normal))) return;
    const std::optional<Vec3> axis = axis_of_end_(s.centre_mm, s.normal, s.radius_mm);
    const bool is_known = axis && axis->dot(s.normal) > kMinOfNormal;
    tell_doubt(s, is_known ? axis : std::nullopt);
    if (!is_known || !s.is_rough) return;
    s.radius_mm *= std::sqrt(axis->dot(s.normal) / s.axis.dot(s.normal));
    s.axis = *axis;
    s.is_clear = true;
  }

  /// Whether directions are less than 5 degrees apart.
  static bool is_near(const Vec3& a, const Vec3& b) {
    constexpr double kCosine = 0.9962;
    return a.dot(b) > kCosine;
  }

  /// Tells of an end whose direction the walls before it, the centres of sections, and its own normal do not
  /// agree on.
  void tell_doubt(const SweptSection& s, const std::optional<Vec3>& by_centres) {
    const auto apart = [](const Vec3& a, const Vec3& b) {
      return degrees(std::acos(std::min(1.0, a.dot(b))));
    };
    std::string why;
    if (!by_centres && s.is_clear && !is_near(s.axis, s.normal))
      why = fmt::format(
          "the walls before it are {:.0f} degrees off its normal, and the centres of sections do not "
          "tell it",
          apart(s.axis, s.normal));
    else if (by_centres && s.is_clear && !is_near(s.axis, *by_centres))
      why = fmt::format("the walls before it and the centres of sections are {:.0f} degrees apart",
                        apart(s.axis, *by_centres));
    else if (by_centres && s.is_rough && !is_near(*by_centres, s.normal))
      why = fmt::format("it is {:.0f} degrees off its normal, and the walls before it are rough",
                        apart(*by_centres, s.normal));
    if (!why.empty())
      result_.notes.push_back(fmt::format(
          "{}: the direction of the vessel at {}, {}, is doubtful: {}; look at the extension, or smooth "
          "the surface before",
          option_name("extend"), patch(s.patches[0]).name, place_text(s.centre_mm), why));
  }

  void extend(SweptSection s, double length_mm) {
    const std::string& name = patch(s.patches[0]).name;
    for (const std::uint32_t v : s.vertices)
      if (std::abs((point(v) - s.centre_mm).dot(s.normal)) > 0.01 * s.reach_mm)
        throw Error(ErrorKind::kBadInput,
                    fmt::format("{}: {} is not flat; extensions stand on flat openings: cut it off before, "
                                "such as by {}",
                                option_name("extend"), name, option_name("clip_ends") + " 0.5r"));
    constexpr double kLowestRow = 0.25;  // Of the edges.
    if (!s.is_clear)
      result_.notes.push_back(
          fmt::format("{}: the extension of {} is perpendicular to the opening: the walls before it do not "
                      "show the vessel's direction; cut it further inside, where it runs straight",
                      option_name("extend"), name));
    const double cosine = s.axis.dot(s.normal);
    const double slant_mm = s.reach_mm * std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const double min_mm = slant_mm + kLowestRow * s.edge_mm;
    const SectionFinder finder(mesh());
    if (transition_ && !finder.find_circle(s, transition_->in_mm(s.radius_mm)))
      result_.notes.push_back(fmt::format("{}: the section of {} is not star-shaped, and stays as it is",
                                          option_name("extend_circle"), name));
    finder.find_ramp(s, row_height_mm(s), std::max(length_mm, min_mm) - slant_mm);
    const std::optional<Hit> hit = first_hit(s, std::max(length_mm, min_mm) + s.radius_mm);
    double given_mm = std::max(length_mm, min_mm);
    if (hit) given_mm = std::min(given_mm, hit->along_mm - s.radius_mm);
    if (given_mm < min_mm) given_mm = 0;
    if (given_mm != length_mm) {
      const std::string reason =
          given_mm < length_mm   ? "another part of the surface is in the way at " + place_text(hit->place_mm)
          : slant_mm > length_mm ? std::string("it is cut off obliquely")
                                 : fmt::format("its edges are {:.3g} mm long", s.edge_mm);
      result_.notes.push_back(
          fmt::format("{}: the extension of {} is {:.4g} mm long instead of {:.4g} mm: {}",
                      option_name("extend"), name, given_mm, length_mm, reason));
    }
    if (given_mm == 0) return;
    if (mesh().view().cell_count() > 0) finder.find_labels(s);
    s.ramp.set_length(std::min(s.ramp.length_mm(), given_mm - slant_mm));
    sweep(s, given_mm);
  }

  struct Hit {
    double along_mm = 0;
    Vec3 place_mm = Vec3::Zero();
  };
  /// Where along the axis another part of the boundary is nearer than an edge.
  [[nodiscard]] std::optional<Hit> first_hit(const SweptSection& s, double last_mm) const {
    const Vec3 u = s.axis.unitOrthogonal(), v = s.axis.cross(u);
    const double half_width_mm =  // Of what a square column around the axis holds.
        s.reach_mm + s.ramp.max_displacement_mm() + s.edge_mm;
    const auto is_in_way = [&](std::span<const std::uint32_t> face) {
      bool is_beyond = false;
      Vec2 least = Vec2::Constant(half_width_mm), most = -least;
      for (const std::uint32_t at : face) {
        const Vec3 off = point(at) - s.centre_mm;
        is_beyond = is_beyond || off.dot(s.normal) > 0.01 * s.edge_mm;
        const Vec2 across(off.dot(u), off.dot(v));
        least = least.cwiseMin(across);
        most = most.cwiseMax(across);
      }
      return is_beyond && (least.array() < half_width_mm).all() && (most.array() > -half_width_mm).all();
    };
    std::vector<Cell<3>> beyond;
    for_each_patch_face(mesh(), [&](std::span<const std::uint32_t> face, std::int32_t p) {
      if (s.has(p) || !is_in_way(face)) return;
      for (std::size_t i = 2; i < face.size(); ++i) beyond.push_back({face[0], face[i - 1], face[i]});
    });
    if (beyond.empty()) return std::nullopt;
    const TriangleTree tree(mesh().points, beyond);
    for (double along_mm = 0; along_mm < last_mm + s.edge_mm; along_mm += 0.5 * s.edge_mm)
      for (const std::uint32_t v : s.vertices)
        if (const auto found = tree.nearest(s.swept(point(v), v, along_mm), s.edge_mm);
            found.triangle != TriangleTree::kNone)
          return Hit{along_mm, found.point};
    return std::nullopt;
  }

  /// The section's edges; of a surface, whose rims are often finer than its walls, the walls' where longer.
  [[nodiscard]] double row_height_mm(const SweptSection& s) const {
    if (mesh().view().cell_count() > 0) return s.edge_mm;
    return std::max(s.edge_mm, std::min(wall_edge_mm_, kMaxRowOfRadius * s.radius_mm));
  }

  /// Rows of cells, from the section to the end.
  void sweep(const SweptSection& s, double length_mm) {
    const auto rows = static_cast<std::size_t>(std::max(1.0, std::round(length_mm / row_height_mm(s))));
    add_points(s, length_mm, rows);
    const bool has_quads =
        std::ranges::any_of(s.faces, [](const PatchFace& face) { return face.corners.size() == 4; });
    const bool splits = cells_ == LayerCells::kTetrahedra && !has_quads;
    add_sides(s, rows, splits);
    if (mesh().view().cell_count() > 0) add_cells(s, rows, splits);
    move_opening(s, rows);
  }

  void add_cells(const SweptSection& s, std::size_t rows, bool splits) {
    MixedMesh prisms;
    for (std::size_t row = 0; row < rows; ++row)
      for (const PatchFace& face : s.faces) {
        const auto low = [&](std::size_t i) { return vertex(s, face.corners[i], row); };
        const auto up = [&](std::size_t i) { return vertex(s, face.corners[i], row + 1); };
        if (face.corners.size() == 3) {
          prisms.prisms.push_back({low(0), low(2), low(1), up(0), up(2), up(1)});
          prisms.prism_labels.push_back(face.label);
        } else {
          result_.mesh.hexahedra.push_back({low(0), low(1), low(2), low(3), up(0), up(1), up(2), up(3)});
          result_.mesh.hexahedron_labels.push_back(face.label);
        }
      }
    add_prisms(prisms, splits);
  }

  /// The vertex that one of the section has in a row; row 0 is the section.
  [[nodiscard]] std::uint32_t vertex(const SweptSection& s, std::uint32_t v, std::size_t row) const {
    if (row == 0) return v;
    return first_new_ + static_cast<std::uint32_t>((row - 1) * s.vertices.size()) + rank_in(s.vertices, v);
  }

  void add_points(const SweptSection& s, double length_mm, std::size_t rows) {
    MixedMesh& m = result_.mesh;
    first_new_ = static_cast<std::uint32_t>(m.points.size());
    for (std::size_t row = 1; row <= rows; ++row)
      for (const std::uint32_t v : s.vertices) {
        const double way_mm = static_cast<double>(row) / static_cast<double>(rows) *
                              (length_mm - (m.points[v] - s.centre_mm).dot(s.axis));
        m.points.push_back(s.swept(m.points[v], v, way_mm));
        if (!m.metric.empty()) m.metric.push_back(m.metric[v]);
        if (!m.sizes_mm.empty()) m.sizes_mm.push_back(m.sizes_mm[v]);
      }
  }

  /// Faces on the edges where the section's label ends: each goes on with the patch that meets it there.
  void add_sides(const SweptSection& s, std::size_t rows, bool splits) {
    std::map<std::uint64_t, std::pair<std::size_t, std::int32_t>>
        besides;  // Count of the section's faces; patch.
    std::vector<bool> is_of_section(mesh().points.size(), false);
    for (const std::uint32_t v : s.vertices) is_of_section[v] = true;
    for_each_patch_face(mesh(), [&](std::span<const std::uint32_t> face, std::int32_t p) {
      for_each_edge_of(face, [&](std::uint32_t from, std::uint32_t to) {
        if (!is_of_section[from] || !is_of_section[to]) return;
        auto& [count, other] = besides.try_emplace(edge_key(from, to), 0, -1).first->second;
        if (s.has(p))
          ++count;
        else
          other = p;
      });
    });
    for (const PatchFace& face : s.faces)
      for_each_edge_of(face.corners, [&](std::uint32_t a, std::uint32_t b) {
        const auto& [count, beside] = besides.at(edge_key(a, b));
        const std::int32_t p = side_patch(beside, face.label);
        // Between two labels the side belongs to the first of its patch.
        if (p < 0 || (count != 1 && patch(p).labels[0] != face.label)) return;
        for (std::size_t row = 0; row < rows; ++row)
          add_side({vertex(s, a, row), vertex(s, b, row), vertex(s, b, row + 1), vertex(s, a, row + 1)}, p,
                   splits);
      });
  }

  /// The patch that goes on; where another opening meets the section at an edge, the label's wall.
  [[nodiscard]] std::int32_t side_patch(std::int32_t beside, Label label) const {
    if (beside < 0 || patch(beside).kind != PatchKind::kOpening) return beside;
    std::int32_t wall = -1;
    for (std::size_t p = 0; p < patches().size(); ++p)
      if (patches()[p].kind == PatchKind::kWall && (wall < 0 || patches()[p].labels[0] == label)) {
        wall = static_cast<std::int32_t>(p);
        if (patches()[p].labels[0] == label) break;
      }
    if (wall < 0)
      throw Error(ErrorKind::kBadInput,
                  fmt::format("{}: {} ends at an edge beside the section, and there is no wall "
                              "to go on instead",
                              option_name("extend"), patch(beside).name));
    return wall;
  }

  void add_side(const Cell<4>& side, std::int32_t p, bool splits) {
    MixedMesh& m = result_.mesh;
    if (!splits) {
      m.quadrilaterals.push_back(side);
      m.quadrilateral_patches.push_back(p);
      return;
    }
    CellTriangles halves;
    halves.add_quad(side);  // From the lowest corner on, as split_into_tetrahedra() has it.
    m.triangles.insert(m.triangles.end(), halves.begin(), halves.end());
    m.triangle_patches.insert(m.triangle_patches.end(), 2, p);
  }

  void add_prisms(const MixedMesh& prisms, bool splits) {
    MixedMesh& m = result_.mesh;
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    if (!splits) {
      append(m.prisms, prisms.prisms);
      append(m.prism_labels, prisms.prism_labels);
      return;
    }
    const MixedMesh split = split_into_tetrahedra(prisms.view());
    append(m.tetrahedra, split.tetrahedra);
    append(m.tetrahedron_labels, split.tetrahedron_labels);
  }

  void move_opening(const SweptSection& s, std::size_t rows) {
    MixedMesh& m = result_.mesh;
    for (std::size_t t = 0; t < m.triangles.size(); ++t)
      if (s.has(m.triangle_patches[t]))
        for (std::uint32_t& v : m.triangles[t]) v = vertex(s, v, rows);
    for (std::size_t q = 0; q < m.quadrilaterals.size(); ++q)
      if (s.has(m.quadrilateral_patches[q]))
        for (std::uint32_t& v : m.quadrilaterals[q]) v = vertex(s, v, rows);
  }

  static constexpr double kMaxRowOfRadius = 0.25;  // Ramps, and those to a circle, are smooth then.

  LayerCells cells_;
  std::optional<LocalLength> transition_;
  const AxisOfEnd& axis_of_end_;
  ExtrudedMesh result_;
  double wall_edge_mm_ = 0;      // The mean, before anything is extended.
  std::uint32_t first_new_ = 0;  // Of the sweep that is being made.
};

}  // namespace

ExtrudedMesh extrude_openings(const MixedMesh& mesh, std::span<const NamedLength> lengths, LayerCells cells,
                              const std::optional<LocalLength>& transition, const AxisOfEnd& axis_of_end) {
  return Extruder(mesh, cells, transition, axis_of_end).make(lengths);
}

}  // namespace lumesh
