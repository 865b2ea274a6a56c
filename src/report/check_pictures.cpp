#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include "checked_shape.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/geometry/triangle.hpp"
#include "lumesh/report/check_report.hpp"
#include "name_labels.hpp"
#include "scene.hpp"

namespace lumesh::report {

namespace {

constexpr Colour kMarkColour = {200, 0, 40};
constexpr double kCloseUpEdges = 20;  // From left to right, and as many voxels.

/// Places of a finding on the screen, so near to each other that one ring stands for all.
struct Mark {
  std::vector<std::size_t> places;  ///< Ascending, from 1 on.
  Vec3 first_mm;
  std::array<float, 3> at;
  bool is_hidden = false;  ///< Something is in front of the first one.

  /// Such as "1–3, 7".
  [[nodiscard]] std::string name() const {
    std::string text;
    for (std::size_t i = 0, end = 0; i < places.size(); i = end) {
      for (end = i + 1; end < places.size() && places[end] == places[end - 1] + 1;) ++end;
      text += (i > 0 ? ", " : "") + std::to_string(places[i]);
      if (end - i > 1) text += (end - i > 2 ? "–" : ", ") + std::to_string(places[end - 1]);
    }
    return text;
  }
};

/// Part of a ring around a pixel, as triangles before everything else.
void add_ring(const std::array<float, 3>& at, double inner, double outer, double depth, Colour colour,
              bool is_dashed, std::vector<ScreenTriangle>& out) {
  constexpr int kParts = 48, kDash = 4;
  const auto point = [&](int part, double radius) {
    const double angle = 2 * std::numbers::pi * part / kParts;
    return std::array<float, 3>{at[0] + static_cast<float>(radius * std::cos(angle)),
                                at[1] + static_cast<float>(radius * std::sin(angle)),
                                static_cast<float>(depth)};
  };
  for (int part = 0; part < kParts; ++part) {
    if (is_dashed && part % kDash >= kDash / 2) continue;
    const auto a = point(part, inner), b = point(part + 1, inner), c = point(part + 1, outer),
               d = point(part, outer);
    out.push_back({{a, b, c}, {0, 0, 1}, colour, 0, true});
    out.push_back({{a, c, d}, {0, 0, 1}, colour, 0, true});
  }
}

/// Height of a line in a picture that has half the width of the page, and how large rings are.
double letter_of_half(const Camera& camera) {
  return 2 * letter_pixels(camera);
}
double ring_radius(const Camera& camera) {
  return 0.62 * letter_of_half(camera);
}

/// Rings over a picture, dashed where something is in front of the place.
void draw_marks(const std::vector<Mark>& marks, const Camera& camera, int supersampling, Picture& picture) {
  constexpr Colour kHalo = {255, 255, 255};
  const double radius = ring_radius(camera), half = 0.16 * radius;
  std::vector<ScreenTriangle> rings;
  for (const Mark& mark : marks) {
    add_ring(mark.at, radius - 2 * half, radius + 2 * half, 0, kHalo, false, rings);
    add_ring(mark.at, radius - half, radius + half, 1, kMarkColour, mark.is_hidden, rings);
  }
  lay_over(picture, rasterise(rings, camera.width, camera.height, supersampling));
}

/// Marks of the places that the camera sees, numbered from 1 on in their order.
std::vector<Mark> marks_of(std::span<const Vec3> places, const Camera& camera, double depth_mm,
                           const std::vector<ScreenTriangle>& triangles) {
  constexpr double kLines = 3;  // Lines are drawn less than so many pixels in front of what they lie on.
  const double radius = ring_radius(camera), margin = std::max(kLines, depth_mm * camera.pixels_per_mm);
  std::vector<Mark> marks;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!in_view(camera, places.subspan(i, 1))) continue;
    const auto at = camera.project(places[i]);
    const auto near = std::ranges::find_if(
        marks, [&](const Mark& mark) { return std::hypot(mark.at[0] - at[0], mark.at[1] - at[1]) < radius; });
    if (near != marks.end())
      near->places.push_back(i + 1);
    else
      marks.push_back({{i + 1}, places[i], at, is_behind(camera, places[i], margin, triangles)});
  }
  return marks;
}

