#include "name_labels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lumesh/geometry/triangle.hpp"
#include "lumesh/mesh/patch_list.hpp"

namespace lumesh::report {

namespace {

constexpr std::size_t kMaxNames = 40;

std::size_t count_letters(const std::string& utf8) {
  return static_cast<std::size_t>(std::ranges::count_if(utf8, [](char c) { return (c & 0xC0) != 0x80; }));
}

double text_width(const std::string& text, double letter) {
  return (static_cast<double>(count_letters(text)) * kLetterWidth + 0.4) * letter;
}

struct Box {
  PixelPlace low, high;

  [[nodiscard]] bool touches(const Box& other) const {
    return low[0] < other.high[0] && other.low[0] < high[0] && low[1] < other.high[1] &&
           other.low[1] < high[1];
  }
  [[nodiscard]] bool contains(const PixelPlace& p) const {
    return low[0] < p[0] && p[0] < high[0] && low[1] < p[1] && p[1] < high[1];
  }
};

double turn(const PixelPlace& a, const PixelPlace& b, const PixelPlace& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

bool lines_cross(const PixelPlace& a, const PixelPlace& b, const PixelPlace& c, const PixelPlace& d) {
  return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

bool line_meets_box(const PixelPlace& a, const PixelPlace& b, const Box& box) {
  const PixelPlace &low = box.low, &high = box.high;
  return box.contains(a) || box.contains(b) || lines_cross(a, b, low, high) ||
         lines_cross(a, b, {low[0], high[1]}, {high[0], low[1]});
}

/// How many pixels of a rectangle show the object.
class Cover {
 public:
  explicit Cover(const Picture& picture)
      : width_(picture.width), height_(picture.height), sums_(at(0, height_ + 1), 0) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x)
        sums_[at(x + 1, y + 1)] = sums_[at(x, y + 1)] + sums_[at(x + 1, y)] - sums_[at(x, y)] +
                                  (picture.rgba[4 * (at(x, y) - static_cast<std::size_t>(y)) + 3] > 0);
  }

  /// As a share of the rectangle.
  [[nodiscard]] double of(const Box& box) const {
    const auto clamped = [](double value, int most) { return std::clamp(static_cast<int>(value), 0, most); };
    const int x = clamped(box.low[0], width_), y = clamped(box.low[1], height_),
              end_x = clamped(box.high[0] + 1, width_), end_y = clamped(box.high[1] + 1, height_);
    const std::uint32_t count =
        sums_[at(end_x, end_y)] + sums_[at(x, y)] - sums_[at(x, end_y)] - sums_[at(end_x, y)];
    return count / std::max(1.0, static_cast<double>(end_x - x) * (end_y - y));
  }

 private:
  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_ + 1) + static_cast<std::size_t>(x);
  }

  int width_, height_;
  std::vector<std::uint32_t> sums_;  ///< Of all pixels above and to the left.
};

/// A name, an arrow to `at`, and where both could be.
struct Place {
  Box box;
  PixelPlace from;
  double own_cost = 0;  ///< Whatever the other names do.
};
struct Name {
  PixelPlace at;
  std::vector<Place> places;
  const Place* chosen = nullptr;
};

/// Costs are in lengths of arrows, in letters: what is worth how long an arrow.
constexpr double kOverlap = 1e4, kCrossing = 150, kOverObject = 60, kOverOpening = 100, kTurned = 8;

double cost_beside(const Name& name, const Place& place, const Name& other) {
  double cost = place.box.contains(other.at) ? kOverOpening : 0;
  if (!other.chosen) return cost;
  const Place& there = *other.chosen;
  if (place.box.touches(there.box)) cost += kOverlap;
  if (lines_cross(name.at, place.from, other.at, there.from)) cost += kCrossing;
  if (line_meets_box(name.at, place.from, there.box)) cost += kCrossing;
  if (line_meets_box(other.at, there.from, place.box)) cost += kCrossing;
  return cost;
}

/// The part of an arrow that lies over the object, in letters; the first letter is free.
double length_over_object(const PixelPlace& at, const PixelPlace& from, double letter, const Cover& cover) {
  const double length = std::hypot(from[0] - at[0], from[1] - at[1]) / letter;
  const int steps = static_cast<int>(2 * length);
  int covered = 0;
  for (int i = 3; i <= steps; ++i) {
    const double share = (i - 0.5) / steps;
    const PixelPlace p = {at[0] + share * (from[0] - at[0]), at[1] + share * (from[1] - at[1])};
    covered += cover.of({p, p}) > 0;
  }
  return covered / 2.0;
}

/// Where names may go, and what that costs by itself.
class Surroundings {
 public:
  Surroundings(const Camera& camera, const Cover& cover, double letter)
      : width_(camera.width), height_(camera.height), letter_(letter), cover_(cover) {}

