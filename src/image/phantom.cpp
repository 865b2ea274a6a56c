#include "lumesh/image/phantom.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "lumesh/core/error.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/parallel/loops.hpp"
#include "phantom_impl.hpp"

namespace lumesh {

using image::Material;

namespace {

constexpr int kLargeBrick =
    32;  ///< Voxels; large bricks that no surface meets are done at one distance query,
constexpr int kSmallBrick = 8;  ///< the others are cut into small ones.

Mat3 rotation(const Vec3& angles_deg) {
  const Vec3 a = angles_deg * (std::numbers::pi / 180);
  Mat3 about_x;
  about_x << 1, 0, 0, 0, std::cos(a.x()), -std::sin(a.x()), 0, std::sin(a.x()), std::cos(a.x());
  Mat3 about_y;
  about_y << std::cos(a.y()), 0, std::sin(a.y()), 0, 1, 0, -std::sin(a.y()), 0, std::cos(a.y());
  Mat3 about_z;
  about_z << std::cos(a.z()), -std::sin(a.z()), 0, std::sin(a.z()), std::cos(a.z()), 0, 0, 0, 1;
  return about_z * about_y * about_x;
}

/// Voxels [low, high).
struct Brick {
  Index3 low;
  Index3 high;
};

Brick brick_at(const Index3& region_low, const Index3& region_high, int edge, std::size_t number) {
  const Index3 counts = ((region_high - region_low).array() + (edge - 1)) / edge;
  const Index3 low = region_low + edge * grid_place(counts, number);
  return {low, (low.array() + edge).matrix().cwiseMin(region_high)};
}

std::size_t brick_count(const Index3& region_low, const Index3& region_high, int edge) {
  const Index3 counts = ((region_high - region_low).array() + (edge - 1)) / edge;
  return grid_count(counts);
}

/// Cuts a large brick: calls uniform(brick, centre) for parts that no surface meets, mixed(brick) for small
/// bricks that may hold one. `distance(p)` is the distance to the nearest surface that matters.
template <class Distance, class Uniform, class Mixed>
void cut_brick(const ImageFrame& frame, double lipschitz, const Brick& large, const Distance& distance,
               const Uniform& uniform, const Mixed& mixed) {
  const auto is_clear = [&](const Brick& brick, Vec3& centre) {
    centre = (0.5 * (brick.low + brick.high - Index3::Ones()).cast<double>()).cwiseProduct(frame.spacing_mm);
    const double reach = 0.5 * (brick.high - brick.low).cast<double>().cwiseProduct(frame.spacing_mm).norm();
    return distance(centre) > lipschitz * reach;
  };
  Vec3 centre;
  if (is_clear(large, centre)) return uniform(large, centre);
  const std::size_t count = brick_count(large.low, large.high, kSmallBrick);
  for (std::size_t b = 0; b < count; ++b) {
    const Brick small = brick_at(large.low, large.high, kSmallBrick, b);
    if (is_clear(small, centre)) {
      uniform(small, centre);
    } else {
      mixed(small);
    }
  }
}

void fill_brick(LabelImage& image, const Brick& brick, LabelImage::Index value) {
  if (value == 0) return;
  for (int k = brick.low.z(); k < brick.high.z(); ++k)
    for (int j = brick.low.y(); j < brick.high.y(); ++j)
      std::fill_n(image.voxels().data() + image.frame().offset({brick.low.x(), j, k}),
                  brick.high.x() - brick.low.x(), value);
}

/// Length of {x in [begin, end] : f(x) < 0}, f with the given Lipschitz constant; parts shorter than `step`
/// may be missed.
template <class Function>
double negative_length(const Function& f, double begin, double end, double lipschitz, double step) {
  double length = 0;
  double x = begin;
  double value = f(x);
  while (x < end) {
    const double next = std::min(end, x + std::max(step, std::abs(value) / lipschitz));
    const double next_value = f(next);
    if ((value < 0) == (next_value < 0)) {
      length += value < 0 ? next - x : 0;
    } else {
      double a = x;  // regula falsi with bisection where it stalls
      double b = next;
      double fa = value;
      double fb = next_value;
      for (int i = 0; i < 8 && b - a > 1e-4 * step; ++i) {
        const double t = i % 3 == 2 ? 0.5 : std::clamp(fa / (fa - fb), 0.001, 0.999);
        const double middle = a + t * (b - a);
        const double fm = f(middle);
        ((fm < 0) == (fa < 0) ? (a = middle, fa = fm) : (b = middle, fb = fm));
      }
      const double root = std::clamp(a + (b - a) * fa / (fa - fb), a, b);
      length += value < 0 ? root - x : next - root;
    }
    x = next;
    value = next_value;
  }
  return length;
}

double line_volume(const Phantom::Impl& impl, const Material& material, const Brick& brick) {
  // The larger the image, the more the errors of its lines cancel.
  const std::size_t voxels = impl.frame.voxel_count();
  const int lines_per_voxel = voxels < (std::size_t{1} << 20) ? 4 : voxels < (std::size_t{1} << 24) ? 2 : 1;
  const Vec3& spacing = impl.frame.spacing_mm;
  const Vec3 low = (brick.low.cast<double>() - Vec3::Constant(0.5)).cwiseProduct(spacing);
  const Vec3 high = (brick.high.cast<double>() - Vec3::Constant(0.5)).cwiseProduct(spacing);
  const double step = 0.5 * spacing.minCoeff();
  const Index3 lines = lines_per_voxel * (brick.high - brick.low);
  double length = 0;
  for (int k = 0; k < lines.z(); ++k) {
    for (int j = 0; j < lines.y(); ++j) {
      const double y = low.y() + (j + 0.5) * spacing.y() / lines_per_voxel;
      const double z = low.z() + (k + 0.5) * spacing.z() / lines_per_voxel;
      length += negative_length(
          [&](double x) {
            return impl.signed_distance({x, y, z}, material);
          },
          low.x(), high.x(), impl.lipschitz, step);
    }
  }
  return length * spacing.y() * spacing.z() / (lines_per_voxel * lines_per_voxel);
}

}  // namespace

const Material& Phantom::Impl::material(Label label) const {
  for (const Material& material : geometry.materials)
    if (material.truth.label == label) return material;
  throw Error(ErrorKind::kBadInput,
              fmt::format("phantom {} has no label {}; its labels are 1 to {}", phantom_kind_name(spec.kind),
                          label, geometry.materials.size()));
}

double Phantom::Impl::signed_distance(const Vec3& local, const Material& material) const {
  const double shift = noise ? noise_mm * noise->at(local) : 0.0;
  double distance = material.inside->distance(local) + shift - material.grown_mm;
  if (material.outside)
    distance = std::max(distance, material.outside_grown_mm - material.outside->distance(local) - shift);
  return distance;
}

Phantom::Impl::Sample Phantom::Impl::sample(const Vec3& local) const {
  Sample result{kBackground, std::numeric_limits<double>::infinity()};
  for (const Material& material : geometry.materials) {
    const double distance = signed_distance(local, material);
    if (distance < 0) result.label = material.truth.label;  // materials are disjoint
    result.clearance = std::min(result.clearance, std::abs(distance));
  }
  return result;
}

Phantom::Phantom(const PhantomSpec& spec) {
  const auto impl = std::make_shared<Impl>();
  impl->spec = resolve(spec);
  const PhantomSpec& full = impl->spec;
  impl->frame = {full.size, full.spacing_mm, full.origin_mm, rotation(full.rotation_deg)};
  impl->geometry = image::make_geometry(full);
  if (full.noise_voxels > 0) {
    impl->noise.emplace(static_cast<std::uint32_t>(full.seed), full.spacing_mm.maxCoeff());
    impl->noise_mm = full.noise_voxels * full.spacing_mm.maxCoeff();
    impl->lipschitz = 1 + full.noise_voxels * image::WaveNoise::kSlope;
  }
  impl->box_low = -0.5 * full.spacing_mm;
  impl->box_high = (full.size.cast<double>() - Vec3::Constant(0.5)).cwiseProduct(full.spacing_mm);
  impl_ = impl;
}

const PhantomSpec& Phantom::spec() const {
  return impl_->spec;
}
const ImageFrame& Phantom::frame() const {
  return impl_->frame;
}

std::vector<Label> Phantom::labels() const {
  std::vector<Label> labels;
  for (const Material& material : impl_->geometry.materials) labels.push_back(material.truth.label);
  return labels;
}

Label Phantom::label_at(const Vec3& point_mm) const {
  return impl_->sample(impl_->to_local(point_mm)).label;
}

double Phantom::signed_distance_mm(const Vec3& point_mm, Label label) const {
  return impl_->signed_distance(impl_->to_local(point_mm), impl_->material(label));
}

double Phantom::surface_distance_mm(const Vec3& point_mm, Label label) const {
  const Vec3 local = impl_->to_local(point_mm);
  const double shape = impl_->signed_distance(local, impl_->material(label));
  const double box = impl_->box_distance(local);
  if (shape <= 0 && box <= 0) return std::min(-shape, -box);
  // Beside the rim of a cap both count; the shape meets the cap's plane at a right angle.
  return std::hypot(std::max(shape, 0.0), std::max(box, 0.0));
}

double Phantom::volume_mm3(Label label) const {
  const Material& material = impl_->material(label);
  if (material.volume_mm3 && !impl_->noise) return *material.volume_mm3;
  const Index3& size = impl_->frame.size;
  const auto distance = [&](const Vec3& p) { return std::abs(impl_->signed_distance(p, material)); };
  const auto volume_of = [&](std::size_t begin, std::size_t end) {
    double volume = 0;
    const auto uniform = [&](const Brick& brick, const Vec3& centre) {
      if (impl_->signed_distance(centre, material) < 0)
        volume += (brick.high - brick.low).cast<double>().cwiseProduct(impl_->frame.spacing_mm).prod();
    };
    for (std::size_t b = begin; b < end; ++b)
      cut_brick(impl_->frame, impl_->lipschitz, brick_at(Index3::Zero(), size, kLargeBrick, b), distance,
                uniform, [&](const Brick& brick) { volume += line_volume(*impl_, material, brick); });
    return volume;
  };
  return parallel::reduce_blocks(brick_count(Index3::Zero(), size, kLargeBrick), 1, 0.0, volume_of,
                                 std::plus<>());
}

PhantomTruth Phantom::truth(Label label) const {
  return impl_->material(label).truth;
}

LabelImage Phantom::rasterise() const {
  std::vector<Label> values = labels();  // 1, 2, …, so that labels are their own compact indices
  values.insert(values.begin(), kBackground);
  LabelImage image(impl_->frame, values);
  const auto fill_uniform = [&](const Brick& brick, const Vec3& centre) {
    fill_brick(image, brick, static_cast<LabelImage::Index>(impl_->sample(centre).label));
  };
  const Vec3& spacing = impl_->frame.spacing_mm;
  const auto sample_row = [&](const Brick& brick, int j, int k) {
    LabelImage::Index* row = image.voxels().data() + image.frame().offset({0, j, k});
    for (int i = brick.low.x(); i < brick.high.x();) {
      const Impl::Sample sample = impl_->sample(Vec3(i, j, k).cwiseProduct(spacing));
      const double clear_voxels =
          std::min(sample.clearance / (impl_->lipschitz * spacing.x()), double{kSmallBrick});
      // Voxels whose centres are nearer than the nearest surface share the label.
      const int next = std::min(brick.high.x(), i + std::max(1, static_cast<int>(std::ceil(clear_voxels))));
      std::fill(row + i, row + next, static_cast<LabelImage::Index>(sample.label));
      i = next;
    }
  };
  const auto sample_brick = [&](const Brick& brick) {
    for (int k = brick.low.z(); k < brick.high.z(); ++k)
      for (int j = brick.low.y(); j < brick.high.y(); ++j) sample_row(brick, j, k);
  };
  const auto clearance = [&](const Vec3& p) { return impl_->sample(p).clearance; };
  parallel::for_each_index(
      brick_count(Index3::Zero(), impl_->frame.size, kLargeBrick), 1, [&](std::size_t b) {
        cut_brick(impl_->frame, impl_->lipschitz, brick_at(Index3::Zero(), impl_->frame.size, kLargeBrick, b),
                  clearance, fill_uniform, sample_brick);
      });
  return image;
}

}  // namespace lumesh