/// Numbers with arrows that end at the rings.
PictureLabels numbers_of(const std::vector<Mark>& marks, const Camera& camera, const Picture& picture) {
  std::vector<OpeningMark> named;
  for (const Mark& mark : marks) named.push_back({mark.name(), mark.first_mm, Vec3::Zero()});
  PictureLabels labels = place_names(named, camera, picture, {}, letter_of_half(camera));
  for (PictureLabel& label : labels.labels) {
    const Mark& mark =
        *std::ranges::find_if(marks, [&](const Mark& other) { return other.name() == label.text; });
    const double x = label.from[0] - mark.at[0], y = label.from[1] - mark.at[1];
    const double share = std::min(0.7, 1.3 * ring_radius(camera) / std::max(std::hypot(x, y), 1e-9));
    label.at = {mark.at[0] + share * x, mark.at[1] + share * y};
    label.is_hidden = mark.is_hidden;
  }
  return labels;
}

/// Meanings of the colours that are in a picture.
std::vector<LegendItem> legend_of(const Shape& shape) {
  const auto has_face = [&](const Colour& colour) {
    return std::ranges::any_of(shape.faces,
                               [&](const ShapeFace& face) { return face.colour.css() == colour.css(); });
  };
  const auto has_line = [&](const Colour& colour) {
    return std::ranges::any_of(shape.lines,
                               [&](const ShapeLine& line) { return line.colour.css() == colour.css(); });
  };
  std::vector<LegendItem> legend;
  if (has_face(kAtPlaceColour)) legend.push_back({"at the place", kAtPlaceColour});
  if (has_face(kSectionColour)) legend.push_back({"cut", kSectionColour});
  if (!shape.faces.empty() && shape.faces.front().has_inner_side)
    legend.push_back({"inner side", kInnerColour});
  if (has_line(kOpenEdgeColour)) legend.push_back({"edge of one triangle", kOpenEdgeColour});
  if (has_line(kCrowdedEdgeColour)) legend.push_back({"edge of three triangles or more", kCrowdedEdgeColour});
  return legend;
}

/// The shape from the side where it spreads most, and from the opposite one; each is drawn once.
class Overviews {
 public:
  /// @param depth_mm  How far inside of faces places may be that count as seen.
  Overviews(const Shape& shape, double depth_mm, const PictureOptions& options)
      : shape_(shape), depth_mm_(depth_mm), options_(options), points_(some_points(shape)) {
    const ViewAngles front = best_view(points_);
    toward_ = look_from(front.azimuth_deg, front.elevation_deg).toward;
    legend_ = legend_of(shape);
    for (std::size_t side = 0; side < 2; ++side) {
      Camera& camera = sides_[side].camera;
      camera = side == 0 ? look_from(front.azimuth_deg, front.elevation_deg)
                         : look_from(front.azimuth_deg + 180, -front.elevation_deg);
      frame_points(camera, points_, options.width);
      const double letter = letter_of_half(camera);
      frame_points(camera, points_, options.width, {3 * letter, 3 * letter});
    }
  }

  [[nodiscard]] const Vec3& toward() const { return toward_; }

  [[nodiscard]] SurfacePicture without_places() { return {drawn(0), legend_}; }

  void draw(std::span<const Vec3> places, FindingPictures& out) {
    std::array<std::vector<Mark>, 2> marks;
    std::array<std::ptrdiff_t, 2> seen = {0, 0};
    for (std::size_t side = 0; side < 2; ++side) {
      marks[side] = marks_of(places, sides_[side].camera, depth_mm_, triangles(side));
      seen[side] = std::ranges::count_if(marks[side], [](const Mark& mark) { return !mark.is_hidden; });
      if (seen[side] == static_cast<std::ptrdiff_t>(places.size())) break;
    }
    const std::size_t side = seen[1] > seen[0] ? 1 : 0;
    out.from_behind = side == 1;
    out.overview = {drawn(side), legend_};
    out.overview.names = numbers_of(marks[side], sides_[side].camera, out.overview.picture);
    draw_marks(marks[side], sides_[side].camera, options_.supersampling, out.overview.picture);
  }

 private:
  struct Side {
    Camera camera;
    std::optional<std::vector<ScreenTriangle>> triangles = std::nullopt;
    std::optional<Picture> picture = std::nullopt;
  };

  const std::vector<ScreenTriangle>& triangles(std::size_t side) {
    constexpr double kLinePixels = 3;
    Side& s = sides_[side];
    if (!s.triangles) s.triangles = on_screen(shape_, s.camera, kLinePixels);
    return *s.triangles;
  }
  const Picture& drawn(std::size_t side) {
    Side& s = sides_[side];
    if (!s.picture)
      s.picture = rasterise(triangles(side), s.camera.width, s.camera.height, options_.supersampling);
    return *s.picture;
  }

