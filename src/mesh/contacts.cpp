#include "contacts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/core/place_text.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/geometry/triangle_tree.hpp"
#include "lumesh/parallel/key_table.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"

namespace lumesh::detail {
namespace {

/// A face of the surface of one part, by joined points.
struct PartFace {
  Cell<4> key;
  std::uint32_t part;
  FaceCorners outward;
  Label label;
  auto operator<=>(const PartFace&) const = default;
};

FaceCorners joined_face(const FaceCorners& face, const std::vector<std::uint32_t>& numbers) {
  return {numbers[face[0]], numbers[face[1]], numbers[face[2]], numbers[face[3]]};
}

bool has_shared_corners(const FaceCorners& face, const JoinedPoints& joined) {
  return std::ranges::all_of(face, [&](std::uint32_t v) { return joined.is_shared[v] != 0; });
}

std::vector<PartFace> faces_with_shared_corners(std::span<const PartSurface> parts,
                                                const JoinedPoints& joined) {
  std::vector<PartFace> all;
  for (std::uint32_t p = 0; p < parts.size(); ++p)
    for (std::size_t f = 0; f < parts[p].faces.size(); ++f) {
      const FaceCorners face = joined_face(parts[p].faces[f], joined.numbers[p]);
      if (has_shared_corners(face, joined)) all.push_back({key_of(face), p, face, parts[p].labels[f]});
    }
  parallel::sort(all.begin(), all.end());
  return all;
}

void add_triangles(const FaceCorners& face, std::vector<Cell<3>>& triangles) {
  triangles.push_back({face[0], face[1], face[2]});
  if (!is_triangle(face)) triangles.push_back({face[0], face[2], face[3]});
}

/// What of the surface of one part no other part shares, as triangles.
struct FreeSurface {
  std::vector<FaceCorners> faces;
  std::vector<Cell<3>> triangles;
};

FreeSurface free_surface(const PartSurface& part, const std::vector<std::uint32_t>& numbers,
                         std::span<const Contact> contacts) {
  FreeSurface surface;
  for (const FaceCorners& own : part.faces) {
    const FaceCorners face = joined_face(own, numbers);
    if (find_contact(contacts, face) != nullptr) continue;
    surface.faces.push_back(face);
    add_triangles(face, surface.triangles);
  }
  return surface;
}

/// Whether two triangles of one surface and this one of another are the halves of one quadrilateral by its
/// other diagonal. @param own  Keys of the faces of the first surface, sorted.
bool has_other_diagonal(const FaceCorners& face, const Cell<3>& other, std::span<const Cell<4>> own) {
  const auto is_of_face = [&](std::uint32_t v) { return std::ranges::find(face, v) != face.end(); };
  if (!is_triangle(face)) return true;
  if (std::ranges::count_if(other, is_of_face) != 2) return false;
  const std::uint32_t beyond = *std::find_if_not(other.begin(), other.end(), is_of_face);
  return std::ranges::any_of(face, [&](std::uint32_t left_out) {
    FaceCorners partner = face;
    std::ranges::replace(partner, left_out, beyond);
    const bool keeps_third = std::ranges::find(other, left_out) != other.end();
    return keeps_third && std::ranges::binary_search(own, key_of(partner));
  });
}

/// Whether a face lies on a surface that looks the other way. Where all its corners are shared with another
/// part, it may lie off the surface by as much as two diagonals of one bent quadrilateral do.
bool lies_on(const FaceCorners& face, std::span<const Cell<4>> own, const FreeSurface& other,
             const TriangleTree& tree, const JoinedPoints& joined) {
  constexpr double kOffBentFaces = 0.1, kOffSameFaces = 1e-3, kOpposite = -0.7;
  const std::span<const Vec3> points = joined.points;
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i)
    longest = std::max(longest, (points[face[i]] - points[face[(i + 1) % 4]]).norm());
  const double near = std::max(kOffSameFaces * longest, joined.tolerance),
               reach = has_shared_corners(face, joined) ? std::max(near, kOffBentFaces * longest) : near;
  const TriangleTree::Nearest nearest = tree.nearest(middle_of(points, face), reach);
  if (nearest.triangle == TriangleTree::kNone) return false;
  const Cell<3>& triangle = other.triangles[nearest.triangle];
  if (nearest.distance > near && !has_other_diagonal(face, triangle, own)) return false;
  return triangle_normal(points, {face[0], face[1], face[2]}).dot(triangle_normal(points, triangle)) <
         kOpposite;
}

/// For each part, the lowest number among the parts connected to it by shared faces.
std::vector<std::uint32_t> joined_groups(std::size_t count, std::span<const Contact> contacts) {
  DisjointSets groups(count);
  for (const Contact& contact : contacts) groups.merge(contact.parts[0], contact.parts[1]);
  std::vector<std::uint32_t> group(count);
  for (std::uint32_t part = 0; part < count; ++part) group[part] = groups.find(part);
  return group;
}

/// Least distance of a point of `from` to the surface of another part.
double distance_between(const PartSurface& from, const PartSurface& to) {
  std::vector<Cell<3>> triangles;
  for (const FaceCorners& face : to.faces) add_triangles(face, triangles);
  const TriangleTree tree(to.mesh->points, triangles);
  constexpr std::size_t kBlock = 1024;
  return parallel::reduce(
      from.points.size(), kBlock, std::numeric_limits<double>::infinity(),
      [&](double& smallest, std::size_t i) {
        smallest = std::min(smallest, tree.nearest(from.mesh->points[from.points[i]], smallest).distance);
      },
      [](double a, double b) { return std::min(a, b); });
}

}  // namespace