  /// @param way  Unit length, out of the opening on the screen.
  [[nodiscard]] std::vector<Place> places(const PixelPlace& at, const PixelPlace& way,
                                          double text_width) const {
    constexpr std::array<double, 10> kDistances = {1.8, 2.4, 3.2, 4.2, 5.5, 7.5, 10, 13, 17, 22};
    constexpr int kTurns = 12;  // Of 15 degrees to each side.
    std::vector<Place> result;
    for (int turn = -kTurns; turn <= kTurns; ++turn) {
      const double angle = turn * std::numbers::pi / kTurns;
      const PixelPlace direction = {way[0] * std::cos(angle) - way[1] * std::sin(angle),
                                    way[0] * std::sin(angle) + way[1] * std::cos(angle)};
      for (const double distance : kDistances) {
        Place place = place_at(at, direction, distance * letter_, text_width);
        place.own_cost += kTurned * (1 - std::cos(angle));
        result.push_back(place);
      }
    }
    return result;
  }

 private:
  [[nodiscard]] Place place_at(const PixelPlace& at, const PixelPlace& direction, double distance,
                               double width) const {
    const PixelPlace half = {width / 2, 0.65 * letter_}, size = {width_, height_};
    PixelPlace centre;
    for (std::size_t i = 0; i < 2; ++i) {
      const double least = half[i] + 0.3 * letter_;
      centre[i] = std::clamp(at[i] + direction[i] * (distance + half[i]), std::min(least, size[i] / 2),
                             std::max(size[i] - least, size[i] / 2));
    }
    const Box box = {{centre[0] - half[0], centre[1] - half[1]}, {centre[0] + half[0], centre[1] + half[1]}};
    const PixelPlace way = {centre[0] - at[0], centre[1] - at[1]};
    const double share = std::min(
        {1.0, half[0] / std::max(std::abs(way[0]), 1e-9), half[1] / std::max(std::abs(way[1]), 1e-9)});
    const PixelPlace from = {centre[0] - share * way[0], centre[1] - share * way[1]};
    const double length = std::hypot(from[0] - at[0], from[1] - at[1]) / letter_;
    return {box, from,
            length + 3 * length_over_object(at, from, letter_, cover_) + kOverObject * cover_.of(box) +
                (box.contains(at) || length < 1 ? kOverOpening : 0)};
  }

  double width_, height_, letter_;
  const Cover& cover_;
};

/// The point of an arrow whose opening is hidden: where the line to it comes to the object, a letter from its
/// end or more.
PixelPlace point_outside(const PixelPlace& at, const PixelPlace& from, double letter,
                         const Picture& picture) {
  const double length = std::hypot(at[0] - from[0], at[1] - from[1]);
  for (double along = letter; along < length; ++along) {
    const PixelPlace p = {from[0] + along / length * (at[0] - from[0]),
                          from[1] + along / length * (at[1] - from[1])};
    const int x = std::clamp(static_cast<int>(p[0]), 0, picture.width - 1),
              y = std::clamp(static_cast<int>(p[1]), 0, picture.height - 1);
    const auto pixel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x);
    if (picture.rgba[4 * pixel + 3] == 255) return p;
  }
  return at;
}

/// Gives each name the best of its places beside the others, until none moves any more.
void choose_places(std::vector<Name>& names) {
  constexpr int kMaxSweeps = 10;
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    bool moved = false;
    for (Name& name : names) {
      const Place* best = nullptr;
      double least = std::numeric_limits<double>::infinity();
      for (const Place& place : name.places) {
        double cost = place.own_cost;
        for (const Name& other : names)
          if (&other != &name && cost < least) cost += cost_beside(name, place, other);
        if (cost >= least) continue;
        least = cost;
        best = &place;
      }
      moved |= best != name.chosen;
      name.chosen = best;
    }
    if (!moved) return;
  }
}

/// Outward on the screen; where the opening faces the viewer, away from the middle of the picture.
PixelPlace way_out(const OpeningMark& mark, const PixelPlace& at, const Camera& camera) {
  const auto normal = camera.direction(mark.normal);
  const PixelPlace away = {at[0] - camera.width / 2.0, at[1] - camera.height / 2.0};
  const double distance = std::max(std::hypot(away[0], away[1]), 1e-9);
  const PixelPlace way = {normal[0] + 0.3 * away[0] / distance, -normal[1] + 0.3 * away[1] / distance};
  const double length = std::hypot(way[0], way[1]);
  return length > 1e-6 ? PixelPlace{way[0] / length, way[1] / length} : PixelPlace{0, -1};
}

/// What is known of a patch's triangles.
struct PatchSums {
  std::int32_t patch = 0;
  double area = 0;
  Vec3 centre = Vec3::Zero(), normal = Vec3::Zero();  // Times the area.
  Vec3 nearest = Vec3::Zero();                        // Middle of a triangle.
};

template <class Visit>
void for_each_opening_triangle(const MeshView& mesh, const quality::MeshSurface& surface,
                               const Visit& visit) {
  const std::vector<Patch>& patches = mesh.info->patches;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    const std::int32_t patch = surface.patches[i];
    if (surface.labels[i][1] != quality::kOutside || patch < 0) continue;
    if (static_cast<std::size_t>(patch) >= patches.size() ||
        !is_plane(patches[static_cast<std::size_t>(patch)].kind))
      continue;
    const Cell<3>& corners = surface.triangles[i];
    visit(static_cast<std::size_t>(patch), triangle_centre(mesh.points, corners),
          Vec3(triangle_area_normal(mesh.points, corners) / 2));
  }
}

}  // namespace