  const Shape& shape_;
  double depth_mm_;
  PictureOptions options_;
  std::vector<Vec3> points_;
  std::vector<LegendItem> legend_;
  Vec3 toward_ = Vec3::Zero();
  std::array<Side, 2> sides_;
};

/// How far along a ray a face is; a negative number if the ray misses it. from + t direction = a + u ab + v
/// ac by Cramer's rule: with D = ab . (direction x ac) and q = (from - a) x ab, t = ac . q / D. Source:
/// Möller and Trumbore 1997, doi:10.1080/10867651.1997.10487468.
double distance_along(const ShapeFace& face, const Vec3& from, const Vec3& direction) {
  const Vec3 ab = face.corners[1] - face.corners[0], ac = face.corners[2] - face.corners[0];
  const Vec3 across = direction.cross(ac);
  const double determinant = ab.dot(across);
  if (determinant == 0) return -1;
  const Vec3 from_a = from - face.corners[0], turned = from_a.cross(ab);
  const double u = from_a.dot(across) / determinant, v = direction.dot(turned) / determinant;
  constexpr double kEdge = 1e-6;  // What two faces share belongs to both.
  return u >= -kEdge && v >= -kEdge && u + v <= 1 + kEdge ? ac.dot(turned) / determinant : -1;
}

/// Whether a ray out of a place that meets nothing near it comes to a wall from within.
bool is_within(const Shape& whole, const Vec3& place, const Vec3& direction, double blind_mm) {
  double nearest = std::numeric_limits<double>::infinity();
  bool from_within = false;
  for (const ShapeFace& face : whole.faces) {
    const double distance = distance_along(face, place, direction);
    if (distance <= blind_mm || distance >= nearest) continue;
    nearest = distance;
    from_within = triangle_area_normal(face.corners[0], face.corners[1], face.corners[2]).dot(direction) > 0;
  }
  return from_within;
}

/// Mean outward normal near a place, weighed by area and distance; zero where the normals cancel.
Vec3 outward_at(const Shape& part, const Vec3& place, double reach_mm) {
  Vec3 sum = Vec3::Zero();
  double area = 0;
  for (const ShapeFace& face : part.faces) {
    const Vec3 normal = triangle_area_normal(face.corners[0], face.corners[1], face.corners[2]);
    const Vec3 middle = triangle_centre(face.corners[0], face.corners[1], face.corners[2]);
    const double weight = std::max(0.0, 1 - (middle - place).norm() / reach_mm);
    sum += weight * normal;
    area += weight * normal.norm();
  }
  return area > 0 ? Vec3(sum / area) : sum;
}

struct Look {
  Camera camera;
  bool sees_place = false;
};

/// A place, and what is around it.
struct Surrounded {
  const Shape& whole;
  Shape part;  ///< Near the place.
  Vec3 place;
  double reach_mm;        ///< How far that goes.
  double blind_mm;        ///< Faces of the part nearer than this are the place's own, …
  double blind_whole_mm;  ///< … and of the whole.
};

/// From where a place can be seen, if there is such a direction: along the normal if possible, else from
/// about where the overview is seen. What is not near the place does not hide it, but it may lie within that.
Look look_at(const Surrounded& at, const Vec3& usual) {
  const Vec3 outward = outward_at(at.part, at.place, at.reach_mm / 3);
  struct Candidate {
    double score;
    Camera camera;
  };
  std::vector<Candidate> all, seeing;
  for (const double elevation : {-58.0, -33.0, -11.0, 17.0, 39.0, 62.0})  // Askew to voxels.
    for (int step = 0; step < 16; ++step) {
      const Camera camera = look_from(22.5 * step + 8, elevation);
      const double score = outward.dot(camera.toward) + 0.3 * usual.dot(camera.toward);
      all.push_back({score, camera});
      const bool sees = std::ranges::none_of(at.part.faces, [&](const ShapeFace& face) {
        return distance_along(face, at.place, camera.toward) > at.blind_mm;
      });
      if (sees) seeing.push_back(all.back());
    }
  const auto is_better = [](const Candidate& a, const Candidate& b) { return a.score > b.score; };
  std::ranges::stable_sort(all, is_better);
  std::ranges::stable_sort(seeing, is_better);
  for (const Candidate& candidate : seeing)
    if (!is_within(at.whole, at.place, candidate.camera.toward, at.blind_whole_mm))
      return {candidate.camera, true};
  return {all.front().camera, false};
}