std::vector<Contact> find_contacts(std::span<const PartSurface> parts, const JoinedPoints& joined) {
  const std::vector<PartFace> faces = faces_with_shared_corners(parts, joined);
  std::vector<Contact> contacts;
  const auto same = [](const PartFace& a, const PartFace& b) { return a.key == b.key; };
  parallel::for_each_run(faces, same, [&](std::span<const PartFace> run) {
    if (run.size() < 2) return;
    const PartFace &one = run[0], &other = run[1];
    if (run.size() > 2 || !are_opposite(one.outward, other.outward))
      throw Error(ErrorKind::kBadInput,
                  fmt::format("{} and {} overlap: both have a cell on the same side of the face at {}; leave "
                              "one out, or cut away what both have",
                              parts[one.part].name, parts[other.part].name,
                              coordinates_text(middle_of(joined.points, one.outward))));
    contacts.push_back(
        {one.key, {one.outward, other.outward}, {one.part, other.part}, {one.label, other.label}});
  });
  return contacts;
}

const Contact* find_contact(std::span<const Contact> contacts, const FaceCorners& face) {
  const Cell<4> key = key_of(face);
  const auto found = std::ranges::lower_bound(contacts, key, {}, &Contact::key);
  return found != contacts.end() && found->key == key ? &*found : nullptr;
}

void check_surfaces_match(std::span<const PartSurface> parts, const JoinedPoints& joined,
                          std::span<const Contact> contacts) {
  std::vector<FreeSurface> surfaces;
  for (std::size_t p = 0; p < parts.size(); ++p)
    surfaces.push_back(free_surface(parts[p], joined.numbers[p], contacts));
  for (std::size_t to = 0; to < parts.size(); ++to) {
    if (surfaces[to].triangles.empty()) continue;
    const TriangleTree tree(joined.points, surfaces[to].triangles);
    for (std::size_t from = 0; from < parts.size(); ++from) {
      if (from == to) continue;
      const std::vector<FaceCorners>& faces = surfaces[from].faces;
      std::vector<Cell<4>> own;
      for (const FaceCorners& face : faces) own.push_back(key_of(face));
      parallel::sort(own.begin(), own.end());
      const std::vector<FaceCorners> faults =
          parallel::collect<FaceCorners>(faces.size(), [&](std::size_t f, std::vector<FaceCorners>& out) {
            if (lies_on(faces[f], own, surfaces[to], tree, joined)) out.push_back(faces[f]);
          });
      if (faults.empty()) continue;
      throw Error(
          ErrorKind::kBadInput,
          fmt::format("{} faces of {} lie on {} but differ from its own (points, diagonals, or farther "
                      "apart than {:.3g}), as at {}; remesh one, or `allow_gaps`",
                      faults.size(), parts[from].name, parts[to].name, joined.tolerance,
                      coordinates_text(middle_of(joined.points, faults.front()))));
    }
  }
}

void check_parts_touch(std::span<const PartSurface> parts, const JoinedPoints& joined,
                       std::span<const Contact> contacts) {
  const std::vector<std::uint32_t> groups = joined_groups(parts.size(), contacts);
  const auto alone = std::ranges::find_if(groups, [](std::uint32_t g) { return g != 0; });
  if (alone == groups.end()) return;
  const PartSurface& part = parts[static_cast<std::size_t>(alone - groups.begin())];
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (groups[p] != *alone) smallest = std::min(smallest, distance_between(part, parts[p]));
  throw Error(
      ErrorKind::kBadInput,
      fmt::format("{}: shares no face with the others; its points come within {:.3g} of their surface, in "
                  "the meshes' unit, and are joined within {:.3g}: give a larger `tolerance`, or see that "
                  "unit and frame are one",
                  part.name, smallest, joined.tolerance));
}

}  // namespace lumesh::detail
