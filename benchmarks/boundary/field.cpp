#include "field.hpp"

#include <Eigen/Dense>
#include <chrono>
#include <cmath>
#include <map>
#include <numbers>

#include "fine_grid.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::boundary {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Material kInside = 1, kOutside = 0;

double degrees_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

/// Places spread evenly over the exact surface within the image, but for sharp creases. Places of a thin
/// layer around the surface, taken at random and moved onto it, are spread evenly to first order in its
/// thickness.
std::vector<WallSample> surface_places(const Shape& shape, std::uint64_t seed) {
  constexpr std::size_t kWanted = 4000;
  constexpr int kMaxTries = 4'000'000;
  constexpr double kLayer = 0.3, kBorderReach = 4;
  Random random(seed_of(shape.name + "/places", seed));
  const Vec3 high = shape.frame.to_physical(shape.frame.size.cast<double>() - Vec3::Ones());
  std::vector<WallSample> places;
  for (int t = 0; t < kMaxTries && places.size() < kWanted; ++t) {
    const Vec3 p = random.in_box(Vec3::Zero(), high);
    if (std::abs(shape.depth_mm(p)) > kLayer) continue;
    WallSample place;
    place.point_mm = shape.on_surface(p);
    const double from_border = shape.voxels_from_border(place.point_mm);
    if (from_border < 0 || (shape.near_crease && shape.near_crease(place.point_mm))) continue;
    place.normal = shape.inward_normal(place.point_mm);
    place.near_border = from_border < kBorderReach;
    places.push_back(place);
  }
  return places;
}

/// Finds the boundary along the exact normal: the change from outside to inside that is nearest to the
/// surface.
void find_boundary(const ImageDomain& domain, WallSample& place) {
  constexpr int kSteps = 32;
  constexpr double kReach = 1.6;
  const auto value = [&](double t) {
    return domain.separation_value(place.point_mm + t * place.normal, kInside, kOutside);
  };
  double best = kNaN;
  double previous = value(-kReach);
  for (int s = -kSteps; s < kSteps; ++s) {
    double low = kReach * s / kSteps, high = kReach * (s + 1) / kSteps;
    const double next = value(high);
    const bool enters = previous <= 0 && next > 0;
    previous = next;
    if (!enters || std::min(std::abs(low), std::abs(high)) > std::abs(best)) continue;
    for (int i = 0; i < 30; ++i) {
      const double middle = 0.5 * (low + high);
      (value(middle) > 0 ? high : low) = middle;
    }
    if (!(std::abs(best) < std::abs(low))) best = low;
  }
  place.found = !std::isnan(best);
  if (!place.found) return;
  place.offset_mm = -best;
  const Vec3 gradient = domain.separation(place.point_mm + best * place.normal, kInside, kOutside).gradient;
  place.angle_deg = degrees_between(gradient, place.normal);
}

struct CrossSection {
  Vec3 u, v;
};

CrossSection across(const Vec3& direction) {
  const Vec3 u = direction.unitOrthogonal();
  return {u, direction.cross(u)};
}

/// R.m.s. of the offsets less what a shift and a tilt of the axis and a change of the radius explain.
double aligned_roughness(const Tube& tube, const std::vector<WallSample>& samples) {
  const auto [u, v] = across(tube.direction);
  const auto rows = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixXd modes(rows, 5);
  Eigen::VectorXd offsets(rows);
  for (Eigen::Index r = 0; r < rows; ++r) {
    const WallSample& s = samples[static_cast<std::size_t>(r)];
    const Vec3 from_centre = s.point_mm - tube.centre_mm;
    const double c = -s.normal.dot(u), w = -s.normal.dot(v), along = from_centre.dot(tube.direction) / 30;
    modes.row(r) << 1, c, w, along * c, along * w;
    offsets[r] = s.offset_mm;
  }
  const Eigen::VectorXd fitted = (modes.transpose() * modes).ldlt().solve(modes.transpose() * offsets);
  return std::sqrt((offsets - modes * fitted).squaredNorm() / static_cast<double>(rows));
}

/// R.m.s. over pieces of the tube of their radius' deviation from the mean radius, in per cent. A piece's
/// radius is the mean of its offsets with the shift of the piece taken out.
double radius_variation(const Tube& tube, const std::vector<WallSample>& samples) {
  constexpr double kPiece = 4;
  constexpr std::size_t kFewest = 40;
  const auto [u, v] = across(tube.direction);
  std::map<int, std::vector<const WallSample*>> pieces;
  for (const WallSample& s : samples)
    pieces[static_cast<int>(std::floor((s.point_mm - tube.centre_mm).dot(tube.direction) / kPiece))]
        .push_back(&s);
  std::vector<double> radii;
  for (const auto& [piece, members] : pieces) {
    if (members.size() < kFewest) continue;
    Eigen::Matrix3d normal_equations = Eigen::Matrix3d::Zero();
    Vec3 right = Vec3::Zero();
    for (const WallSample* s : members) {
      const Vec3 modes(1, s->normal.dot(u), s->normal.dot(v));
      normal_equations += modes * modes.transpose();
      right += s->offset_mm * modes;
    }
    radii.push_back(tube.radius_mm + Vec3(normal_equations.ldlt().solve(right))[0]);
  }
  double mean = 0, square = 0;
  for (const double r : radii) mean += r / static_cast<double>(radii.size());
  for (const double r : radii) square += (r - mean) * (r - mean) / static_cast<double>(radii.size());
  return 100 * std::sqrt(square) / tube.radius_mm;
}

struct Volumes {
  double domain = 0, exact = 0, voxels = 0;
};