std::vector<OpeningMark> opening_marks(const MeshView& mesh, const quality::MeshSurface& surface) {
  std::vector<PatchSums> openings(mesh.info->patches.size());
  for (std::size_t p = 0; p < openings.size(); ++p) openings[p].patch = static_cast<std::int32_t>(p);
  for_each_opening_triangle(mesh, surface, [&](std::size_t patch, const Vec3& middle, const Vec3& normal) {
    openings[patch].area += normal.norm();
    openings[patch].centre += normal.norm() * middle;
    openings[patch].normal += normal;
    openings[patch].nearest = Vec3::Constant(std::numeric_limits<double>::infinity());
  });
  for (PatchSums& opening : openings)
    if (opening.area > 0) opening.centre /= opening.area;
  for_each_opening_triangle(mesh, surface, [&](std::size_t patch, const Vec3& middle, const Vec3&) {
    PatchSums& opening = openings[patch];
    if ((middle - opening.centre).norm() < (opening.nearest - opening.centre).norm())
      opening.nearest = middle;
  });
  std::erase_if(openings, [](const PatchSums& opening) { return !(opening.area > 0); });
  std::ranges::stable_sort(openings, [](const PatchSums& a, const PatchSums& b) { return a.area > b.area; });
  if (openings.size() > kMaxNames) openings.resize(kMaxNames);
  std::vector<OpeningMark> marks;
  for (const PatchSums& o : openings) {
    const bool is_in_the_middle = (o.nearest - o.centre).norm() < 0.3 * std::sqrt(o.area);
    marks.push_back({mesh.info->patches[static_cast<std::size_t>(o.patch)].name,
                     is_in_the_middle ? o.centre : o.nearest, o.normal / std::max(o.normal.norm(), 1e-300)});
  }
  return marks;
}

double letter_pixels(const Camera& camera) {
  constexpr double kPageWidth = 1064, kPageHeight = 620, kOnPage = 14;  // Of page_style.hpp.
  return kOnPage * std::max(camera.width / kPageWidth, camera.height / kPageHeight);
}

Margins margins_for(const std::vector<OpeningMark>& marks, double letter) {
  constexpr double kWidest = 14;  // Letters; longer names go above and below.
  if (marks.empty()) return {};
  double widest = 0;
  for (const OpeningMark& mark : marks) widest = std::max(widest, text_width(mark.name, letter));
  return {std::min(widest, kWidest * kLetterWidth * letter) + 2 * letter, 3 * letter};
}

bool is_behind(const Camera& camera, const Vec3& place, double margin_pixels,
               const std::vector<ScreenTriangle>& triangles) {
  const auto [x, y, depth] = camera.project(place);
  const PixelPlace p = {x, y};
  return std::ranges::any_of(triangles, [&, z = depth](const ScreenTriangle& t) {
    const auto corner = [&](std::size_t i) { return PixelPlace{t.corners[i][0], t.corners[i][1]}; };
    const std::array<double, 3> parts = {turn(p, corner(1), corner(2)), turn(corner(0), p, corner(2)),
                                         turn(corner(0), corner(1), p)};
    const auto [least, most] = std::minmax({parts[0], parts[1], parts[2]});
    if ((least < 0 && most > 0) || least == most) return false;
    const double sum = parts[0] + parts[1] + parts[2];
    return (parts[0] * t.corners[0][2] + parts[1] * t.corners[1][2] + parts[2] * t.corners[2][2]) / sum >
           z + margin_pixels;
  });
}

PictureLabels place_names(const std::vector<OpeningMark>& marks, const Camera& camera, const Picture& picture,
                          const std::vector<ScreenTriangle>& triangles, double letter) {
  if (marks.empty()) return {};
  const Cover cover(picture);
  const Surroundings surroundings(camera, cover, letter);
  std::vector<Name> names;
  for (const OpeningMark& mark : marks) {
    const auto [x, y, depth] = camera.project(mark.centre_mm);
    const PixelPlace at = {x, y};
    names.push_back({at, surroundings.places(at, way_out(mark, at, camera), text_width(mark.name, letter))});
  }
  choose_places(names);
  constexpr double kInFront = 3;  // Pixels: the opening's own triangles are not.
  PictureLabels result = {{}, letter};
  std::vector<Box> taken;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto& chosen = *names[i].chosen;
    const Box& box = chosen.box;
    if (std::ranges::any_of(taken, [&](const Box& other) { return other.touches(box); })) continue;
    taken.push_back(box);
    const bool hidden =
        marks[i].normal.dot(camera.toward) < 0 || is_behind(camera, marks[i].centre_mm, kInFront, triangles);
    const PixelPlace at = hidden ? point_outside(names[i].at, chosen.from, letter, picture) : names[i].at;
    result.labels.push_back({marks[i].name, at, chosen.from, box.low, box.high, hidden});
  }
  return result;
}

}  // namespace lumesh::report
