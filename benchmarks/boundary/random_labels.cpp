#include "random_labels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "shapes.hpp"

namespace lumesh::boundary {

namespace {

constexpr int kMaxLabels = 20;

int between(Random& random, int low, int high) {
  return low + static_cast<int>(random.uniform() * (high - low + 1));
}

double between(Random& random, double low, double high) {
  return low + random.uniform() * (high - low);
}

/// Draws labels, in mm, into an image that is background at first.
class Painter {
 public:
  Painter(LabelImage& image, Random random) : image_(image), random_(random) {
    const ImageFrame& f = image.frame();
    high_ = f.to_physical(f.size.cast<double>() - Vec3::Ones());
    label_count_ = between(random_, 1, kMaxLabels);
  }

  void blobs() {
    for (int n = between(random_, 1, 2 * label_count_); n > 0; --n) {
      const Vec3 centre = random_.in_box(Vec3::Constant(4), high_ - Vec3::Constant(4));
      const Vec3 axes = random_.in_box(Vec3::Constant(1.5), Vec3::Constant(7));
      fill(any_label(), [&](const Vec3& p) { return (p - centre).cwiseQuotient(axes).squaredNorm() < 1; });
    }
  }

  /// Each tube begins where another runs, so that they touch.
  void tubes() {
    Vec3 from = random_.in_box(Vec3::Zero(), high_);
    for (int n = between(random_, 1, 10); n > 0; --n) {
      const Vec3 to = random_.in_box(Vec3::Zero(), high_);
      const double radius = between(random_, 1.0, 4.0);
      fill(any_label(), [&](const Vec3& p) {
        const double t = std::clamp((p - from).dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
        return (p - from - t * (to - from)).norm() < radius;
      });
      from = from + random_.uniform() * (to - from);
    }
  }

  void checkerboard() {
    const double edge = between(random_, 1, 5);
    const Vec3 low = random_.in_box(Vec3::Zero(), 0.4 * high_);
    const Vec3 size = random_.in_box(Vec3::Constant(4), 0.5 * high_);
    const bool has_holes = random_.uniform() < 0.5;
    for_each_voxel([&](const Index3& v, const Vec3& p) {
      if (((p - low).array() < 0).any() || ((p - low - size).array() > 0).any()) return;
      const int cell = ((p - low) / edge).array().floor().cast<int>().sum();
      if (has_holes && cell % 2 == 0) return;
      set(v, 1 + cell % std::max(2, label_count_) % label_count_);
    });
  }

  /// Plates of one to two and a half voxels.
  void sheets() {
    for (int n = between(random_, 1, 6); n > 0; --n) {
      const Vec3 centre = random_.in_box(0.2 * high_, 0.8 * high_);
      const Vec3 normal = random_.uniform() < 0.3 ? Vec3::Unit(between(random_, 0, 2)) : random_.direction();
      const double half = between(random_, 0.5, 1.25), extent = between(random_, 4.0, 20.0);
      fill(any_label(), [&](const Vec3& p) {
        return std::abs((p - centre).dot(normal)) <= half && (p - centre).norm() < extent;
      });
    }
  }

  /// Balls whose middle is within three voxels of a face of the image.
  void border() {
    for (int n = between(random_, 1, 10); n > 0; --n) {
      Vec3 centre = random_.in_box(Vec3::Zero(), high_);
      const int axis = between(random_, 0, 2);
      const double from_face = between(random_, -3.0, 3.0);
      centre[axis] = random_.uniform() < 0.5 ? from_face : high_[axis] - from_face;
      const double radius = between(random_, 1.5, 7.0);
      fill(any_label(), [&](const Vec3& p) { return (p - centre).norm() < radius; });
    }
  }

  /// A ball in which every place belongs to the nearest of some random points.
  void regions() {
    const Vec3 centre = 0.5 * high_;
    const double radius = 0.42 * high_.minCoeff();
    std::vector<Vec3> points;
    for (int n = 0; n < label_count_; ++n)
      points.push_back(centre + between(random_, 0.0, radius) * random_.direction());
    for_each_voxel([&](const Index3& v, const Vec3& p) {
      if ((p - centre).norm() > radius) return;
      const auto nearest = std::min_element(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) {
        return (a - p).squaredNorm() < (b - p).squaredNorm();
      });
      set(v, 1 + static_cast<int>(nearest - points.begin()));
    });
  }