/// Sets what the camera shows.
void point_at(Camera& camera, const Vec3& place, double width_mm, int width) {
  camera.centre_mm = place;
  camera.width = width;
  camera.height = 3 * width / 4;
  camera.pixels_per_mm = width / width_mm;
}

CloseUp draw_close_up(const Shape& part, const Camera& camera, std::span<const Vec3> places, double depth_mm,
                      int supersampling) {
  constexpr double kLinePixels = 6;
  const std::vector<ScreenTriangle> triangles = on_screen(part, camera, kLinePixels);
  CloseUp close_up;
  close_up.drawn = {rasterise(triangles, camera.width, camera.height, supersampling), legend_of(part)};
  close_up.width_mm = camera.width / camera.pixels_per_mm;
  Picture& picture = close_up.drawn.picture;
  const std::vector<Mark> marks = marks_of(places.first(1), camera, depth_mm, triangles);
  close_up.drawn.names = numbers_of(marks, camera, picture);
  draw_marks(marks, camera, supersampling, picture);
  return close_up;
}

/// Without what lies before the plane through a place that looks to the viewer.
Shape cut_open(const Shape& part, const Vec3& place, const Vec3& toward) {
  Shape rest;
  for (const ShapeFace& face : part.faces) {
    const Vec3 middle = triangle_centre(face.corners[0], face.corners[1], face.corners[2]);
    if ((middle - place).dot(toward) <= 0) rest.faces.push_back(face);
  }
  for (const ShapeLine& line : part.lines)
    if ((line.from - place).dot(toward) <= 0) rest.lines.push_back(line);
  return rest;
}

constexpr double kReach = 0.75;  // What is drawn around a place, in widths of a close-up: its corners, too.

double mean_edge_mm(const Shape& shape) {
  double sum = 0;
  for (const ShapeFace& face : shape.faces)
    sum += (face.corners[0] - face.corners[1]).norm() + (face.corners[1] - face.corners[2]).norm() +
           (face.corners[2] - face.corners[0]).norm();
  return shape.faces.empty() ? 0 : sum / (3 * static_cast<double>(shape.faces.size()));
}

double diagonal_mm(const Shape& shape) {
  Box3 box;
  for (const ShapeFace& face : shape.faces)
    for (const Vec3& corner : face.corners) box.extend(corner);
  return shape.faces.empty() ? 0 : box.diagonal().norm();
}

double distance_to(const Shape& shape, const Vec3& place) {
  double least = std::numeric_limits<double>::infinity();
  for (const ShapeFace& face : shape.faces) {
    const auto& [a, b, c] = face.corners;
    least = std::min(least, (closest_point_on_triangle(place, a, b, c) - place).squaredNorm());
  }
  return std::sqrt(least);
}

CloseUp close_up_of(const Shape& shape, double mean_edge, double diagonal, std::span<const Vec3> places,
                    const Vec3& usual, const PictureOptions& options) {
  const Vec3& place = places[0];
  const double distance = distance_to(shape, place);
  // Edges near the place, which may be much shorter than elsewhere.
  const double local = mean_edge_mm(part_near(shape, place, distance + 3 * mean_edge));
  const double twenty_edges = kCloseUpEdges * (local > 0 ? std::max(local, mean_edge / 10) : mean_edge);
  const double width = std::max(std::min(twenty_edges, diagonal), 3 * distance);
  const double reach = kReach * width, blind = width / (2 * kCloseUpEdges);
  Surrounded at = {shape, part_near(shape, place, reach), place, reach, blind, blind};
  Look look = look_at(at, usual);
  if (!look.sees_place) at.part = cut_open(at.part, place, look.camera.toward);
  point_at(look.camera, place, width, options.width);
  CloseUp close_up = draw_close_up(at.part, look.camera, places, blind, options.supersampling);
  close_up.is_cut_open = !look.sees_place;
  return close_up;
}

