#include "shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "lumesh/image/crossings.hpp"
#include "lumesh/image/topology.hpp"

namespace lumesh::boundary {

namespace {

/// Sharp edges make smooth surfaces deviate as far as this.
constexpr double kCreaseReach = 2.5;

struct TubeDirection {
  std::string name;
  double degrees_off_x = -1;  ///< < 0: the direction itself is given.
  Vec3 direction = Vec3::Zero();
};

std::vector<TubeDirection> tube_directions() {
  return {{"axis", 0},
          {"2deg", 2},
          {"5deg", 5},
          {"15deg", 15},
          {"110", -1, {1, 1, 0}},
          {"oblique", -1, {1, 0.82, 0.64}}};
}

ImageFrame frame_of(const Vec3& extent_mm, double z_edge_mm) {
  ImageFrame frame;
  frame.spacing_mm = Vec3(1, 1, z_edge_mm);
  for (int axis = 0; axis < 3; ++axis)
    frame.size[axis] = static_cast<int>(std::ceil(extent_mm[axis] / frame.spacing_mm[axis])) +
                       (frame.spacing_mm[axis] > 1 ? 2 : 0);
  return frame;
}

Vec3 middle_of(const ImageFrame& frame) {
  return 0.5 * (frame.size.cast<double>() - Vec3::Ones()).cwiseProduct(frame.spacing_mm);
}

double depth_in_tube(const Vec3& point, const Tube& tube) {
  const Vec3 from_centre = point - tube.centre_mm;
  return tube.radius_mm - (from_centre - from_centre.dot(tube.direction) * tube.direction).norm();
}

/// A tube with round ends whose radius may change linearly.
double depth_in_branch(const Vec3& point, const Vec3& from, const Vec3& to, double radius) {
  const Vec3 along = to - from;
  const double t = std::clamp((point - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return radius - (point - from - t * along).norm();
}

Shape straight_tube(double radius, const TubeDirection& direction, double z_edge, Random random) {
  constexpr double kLength = 72;  // Two terraces of a tube two degrees off an axis.
  constexpr double kMargin = 12;
  constexpr double kObliqueExtra = 44;
  Shape shape;
  Tube tube;
  tube.radius_mm = shape.radius_mm = radius;
  if (direction.degrees_off_x >= 0) {
    const double angle = direction.degrees_off_x * std::numbers::pi / 180;
    const double azimuth = random.uniform() * 2 * std::numbers::pi;
    tube.direction =
        Vec3(std::cos(angle), std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth));
    const double width = 2 * radius + kMargin + kLength * std::tan(angle);
    shape.frame = frame_of({kLength, width, width}, z_edge);
  } else {
    tube.direction = direction.direction.normalized();
    const double width = 2 * radius + kObliqueExtra;
    shape.frame =
        frame_of({width, width, direction.direction.z() == 0 ? 2 * radius + kMargin : width}, z_edge);
  }
  const Vec3 half = 0.5 * shape.frame.spacing_mm;
  tube.centre_mm = middle_of(shape.frame) + random.in_box(-half, half);
  shape.tube = tube;
  shape.depth_mm = [tube](const Vec3& p) { return depth_in_tube(p, tube); };
  return shape;
}

/// A shape in the middle of an image, but for less than a voxel.
struct Placed {
  Shape shape;
  Vec3 middle;
};

Placed placed(const Index3& size, double radius, Random& random) {
  Placed result;
  result.shape.frame.size = size;
  result.shape.radius_mm = radius;
  result.middle = middle_of(result.shape.frame) + random.in_box(Vec3::Constant(-0.5), Vec3::Constant(0.5));
  return result;
}

Shape torus(Random random) {
  auto [shape, c] = placed({64, 64, 40}, 4, random);
  const Vec3 axis = Vec3(0.3 * random.uniform(), 0.3 * random.uniform(), 1).normalized();
  shape.depth_mm = [c, axis](const Vec3& p) {
    const double height = (p - c).dot(axis);
    return 4 - std::hypot((p - c - height * axis).norm() - 20, height);
  };
  return shape;
}

Shape sphere(Random random) {
  auto [shape, c] = placed({32, 32, 32}, 8, random);
  shape.depth_mm = [c](const Vec3& p) { return 8 - (p - c).norm(); };
  return shape;
}

/// A ball that grows out of a tube, as an aneurysm does.
Shape sac(Random random) {
  auto [shape, middle] = placed({56, 48, 56}, 4, random);
  const Tube tube{middle - Vec3(0, 0, 11.5),
                  Vec3(1, 0.2 * random.uniform(), 0.2 * random.uniform()).normalized(), 4};
  const Vec3 ball = tube.centre_mm + Vec3(0, 2, 11);
  const auto parts = [tube, ball](const Vec3& p) {
    return std::minmax({depth_in_tube(p, tube), 8 - (p - ball).norm()});
  };
  shape.depth_mm = [parts](const Vec3& p) { return parts(p).second; };
  shape.near_crease = [parts](const Vec3& p) { return parts(p).first > -kCreaseReach; };
  return shape;
}

Shape cone(Random random) {
  auto [shape, middle] = placed({80, 28, 28}, 2, random);
  const Vec3 c = middle - Vec3(39.5, 0, 0);
  const Vec3 axis = Vec3(1, 0.03, 0.02).normalized();
  const double slope = 5.0 / 80;
  shape.depth_mm = [c, axis, slope](const Vec3& p) {
    const double along = (p - c).dot(axis);
    return (7 - slope * along - (p - c - along * axis).norm()) / std::sqrt(1 + slope * slope);
  };
  return shape;
}

/// A tube with a throat; the narrowing is a Gaussian along the axis, exp(-s^2 / square_of_length).
Shape stenosis_of(double radius, double throat, double square_of_length, Random random) {
  auto [shape, c] = placed({72, 24, 24}, 2.5, random);
  const Vec3 axis = Vec3(1, 0.05, 0.03).normalized();
  shape.depth_mm = [=, c = c](const Vec3& p) {
    const double along = (p - c).dot(axis);
    const double narrowing = (radius - throat) * std::exp(-along * along / square_of_length);
    const double slope = narrowing * along / (square_of_length / 2);
    return (radius - narrowing - (p - c - along * axis).norm()) / std::sqrt(1 + slope * slope);
  };
  return shape;
}

Shape stenosis(Random random) {
  return stenosis_of(5, 2.5, 32, random);
}

Shape short_stenosis(Random random) {
  return stenosis_of(2.7, 1.7, 8.4, random);
}

Shape fork(Random random) {
  auto [shape, middle] = placed({72, 64, 28}, 3.2, random);
  const Vec3 c = middle - Vec3(5.5, 0, 0);
  const auto depths = [c](const Vec3& p) {
    std::array<double, 3> d = {depth_in_branch(p, c, c + Vec3(-60, 0, 0), 4.5),
                               depth_in_branch(p, c, c + Vec3(60, 34, 3), 3.5),
                               depth_in_branch(p, c, c + Vec3(60, -38, -3), 3.2)};
    std::sort(d.begin(), d.end());
    return d;
  };
  shape.depth_mm = [depths](const Vec3& p) { return depths(p)[2]; };
  shape.near_crease = [depths](const Vec3& p) { return depths(p)[1] > -kCreaseReach; };
  return shape;
}

Shape two_tubes(Random random) {
  auto [shape, c] = placed({64, 40, 28}, 5, random);
  const Vec3 direction = Vec3(1, 0.06, 0.03).normalized();
  const Vec3 apart(0, 5 + 0.5 * (1 + random.uniform()), 0);  // A gap of one to two voxels.
  const Tube one{c - apart, direction, 5};
  const Tube other{c + apart, direction, 5};
  shape.depth_mm = [one, other](const Vec3& p) {
    return std::max(depth_in_tube(p, one), depth_in_tube(p, other));
  };
  return shape;
}

Shape plate(const Index3& size, const Vec3& normal, double thickness, const Vec3& middle) {
  Shape shape;
  shape.frame.size = size;
  shape.radius_mm = 0.5 * thickness;
  const Vec3 n = normal.normalized();
  shape.depth_mm = [n, thickness, middle](const Vec3& p) {
    return 0.5 * thickness - std::abs((p - middle).dot(n));
  };
  return shape;
}

Shape flat_plate(Random) {
  return plate({40, 40, 20}, Vec3::UnitZ(), 1, {0, 0, 10});
}

Shape oblique_plate(Random random) {
  const Vec3 middle = Vec3::Constant(19.5) + random.in_box(Vec3::Constant(-0.5), Vec3::Constant(0.5));
  return plate({40, 40, 40}, {0.2, 0.1, 1}, 1.5, middle);
}

Shape line(Random) {
  Shape shape;
  shape.frame.size = {40, 20, 20};
  shape.radius_mm = 0.5;
  shape.depth_mm = [](const Vec3& p) { return 0.5 - std::max(std::abs(p.y() - 10), std::abs(p.z() - 10)); };
  return shape;
}

/// A tube that leaves through four faces of the image.
Shape cut_tube(Random random) {
  auto [shape, c] = placed({48, 48, 28}, 5, random);
  const Tube tube{c, Vec3(0.55, 0.8, 0.25).normalized(), 5};
  shape.tube = tube;
  shape.depth_mm = [tube](const Vec3& p) { return depth_in_tube(p, tube); };
  return shape;
}

Case plain(const std::string& name, const std::function<Shape(Random)>& make) {
  return {name, {}, [name, make](std::uint64_t seed) {
            Shape shape = make(Random(seed_of(name, seed)));
            shape.name = name;
            return shape;
          }};
}

std::string short_number(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

Case tube_case(double radius, const TubeDirection& direction, double z_edge = 1) {
  const std::string name = "tube-R" + short_number(radius) + "-" + direction.name +
                           (z_edge == 1 ? "" : "-1:1:" + short_number(z_edge));
  return plain(name, [=](Random random) { return straight_tube(radius, direction, z_edge, random); });
}

/// The same shape at the same places, with wrong labels.
Case with_error(const Case& shape, const LabelError& error) {
  const std::string prefix =
      error.told == Told::kRamp        ? "ramp" + short_number(error.value_noise) + "-"
      : error.told == Told::kVolumes   ? "volumes" + short_number(error.value_noise) + "-"
      : error.told == Told::kThreshold ? "threshold" + short_number(error.value_noise) + "-"
      : error.flipped_share > 0        ? "flips" + short_number(100 * error.flipped_share) + "%-"
                                       : "shift" + short_number(error.correlated_mm) + "-";
  return {prefix + shape.name, error, shape.make};
}

std::vector<std::uint8_t> neighbours_differ(const LabelImage& image) {
  const ImageFrame& f = image.frame();
  std::vector<std::uint8_t> differs(f.voxel_count(), 0);
  for (int k = 0; k < f.size.z(); ++k)
    for (int j = 0; j < f.size.y(); ++j)
      for (int i = 0; i < f.size.x(); ++i)
        for (int axis = 0; axis < 3; ++axis) {
          const Index3 v(i, j, k);
          const Index3 w = v + Index3::Unit(axis);
          if (!f.contains(w) || image.at(v) == image.at(w)) continue;
          differs[f.offset(v)] = differs[f.offset(w)] = 1;
        }
  return differs;
}

void blur_along(std::vector<double>& values, const ImageFrame& frame, int axis, double sigma) {
  const int reach = static_cast<int>(std::ceil(4 * sigma));
  std::vector<double> weights;
  double total = 0;
  for (int d = -reach; d <= reach; ++d)
    total += weights.emplace_back(std::exp(-0.5 * d * d / (sigma * sigma)));
  std::vector<double> out(values.size());
  for (int k = 0; k < frame.size.z(); ++k)
    for (int j = 0; j < frame.size.y(); ++j)
      for (int i = 0; i < frame.size.x(); ++i) {
        Index3 v(i, j, k);
        const int at = v[axis];
        double sum = 0;
        for (int d = -reach; d <= reach; ++d) {
          v[axis] = std::clamp(at + d, 0, frame.size[axis] - 1);
          sum += weights[static_cast<std::size_t>(d + reach)] * values[frame.offset(v)];
        }
        v[axis] = at;
        out[frame.offset(v)] = sum / total;
      }
  values.swap(out);
}

/// Smooth random numbers of mean 0 and standard deviation 1, alike within a voxel or two.
std::vector<double> correlated_noise(const ImageFrame& frame, Random random) {
  constexpr double kSigma = 1.5;
  std::vector<double> values(frame.voxel_count());
  for (double& value : values) value = random.normal();
  for (int axis = 0; axis < 3; ++axis) blur_along(values, frame, axis, kSigma);
  double mean = 0, square = 0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  for (const double value : values)
    square += (value - mean) * (value - mean) / static_cast<double>(values.size());
  for (double& value : values) value = (value - mean) / std::sqrt(square);
  return values;
}

/// The share of a voxel that is inside, by 8 x 8 x 8 samples.
double share_inside(const Shape& shape, const Index3& voxel) {
  constexpr int kSamples = 8;
  const Vec3& edges = shape.frame.spacing_mm;
  const Vec3 centre = shape.frame.to_physical(voxel.cast<double>());
  const double depth = shape.depth_mm(centre);
  if (std::abs(depth) > 1.2 * edges.norm()) return depth > 0 ? 1 : 0;
  int inside = 0;
  for (int k = 0; k < kSamples; ++k)
    for (int j = 0; j < kSamples; ++j)
      for (int i = 0; i < kSamples; ++i) {
        const Vec3 at = (Vec3(i, j, k) + Vec3::Constant(0.5)) / kSamples - Vec3::Constant(0.5);
        inside += shape.depth_mm(centre + at.cwiseProduct(edges)) > 0 ? 1 : 0;
      }
  return inside / std::pow(kSamples, 3);
}

double ramp_at(const Shape& shape, const Index3& voxel) {
  return std::clamp(0.5 + 0.5 * shape.depth_mm(shape.frame.to_physical(voxel.cast<double>())), 0.0, 1.0);
}

LabelImage image_of_values(const Shape& shape, const LabelError& error, std::uint64_t seed) {
  LabelImage image(shape.frame, {kBackground, 1});
  const ImageFrame& f = shape.frame;
  std::vector<float> values(f.voxel_count());
  Random random(seed_of(shape.name + "/values", seed));
  for (int k = 0; k < f.size.z(); ++k)
    for (int j = 0; j < f.size.y(); ++j)
      for (int i = 0; i < f.size.x(); ++i) {
        const Index3 v(i, j, k);
        const double value = (error.told == Told::kRamp ? ramp_at(shape, v) : share_inside(shape, v)) +
                             error.value_noise * random.normal();
        values[f.offset(v)] = static_cast<float>(value);
        image.at(v) = value >= 0.5 ? 1 : 0;
      }
  keep_largest_component(image, ComponentScope::kUnion);
  if (error.told != Told::kThreshold)
    static_cast<void>(find_crossings(std::span<const float>(values), 0.5, image));
  return image;
}

}  // namespace

std::uint64_t Random::next() {  // SplitMix64 (Steele, Lea and Flood 2014, doi:10.1145/2660193.2660195).
  std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

double Random::uniform() {
  return static_cast<double>(next() >> 11) * 0x1p-53;
}

double Random::normal() {
  const double radius = std::sqrt(-2 * std::log(1 - uniform()));
  return radius * std::cos(2 * std::numbers::pi * uniform());
}

Vec3 Random::in_box(const Vec3& low, const Vec3& high) {
  const double x = uniform(), y = uniform(), z = uniform();
  return low + Vec3(x, y, z).cwiseProduct(high - low);
}

Vec3 Random::direction() {
  const double x = normal(), y = normal(), z = normal();
  return Vec3(x, y, z).normalized();
}

std::uint64_t seed_of(const std::string& name, std::uint64_t number) {
  std::uint64_t hash = 0xcbf29ce484222325u ^ (number * 0x9E3779B97F4A7C15u);  // FNV-1a of the name.
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

Vec3 Shape::inward_normal(const Vec3& point_mm) const {
  constexpr double kStep = 1e-4;
  Vec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 step = kStep * Vec3::Unit(axis);
    gradient[axis] = depth_mm(point_mm + step) - depth_mm(point_mm - step);
  }
  return gradient.normalized();
}

Vec3 Shape::on_surface(const Vec3& near_mm) const {
  Vec3 p = near_mm;
  for (int step = 0; step < 3; ++step) p -= depth_mm(p) * inward_normal(p);
  return p;
}

double Shape::voxels_from_border(const Vec3& point_mm) const {
  const Vec3 index = frame.to_index(point_mm);
  return std::min(index.minCoeff(), (frame.size.cast<double>() - Vec3::Ones() - index).minCoeff());
}

std::vector<Case> all_cases() {
  const std::vector<TubeDirection> directions = tube_directions();
  const TubeDirection &axis = directions[0], &two = directions[1], &fifteen = directions[3],
                      &oblique = directions[5];
  std::vector<Case> cases;
  for (const double radius : {1.5, 2.0, 3.0, 5.0, 10.0, 20.0})
    for (const TubeDirection& direction : directions) cases.push_back(tube_case(radius, direction));
  for (const Case& c :
       {tube_case(3, axis, 2), tube_case(5, two, 2), tube_case(10, two, 2), tube_case(10, oblique, 2)})
    cases.push_back(c);
  for (const Case& c :
       {plain("torus", torus), plain("sphere", sphere), plain("cone", cone), plain("stenosis", stenosis),
        plain("stenosis-short", short_stenosis), plain("sac", sac), plain("fork", fork),
        plain("two-tubes", two_tubes), plain("plate", flat_plate), plain("plate-oblique", oblique_plate),
        plain("line", line), plain("tube-cut", cut_tube)})
    cases.push_back(c);
  for (const double radius : {3.0, 5.0, 10.0})
    cases.push_back(with_error(tube_case(radius, fifteen), {.flipped_share = 0.05}));
  for (const double radius : {3.0, 5.0, 10.0})
    for (const double shift : {0.15, 0.3})
      cases.push_back(with_error(tube_case(radius, oblique), {.correlated_mm = shift}));
  for (const double shift : {0.15, 0.3})
    cases.push_back(with_error(plain("torus", torus), {.correlated_mm = shift}));
  cases.push_back(with_error(plain("fork", fork), {.correlated_mm = 0.15}));
  cases.push_back(with_error(plain("stenosis", stenosis), {.correlated_mm = 0.3}));
  return cases;
}

std::vector<Case> value_cases() {
  const std::vector<TubeDirection> directions = tube_directions();
  std::vector<Case> shapes;
  for (const double radius : {1.5, 2.0, 3.0, 5.0, 10.0})
    for (const int direction : {0, 1, 5})
      shapes.push_back(tube_case(radius, directions[static_cast<std::size_t>(direction)]));
  shapes.push_back(tube_case(5, directions[1], 2));
  for (const Case& c : {plain("sphere", sphere), plain("torus", torus), plain("stenosis", stenosis),
                        plain("fork", fork), plain("plate-oblique", oblique_plate)})
    shapes.push_back(c);
  std::vector<Case> cases;
  for (const double noise : {0.0, 0.05, 0.1})
    for (const Told told : {Told::kThreshold, Told::kVolumes, Told::kRamp})
      for (const Case& shape : shapes)
        cases.push_back(with_error(shape, {.told = told, .value_noise = noise}));
  return cases;
}

LabelImage labels_of(const Shape& shape, const LabelError& error, std::uint64_t seed) {
  if (error.told != Told::kSides) return image_of_values(shape, error, seed);
  LabelImage image(shape.frame, {kBackground, 1});
  const ImageFrame& f = shape.frame;
  std::vector<double> shift;
  if (error.correlated_mm > 0) shift = correlated_noise(f, Random(seed_of(shape.name + "/shift", seed)));
  for (int k = 0; k < f.size.z(); ++k)
    for (int j = 0; j < f.size.y(); ++j)
      for (int i = 0; i < f.size.x(); ++i) {
        const Index3 v(i, j, k);
        const double moved = shift.empty() ? 0 : error.correlated_mm * shift[f.offset(v)];
        image.at(v) = shape.depth_mm(f.to_physical(v.cast<double>())) + moved > 0 ? 1 : 0;
      }
  if (error.flipped_share > 0) {
    Random random(seed_of(shape.name + "/flips", seed));
    const std::vector<std::uint8_t> at_boundary = neighbours_differ(image);
    for (std::size_t v = 0; v < at_boundary.size(); ++v)
      if (at_boundary[v] != 0 && random.uniform() < error.flipped_share) image.voxels()[v] ^= 1;
  }
  if (error.correlated_mm > 0) keep_largest_component(image, ComponentScope::kUnion);
  return image;
}

}  // namespace lumesh::boundary
