#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "commands.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/domain/image_domain.hpp"
#include "lumesh/image/label_image.hpp"
#include "lumesh/parallel/loops.hpp"
#include "shapes.hpp"

namespace lumesh::boundary {

namespace {

constexpr double kEndless = 1e6;
constexpr double kSampleMm = 0.1;
constexpr double kBadPercent = 5;

/// Places within a radius of a segment, which may be endless.
struct Vessel {
  Vec3 point = Vec3::Zero();
  Vec3 direction = Vec3::UnitZ();  ///< Unit.
  double radius = 0;
  double first = -kEndless, last = kEndless;  ///< Ends of the segment, along the direction from the point.

  /// < 0 inside.
  [[nodiscard]] double distance(const Vec3& p) const {
    const double along = std::clamp((p - point).dot(direction), first, last);
    return (p - point - along * direction).norm() - radius;
  }
  [[nodiscard]] Vec3 at_height(double z) const { return point + (z - point.z()) / direction.z() * direction; }
};

struct Scene {
  Index3 size = Index3::Zero();
  std::vector<Vessel> vessels;
  std::size_t measured = 0;  ///< The first ones, whose sections across z are.
};

struct OpeningCase {
  const char* name;
  double low_gap = 0, high_gap = 0;  ///< Range of the distance between the walls, at the border.
  Scene (*make)(const OpeningCase& of, Random random);
};

double between(Random& random, double low, double high) {
  return low + (high - low) * random.uniform();
}

/// Two parallel vessels, up to 40 degrees off z, side by side in a random direction.
Scene pair(const OpeningCase& of, Random random) {
  constexpr int kHeight = 36;
  const double one = between(random, 2, 7);
  const double other = random.uniform() < 0.5 ? between(random, 2, 7) : one;
  const double gap = between(random, of.low_gap, of.high_gap);
  const double tilt = between(random, 0, 40 * std::numbers::pi / 180);
  const double azimuth = between(random, 0, 2 * std::numbers::pi),
               turn = between(random, 0, 2 * std::numbers::pi);
  const Vec3 along(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
  const Vec3 across = along.cross(Vec3::UnitX()).normalized();
  const Vec3 apart = (one + other + gap) * (std::cos(turn) * across + std::sin(turn) * along.cross(across));
  const int width = static_cast<int>(4 * (one + other) + gap + kHeight * std::tan(tilt) * 1.2 + 14);
  const Vec3 centre =
      0.5 * Vec3(width, width, kHeight) + random.in_box(Vec3::Constant(-0.5), Vec3::Constant(0.5));
  return {{width, width, kHeight}, {{centre - apart / 2, along, one}, {centre + apart / 2, along, other}}, 2};
}

Scene alone(const OpeningCase& of, Random random) {
  Scene scene = pair(of, random);
  scene.vessels.pop_back();
  scene.measured = 1;
  return scene;
}

/// A pair that a rod joins in the middle of the image.
Scene joined(const OpeningCase& of, Random random) {
  Scene scene = pair(of, random);
  const Vec3 from = scene.vessels[0].point, way = scene.vessels[1].point - from;
  scene.vessels.push_back({from, way.normalized(), 2, 0, way.norm()});
  return scene;
}

/// Two legs of one radius that leave a trunk at 8 to 20 degrees, cut where they are a gap apart.
Scene fork(const OpeningCase& of, Random random) {
  const double radius = between(random, 2, 5), half_angle = between(random, 8, 20) * std::numbers::pi / 180;
  const double azimuth = between(random, 0, 2 * std::numbers::pi);
  const double gap = between(random, of.low_gap, of.high_gap);
  const double length = (radius / std::cos(half_angle) + gap / 2) / std::tan(half_angle);
  const int height = static_cast<int>(length + 12) + 1, width = static_cast<int>(2 * (2 * radius + gap) + 16);
  const Vec3 aside = std::sin(half_angle) * Vec3(std::cos(azimuth), std::sin(azimuth), 0);
  const Vec3 up = std::cos(half_angle) * Vec3::UnitZ();
  const Vec3 crotch(width / 2.0 + between(random, -0.5, 0.5), width / 2.0 + between(random, -0.5, 0.5),
                    height - 0.5 - length);
  return {{width, width, height},
          {{crotch, up + aside, radius, 0},
           {crotch, up - aside, radius, 0},
           {crotch, Vec3::UnitZ(), radius, -kEndless, 0}},
          2};
}

constexpr std::array<OpeningCase, 8> kCases = {{{"alone", 1.5, 3, alone},
                                                {"gap-0.8-1.6", 0.8, 1.6, pair},
                                                {"gap-1.5-3", 1.5, 3, pair},
                                                {"gap-3-5", 3, 5, pair},
                                                {"rod-0.8-1.6", 0.8, 1.6, joined},
                                                {"rod-1.5-3", 1.5, 3, joined},
                                                {"rod-3-5", 3, 5, joined},
                                                {"fork", 1.5, 4, fork}}};

/// @param inside  Whether a voxel is, by its centre.
template <class Inside>
LabelImage image_of(const Index3& size, const Inside& inside) {
  ImageFrame frame;
  frame.size = size;
  LabelImage image(frame, {0, 1});
  for_each_place(Index3::Zero(), size - Index3::Ones(),
                 [&](const Index3& voxel) { image.at(voxel) = inside(voxel.cast<double>()); });
  return image;
}

LabelImage image_of(const Scene& scene) {
  return image_of(scene.size, [&](const Vec3& p) {
    return std::ranges::any_of(scene.vessels, [&](const Vessel& v) { return v.distance(p) < 0; });
  });
}

/// A ball of 6 voxels in radius, two plates and two rods of random directions through its middle, out to 20.
LabelImage tangle(Random random) {
  const std::array<Vec3, 4> directions = {random.direction(), random.direction(), random.direction(),
                                          random.direction()};
  const Vec3 centre(23.4, 23.6, 23.3);
  return image_of({48, 48, 48}, [&](const Vec3& p) {
    const Vec3 d = p - centre;
    const auto in_plate = [&](const Vec3& n) { return std::abs(n.dot(d)) < 1.4; };
    const auto in_rod = [&](const Vec3& n) { return (d - n.dot(d) * n).norm() < 1.8; };
    return d.norm() < 6 || (d.norm() < 20 && (in_plate(directions[0]) || in_plate(directions[1]) ||
                                              in_rod(directions[2]) || in_rod(directions[3])));
  });
}

/// Largest distance from a place to the nearest voxel of its label, in voxels; 3 stands for more.
double furthest_from_own_voxels(const LabelImage& image, const ImageDomain& domain) {
  constexpr int kReach = 3;
  constexpr double kStep = 0.25;
  const Index3& size = image.frame().size;
  const Index3 steps = ((size - Index3::Constant(3)).cast<double>() / kStep).cast<int>();
  std::vector<double> furthest(static_cast<std::size_t>(steps.z() + 1), 0);
  parallel::for_each_index(furthest.size(), 1, [&](std::size_t layer) {
    const int z = static_cast<int>(layer);
    for_each_place({0, 0, z}, {steps.x(), steps.y(), z}, [&](const Index3& step) {
      const Vec3 p = Vec3::Ones() + kStep * step.cast<double>();
      const bool is_inside = domain.label_at(p) != 0;
      const Index3 voxel = p.array().round().cast<int>();
      if ((image.at(voxel) != 0) == is_inside) return;
      double nearest = kReach;
      for_each_place((voxel - Index3::Constant(kReach)).cwiseMax(0),
                     (voxel + Index3::Constant(kReach)).cwiseMin(size - Index3::Ones()),
                     [&](const Index3& v) {
                       if ((image.at(v) != 0) != is_inside) return;
                       const Vec3 off = (p - v.cast<double>()).cwiseAbs() - Vec3::Constant(0.5);
                       nearest = std::min(nearest, off.cwiseMax(0).norm());
                     });
      furthest[layer] = std::max(furthest[layer], nearest);
    });
  });
  return *std::ranges::max_element(furthest);
}

/// Error in per cent of the area that a domain has of one vessel at a height, among the places that are
/// nearer to it than to the other measured ones.
double section_error(const Scene& scene, const ImageDomain& domain, std::size_t number, double z) {
  constexpr double kReach = 2;  // mm from the wall
  const Vessel& vessel = scene.vessels[number];
  const Vec3 middle = vessel.at_height(z);
  const double half = vessel.radius / vessel.direction.z() + kReach;
  long count = 0, truth = 0;
  const auto is_nearer = [&](const Vec3& p, double distance) {
    for (std::size_t other = 0; other < scene.measured; ++other)
      if (other != number && scene.vessels[other].distance(p) < distance) return false;
    return true;
  };
  for (double y = middle.y() - half; y < middle.y() + half; y += kSampleMm) {
    for (double x = middle.x() - half; x < middle.x() + half; x += kSampleMm) {
      const Vec3 p(x, y, z);
      const double distance = vessel.distance(p);
      if (distance > kReach || !is_nearer(p, distance)) continue;
      truth += distance < 0 ? 1 : 0;
      count += domain.label_at(p) != 0 ? 1 : 0;
    }
  }
  return 100.0 * (static_cast<double>(count) / static_cast<double>(truth) - 1);
}

/// Errors of one case's sections, by the radius of their vessel.
struct SectionErrors {
  static constexpr std::array<double, 4> kRadii = {2, 3, 4.5, 7};
  struct Class {
    Summary all;
    double worst = 0;
    int count = 0, bad = 0;
  };
  std::array<Class, kRadii.size() - 1> classes = {};

  void add(double radius, double error) {
    std::size_t number = 0;
    while (number + 1 < classes.size() && radius >= kRadii[number + 1]) ++number;
    Class& c = classes[number];
    c.all.add(error);
    if (std::abs(error) > std::abs(c.worst)) c.worst = error;
    ++c.count;
    c.bad += std::abs(error) > kBadPercent ? 1 : 0;
  }

  [[nodiscard]] bool is_empty() const {
    return std::ranges::all_of(classes, [](const Class& c) { return c.count == 0; });
  }

  void print(const std::string& name, const char* place) const {
    fmt::print("{:<12} {:<7}", name, place);
    for (const Class& c : classes) {
      if (c.count == 0)
        fmt::print(" | {:>28}", "-");
      else
        fmt::print(" | {:>5.1f} {:>6.1f} {:>7.1f} {:>3}/{:<4}", c.all.root_mean_square(), c.all.mean(),
                   c.worst, c.bad, c.count);
    }
    fmt::print("\n");
  }
};

/// Heights of the sections at the border, which the field just reaches, and of those inside.
std::vector<double> border_heights(const Scene& scene) {
  const double top = scene.size.z() - 0.501;
  return scene.vessels[0].first < 0 ? std::vector<double>{-0.499, top} : std::vector<double>{top};
}
std::vector<double> inner_heights(const Scene& scene) {
  if (scene.vessels.size() > scene.measured) return {};  // A rod or a trunk is there.
  return {7, 12, 17.5, 23, 28};
}

void measure_case(const OpeningCase& of, const RunOptions& options, JsonLines& lines) {
  SectionErrors at_border, inside;
  for (int seed = options.first_seed; seed < options.first_seed + options.seeds; ++seed) {
    const Scene scene = of.make(of, Random(seed_of("openings", static_cast<std::uint64_t>(seed))));
    const ImageDomain domain(image_of(scene), ImageDomainOptions{});
    const auto measure = [&](std::size_t number, double z, SectionErrors& errors) {
      const double radius = scene.vessels[number].radius, error = section_error(scene, domain, number, z);
      errors.add(radius, error);
      lines.write(
          {{"case", of.name}, {"seed", seed}, {"radius_voxels", radius}, {"z", z}, {"percent", error}});
    };
    for (std::size_t number = 0; number < scene.measured; ++number) {
      for (const double z : border_heights(scene)) measure(number, z, at_border);
      for (const double z : inner_heights(scene)) measure(number, z, inside);
    }
  }
  at_border.print(of.name, "border");
  if (!inside.is_empty()) inside.print(of.name, "inside");
  std::fflush(stdout);
}

void measure_tangles(const RunOptions& options, JsonLines& lines) {
  double furthest = 0;
  for (int seed = options.first_seed; seed < options.first_seed + options.seeds; ++seed) {
    const LabelImage image = tangle(Random(seed_of("tangle", static_cast<std::uint64_t>(seed))));
    const double of_seed = furthest_from_own_voxels(image, ImageDomain(image, ImageDomainOptions{}));
    lines.write({{"case", "tangle"}, {"seed", seed}, {"furthest_voxels", of_seed}});
    furthest = std::max(furthest, of_seed);
  }
  fmt::print("tangle: up to {:.2f} voxels from a place to the nearest voxel of its label\n", furthest);
}

}  // namespace

void run_openings(const RunOptions& options) {
  JsonLines lines(options.json_path);
  fmt::print(
      "Areas of sections against the exact ones, errors in per cent: r.m.s., mean, worst, and how many are "
      "off "
      "by more\nthan {}, by the vessel's radius in voxels.\n{:<12} {:<7}",
      kBadPercent, "case", "place");
  for (std::size_t i = 0; i + 1 < SectionErrors::kRadii.size(); ++i)
    fmt::print(" | {:>28}", fmt::format("{} to {}", SectionErrors::kRadii[i], SectionErrors::kRadii[i + 1]));
  fmt::print("\n");
  for (const OpeningCase& of : kCases)
    if (matches(of.name, options)) measure_case(of, options, lines);
  if (matches("tangle", options)) measure_tangles(options, lines);
}

}  // namespace lumesh::boundary