/// Volumes between the border voxels' centres, from samples that count by the share of their surroundings
/// that is inside, and the topology of the samples.
struct Sampled {
  Volumes volumes;
  LabelTopology topology;
  std::size_t wrong_voxels = 0;
};

Sampled sample_inside(const Shape& shape, const LabelImage& image, const ImageDomain& domain) {
  constexpr int kRefinement = 3;
  const FineGrid grid(image, domain, kRefinement);
  const ImageFrame& frame = grid.frame();
  LabelImage labels(frame, image.values());
  const auto share = [](double depth) { return std::clamp(0.5 + depth * kRefinement, 0.0, 1.0); };
  const auto rows = static_cast<std::size_t>(frame.size.y()) * static_cast<std::size_t>(frame.size.z());
  std::vector<Volumes> by_row(rows);
  const auto row_of = [&](const Index3& s) -> Volumes& {
    return by_row[frame.offset({0, s.y(), s.z()}) / static_cast<std::size_t>(frame.size.x())];
  };
  const auto add = [&](const Index3& sample, double inside) {
    const Vec3 point = frame.to_physical(sample.cast<double>());
    const Index3 voxel = (sample + Index3::Ones()) / kRefinement;
    Volumes& row = row_of(sample);
    row.domain += inside;
    row.exact += share(shape.depth_mm(point));
    row.voxels += image.at(voxel);
  };
  grid.for_each(
      [&](const Index3& sample, const Vec3& point) {
        const FieldSample s = domain.separation(point, kInside, kOutside);
        labels.at(sample) = s.value > 0 ? 1 : 0;
        add(sample, share(s.value / std::max(1e-6, s.gradient.norm())));
      },
      [&](const Index3& sample, Material material) {
        labels.at(sample) = static_cast<LabelImage::Index>(material);
        add(sample, material);
      });
  Sampled result;
  for (const Volumes& row : by_row) {
    result.volumes.domain += row.domain;
    result.volumes.exact += row.exact;
    result.volumes.voxels += row.voxels;
  }
  result.topology = union_topology(labels);
  result.wrong_voxels = grid.wrong_voxels();
  return result;
}

double root_mean(double sum, std::size_t count) {
  return count == 0 ? kNaN : std::sqrt(sum / static_cast<double>(count));
}

void describe_border(const std::vector<WallSample>& samples, double mean, FieldFigures& figures) {
  double offsets = 0, angles = 0;
  for (const WallSample& s : samples) {
    offsets += (s.offset_mm - mean) * (s.offset_mm - mean);
    angles += s.angle_deg * s.angle_deg;
  }
  figures.border_roughness_mm = root_mean(offsets, samples.size());
  figures.border_normal_deg = root_mean(angles, samples.size());
}

}  // namespace

Deviation deviation_of(const Shape& shape, const std::vector<WallSample>& samples) {
  Deviation d;
  double square = 0, angles = 0, sections = 0;
  for (const WallSample& s : samples) d.mean_mm += s.offset_mm / static_cast<double>(samples.size());
  for (const WallSample& s : samples) {
    square += (s.offset_mm - d.mean_mm) * (s.offset_mm - d.mean_mm);
    angles += s.angle_deg * s.angle_deg;
    d.furthest_mm = std::max(d.furthest_mm, std::abs(s.offset_mm));
    if (shape.tube) sections += std::pow(shape.tube->radius_mm + s.offset_mm, 2);
  }
  d.roughness_mm = root_mean(square, samples.size());
  d.normal_deg = root_mean(angles, samples.size());
  d.aligned_mm = d.radius_percent = d.radius_variation_percent = kNaN;
  if (!shape.tube || samples.size() < 20) return d;
  d.aligned_mm = aligned_roughness(*shape.tube, samples);
  d.radius_percent = 100 * (root_mean(sections, samples.size()) / shape.tube->radius_mm - 1);
  d.radius_variation_percent = radius_variation(*shape.tube, samples);
  return d;
}

FieldFigures measure_field(const Shape& shape, const LabelImage& image, std::uint64_t seed) {
  FieldFigures figures;
  const auto start = std::chrono::steady_clock::now();
  const ImageDomain domain(image, ImageDomainOptions{});
  figures.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  std::vector<WallSample> places = surface_places(shape, seed);
  parallel::for_each_index(places.size(), 16, [&](std::size_t p) { find_boundary(domain, places[p]); });
  std::vector<WallSample> main, border;
  for (const WallSample& place : places)
    if (place.found) (place.near_border ? border : main).push_back(place);
  figures.points = places.size();
  figures.lost_percent = 100.0 * static_cast<double>(places.size() - main.size() - border.size()) /
                         static_cast<double>(std::max<std::size_t>(1, places.size()));
  const Deviation d = deviation_of(shape, main);
  figures.mean_mm = d.mean_mm;
  figures.roughness_mm = d.roughness_mm;
  figures.aligned_mm = d.aligned_mm;
  figures.furthest_mm = d.furthest_mm;
  figures.normal_deg = d.normal_deg;
  figures.radius_percent = d.radius_percent;
  figures.radius_variation_percent = d.radius_variation_percent;
  describe_border(border, d.mean_mm, figures);

  const Sampled sampled = sample_inside(shape, image, domain);
  figures.volume_percent = 100 * (sampled.volumes.domain / sampled.volumes.exact - 1);
  figures.voxel_volume_percent = 100 * (sampled.volumes.voxels / sampled.volumes.exact - 1);
  figures.voxels = union_topology(image);
  figures.samples = sampled.topology;
  figures.wrong_voxels = sampled.wrong_voxels;
  return figures;
}

}  // namespace lumesh::boundary