/// The axis of the image, or its opposite, across which a section through a voxel has the longest outline.
Index3 section_axis(const LabelImage& image, const Index3& voxel, double reach_mm, const Vec3& usual) {
  const ImageFrame& frame = image.frame();
  const Index3 reach = (reach_mm / frame.spacing_mm.array()).ceil().cast<int>();
  const Index3 low = (voxel - reach).cwiseMax(0),
               high = (voxel + reach).cwiseMin(frame.size - Index3::Ones());
  std::array<int, 3> outline = {0, 0, 0};
  for (int axis = 0; axis < 3; ++axis) {
    Index3 first = low, last = high;
    first[axis] = last[axis] = voxel[axis];
    for_each_place(first, last, [&](const Index3& at) {
      for (int other = 0; other < 3; ++other) {
        Index3 next = at;
        if (other == axis || ++next[other] > last[other]) continue;
        outline[static_cast<std::size_t>(axis)] += (image.at(at) == 0) != (image.at(next) == 0);
      }
    });
  }
  const auto axis = std::ranges::max_element(outline) - outline.begin();
  Index3 result = Index3::Zero();
  result[axis] = frame.direction.col(axis).dot(usual) < 0 ? -1 : 1;
  return result;
}

/// Close to an axis of the image, but so that depth can be seen.
Camera look_at_section(const ImageFrame& frame, const Index3& axis) {
  const Vec3 normal = frame.direction * axis.cast<double>();
  Camera best;
  double most = -1;
  for (const double elevation : {-70.0, -20.0, 20.0, 70.0})
    for (int step = 0; step < 8; ++step) {
      const Camera camera = look_from(45 * step + 20, elevation);
      if (camera.toward.dot(normal) <= most) continue;
      most = camera.toward.dot(normal);
      best = camera;
    }
  return best;
}

CloseUp close_up_of(const LabelImage& image, const Shape& shape, const Finding& finding, const Vec3& usual,
                    const PictureOptions& options) {
  const Index3& voxel = finding.voxels[0];
  const Vec3& place = finding.places_mm[0];
  const Vec3& spacing = image.frame().spacing_mm;
  const double width = kCloseUpEdges * spacing.mean(), reach = kReach * width;
  const double own = 0.51 * spacing.norm();
  Surrounded at = {
      shape, part_near(image, voxel, reach, Index3::Zero()), place, reach, own, own + shape.inexact_mm};
  Look look = look_at(at, usual);
  if (!look.sees_place) {
    const Index3 axis = section_axis(image, voxel, reach, usual);
    at.part = part_near(image, voxel, reach, axis);
    look.camera = look_at_section(image.frame(), axis);
  }
  point_at(look.camera, place, width, options.width);
  CloseUp close_up = draw_close_up(at.part, look.camera, finding.places_mm, own, options.supersampling);
  close_up.is_cut_open = !look.sees_place;
  return close_up;
}

/// @param close_up  Of a finding that has places, seen from this direction if that is no matter.
CheckPictures draw_all(const Shape& shape, double depth_mm, std::span<const Finding> findings,
                       const PictureOptions& options,
                       const std::function<CloseUp(const Finding&, const Vec3&)>& close_up) {
  CheckPictures pictures;
  pictures.of_findings.resize(findings.size());
  const bool is_finite = std::ranges::all_of(shape.faces, [](const ShapeFace& face) {
    return (face.corners[0] + face.corners[1] + face.corners[2]).allFinite();
  });
  if (shape.faces.empty() || !is_finite) return pictures;
  Overviews overviews(shape, depth_mm, options);
  bool has_places = false;
  for (std::size_t i = 0; i < findings.size(); ++i) {
    if (findings[i].places_mm.empty()) continue;
    has_places = true;
    overviews.draw(findings[i].places_mm, pictures.of_findings[i]);
    pictures.of_findings[i].close_up = close_up(findings[i], overviews.toward());
  }
  if (!has_places) pictures.whole = overviews.without_places();
  return pictures;
}

}  // namespace

CheckPictures draw_check_pictures(const MeshView& mesh, std::span<const Finding> findings,
                                  const PictureOptions& options) {
  const Shape shape = shape_of(mesh);
  const double mean_edge = mean_edge_mm(shape), diagonal = diagonal_mm(shape);
  return draw_all(shape, 0.5 * mean_edge, findings, options, [&](const Finding& finding, const Vec3& usual) {
    return close_up_of(shape, mean_edge, diagonal, finding.places_mm, usual, options);
  });
}

CheckPictures draw_check_pictures(const LabelImage& image, std::span<const Finding> findings,
                                  const PictureOptions& options) {
  const Shape shape = shape_of(image);
  return draw_all(shape, image.frame().spacing_mm.norm(), findings, options,
                  [&](const Finding& finding, const Vec3& usual) {
                    return close_up_of(image, shape, finding, usual, options);
                  });
}

}  // namespace lumesh::report