  void mixture() {
    const std::array<void (Painter::*)(), 4> parts = {&Painter::blobs, &Painter::tubes, &Painter::sheets,
                                                      &Painter::border};
    for (int n = 0; n < 2; ++n) (this->*parts[static_cast<std::size_t>(between(random_, 0, 3))])();
  }

 private:
  int any_label() { return between(random_, 1, label_count_); }
  void set(const Index3& v, int label) { image_.at(v) = static_cast<LabelImage::Index>(label); }

  template <class Visit>
  void for_each_voxel(const Visit& visit) {
    const Index3& size = image_.frame().size;
    for (int k = 0; k < size.z(); ++k)
      for (int j = 0; j < size.y(); ++j)
        for (int i = 0; i < size.x(); ++i)
          visit(Index3(i, j, k), Vec3(image_.frame().to_physical(Vec3(i, j, k))));
  }
  template <class Inside>
  void fill(int label, const Inside& inside) {
    for_each_voxel([&](const Index3& v, const Vec3& p) {
      if (inside(p)) set(v, label);
    });
  }

  LabelImage& image_;
  Random random_;
  Vec3 high_ = Vec3::Zero();
  int label_count_ = 1;
};

/// Takes the labels that have no voxel out of values().
LabelImage with_present_labels(const LabelImage& image) {
  std::vector<std::uint8_t> present(image.values().size(), 0);
  for (const LabelImage::Index v : image.voxels()) present[v] = 1;
  present[0] = 1;
  std::vector<Label> values;
  std::vector<LabelImage::Index> new_index(present.size(), 0);
  for (std::size_t i = 0; i < present.size(); ++i) {
    if (present[i] == 0) continue;
    new_index[i] = static_cast<LabelImage::Index>(values.size());
    values.push_back(image.values()[i]);
  }
  LabelImage result(image.frame(), values);
  for (std::size_t v = 0; v < image.voxels().size(); ++v) result.voxels()[v] = new_index[image.voxels()[v]];
  return result;
}

}  // namespace

RandomLabels random_labels(std::uint64_t seed) {
  struct Kind {
    const char* name;
    void (Painter::*paint)();
  };
  constexpr std::array<Kind, 7> kKinds = {{{"blobs", &Painter::blobs},
                                           {"tubes", &Painter::tubes},
                                           {"checkerboard", &Painter::checkerboard},
                                           {"sheets", &Painter::sheets},
                                           {"border", &Painter::border},
                                           {"regions", &Painter::regions},
                                           {"mixture", &Painter::mixture}}};
  const Kind& kind = kKinds[seed % kKinds.size()];
  for (std::uint64_t attempt = 0;; ++attempt) {  // Small blobs can miss every voxel.
    Random random(seed_of(kind.name, seed + (attempt << 32)));
    ImageFrame frame;
    for (int axis = 0; axis < 3; ++axis) frame.size[axis] = between(random, 24, 48);
    if (random.uniform() < 0.2) frame.spacing_mm.z() = 1.5;
    std::vector<Label> values(kMaxLabels + 1);
    for (int label = 0; label <= kMaxLabels; ++label) values[static_cast<std::size_t>(label)] = label;
    LabelImage image(frame, values);
    Painter painter(image, random);
    (painter.*kind.paint)();
    LabelImage present = with_present_labels(image);
    if (present.values().size() > 1) return {kind.name, std::move(present)};
  }
}

}  // namespace lumesh::boundary
