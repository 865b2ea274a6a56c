#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/delaunay/sizing.hpp"
#include "lumesh/metric/metric_field.hpp"
#include "lumesh/metric/point_tree.hpp"
#include "lumesh/metric/tensor.hpp"
#include "nearest_points.hpp"
#include "size_points.hpp"
#include "value_grid.hpp"

namespace lumesh {
namespace {

constexpr int kNearestAlone = 1;  // Points of a size where their number is not given.

void require(bool holds, const std::string& message) {
  if (!holds) throw Error(ErrorKind::kUsage, message);
}

void require_size(double size_mm, const std::string& what) {
  require(size_mm > 0, fmt::format("{} must be a length greater than 0 mm, not {:g}", what, size_mm));
}

class LabelSizing final : public Sizing {
 public:
  explicit LabelSizing(const LabelSizeOptions& options)
      : sizes_mm_(options.sizes_mm.begin(), options.sizes_mm.end()), elsewhere_mm_(options.elsewhere_mm) {}

  [[nodiscard]] double size_at(const Vec3& /*point_mm*/, Label label) const override {
    // Images have few labels: quicker than a map.
    const auto found = std::find_if(sizes_mm_.begin(), sizes_mm_.end(),
                                    [label](const auto& entry) { return entry.first == label; });
    return found == sizes_mm_.end() ? elsewhere_mm_ : found->second;
  }

 private:
  std::vector<std::pair<Label, double>> sizes_mm_;
  double elsewhere_mm_;
};

class PointSizing final : public Sizing {
 public:
  PointSizing(std::span<const Vec3> points_mm, const PointSizeOptions& options)
      : options_(options),
        points_(points_mm, options.region_mm,
                {options.floor_mm / options.factor, options.ceiling_mm / options.factor}) {}

  [[nodiscard]] double size_at(const Vec3& point_mm, Label /*label*/) const override {
    // Held again: dividing and multiplying may have gone beyond an end by rounding.
    return std::clamp(options_.factor * points_.distance(point_mm), options_.floor_mm, options_.ceiling_mm);
  }

 private:
  PointSizeOptions options_;
  delaunay::NearestPoints points_;
};

class MeanDistanceSizing final : public Sizing {
 public:
  MeanDistanceSizing(std::span<const Vec3> points_mm, const PointSizeOptions& options)
      : options_(options), points_(metric::distinct_by_place(points_mm)), tree_(points_) {
    metric::require_as_many(points_.size(), static_cast<std::size_t>(options.k));
  }

  [[nodiscard]] double size_at(const Vec3& point_mm, Label /*label*/) const override {
    const double distance = tree_.mean_distance(point_mm, static_cast<std::size_t>(options_.k));
    return std::clamp(options_.factor * distance, options_.floor_mm, options_.ceiling_mm);
  }

 private:
  PointSizeOptions options_;
  std::vector<Vec3> points_;
  metric::PointTree tree_;
};

class BoundarySizing final : public Sizing {
 public:
  BoundarySizing(const Domain& domain, const BoundarySizeOptions& options)
      : domain_(&domain), options_(options), distances_(delaunay::boundary_distances(domain)) {}

  [[nodiscard]] double size_at(const Vec3& point_mm, Label /*label*/) const override {
    double distance = distances_.at(point_mm);
    // Between its points a grid rounds the cusp at the boundary off, by less than the way to the corners of a
    // cell. The domain knows better where it knows at all.
    const double limit = domain_->clearance_limit_mm(), error = 0.87 * distances_.spacing_mm();
    if (distance < limit + error) {
      const double clearance = domain_->surroundings(point_mm).clearance_mm;
      if (clearance < limit) distance = std::clamp(clearance, std::max(distance - error, 0.0), distance);
    }
    return std::min(options_.at_boundary_mm + options_.growth * distance, options_.ceiling_mm);
  }

 private:
  const Domain* domain_;
  BoundarySizeOptions options_;
  delaunay::ValueGrid distances_;
};

class ImageSizing final : public Sizing {
 public:
  explicit ImageSizing(SizeImage image) : image_(std::move(image)) {
    // "Any size" is 0 here: it drops out of sums.
    for (float& size : image_.sizes_mm)
      if (std::isinf(size)) size = 0;
  }

  [[nodiscard]] double size_at(const Vec3& point_mm, Label /*label*/) const override {
    const delaunay::WeightedCorners corners(image_.frame.to_index(point_mm), image_.frame.size);
    double weight = 0, sum = 0;
    for (int c = 0; c < 8; ++c) {
      const double size = image_.sizes_mm[corners.offset(c)];
      sum += corners.weight(c) * size;
      weight += size > 0 ? corners.weight(c) : 0;
    }
    return sum > 0 ? sum / weight : kAnySize;
  }

 private:
  SizeImage image_;
};

class MeshSizing final : public Sizing {
 public:
  explicit MeshSizing(TetMesh background) : region_(bounding_box(background.points())) {
    cells_per_mm_ = kHintCells / region_.sizes().cwiseMax(1e-300).array();
    field_ = std::make_unique<metric::MetricField>(metric::MetricField::on_background(std::move(background)));
    // A search begins where this table says, whatever was asked before: else the last bits of an answer would
    // depend on the threads.
    hints_.reserve(static_cast<std::size_t>(kHintCells) * kHintCells * kHintCells);
    metric::MetricField::Hint hint = field_->first_hint();
    for (int k = 0; k < kHintCells; ++k) {
      for (int j = 0; j < kHintCells; ++j) {
        for (int i = 0; i < kHintCells; ++i) {
          const Vec3 centre =
              region_.min() + (Vec3(i, j, k).array() + 0.5).matrix().cwiseQuotient(cells_per_mm_);
          static_cast<void>(field_->at(centre, hint));
          hints_.push_back(hint);
        }
      }
    }
  }

  [[nodiscard]] double size_at(const Vec3& point_mm, Label /*label*/) const override {
    const Vec3 place =
        (point_mm - region_.min()).cwiseProduct(cells_per_mm_).cwiseMax(0.0).cwiseMin(kHintCells - 1);
    const Index3 cell = place.cast<int>();
    metric::MetricField::Hint hint =
        hints_[static_cast<std::size_t>(cell.x() + kHintCells * (cell.y() + kHintCells * cell.z()))];
    return std::exp(-0.5 * field_->at(point_mm, hint).log.xx);
  }

 private:
  static constexpr int kHintCells = 32;  // Along each axis.
  Box3 region_;
  Vec3 cells_per_mm_;
  std::unique_ptr<metric::MetricField> field_;
  std::vector<metric::MetricField::Hint> hints_;
};

class CombinedSizing final : public Sizing {
 public:
  explicit CombinedSizing(std::vector<std::unique_ptr<Sizing>> parts) : parts_(std::move(parts)) {}

  [[nodiscard]] double size_at(const Vec3& point_mm, Label label) const override {
    double size = kAnySize;
    for (const auto& part : parts_) size = std::min(size, part->size_at(point_mm, label));
    return size;
  }
  [[nodiscard]] bool wants_finer(const std::array<Vec3, 4>& corners_mm) const override {
    return std::any_of(parts_.begin(), parts_.end(),
                       [&](const auto& part) { return part->wants_finer(corners_mm); });
  }
  [[nodiscard]] bool has_criterion() const override {
    return std::any_of(parts_.begin(), parts_.end(), [](const auto& part) { return part->has_criterion(); });
  }
  [[nodiscard]] std::vector<std::string> warnings() const override {
    std::vector<std::string> all;
    for (const auto& part : parts_)
      for (std::string& line : part->warnings()) all.push_back(std::move(line));
    return all;
  }

 private:
  std::vector<std::unique_ptr<Sizing>> parts_;
};

}  // namespace

void LabelSizeOptions::describe(OptionList& list) {
  list.of_labels("label_size", sizes_mm, above(0), "Size inside a label").in("mm");
}

void PointSizeOptions::describe(OptionList& list) {
  list.number("size_k", k, between(1, 10000),
              "Nearest of these points, the mean of whose distances counts; the paper has 30")
      .alias("k")
      .zero(fmt::format("{}, for which size_floor is needed", kNearestAlone))
      .needs("size_points");
  list.number("size_factor", factor, above(0), "Size per distance to the size_points").needs("size_points");
  list.number(
          "size_floor", floor_mm, above(0),
          fmt::format("Least of these sizes, needed with size_k = {}, where the points themselves have it",
                      kNearestAlone))
      .in("mm")
      .zero("not given")
      .needs("size_points");
  list.number("size_ceiling", ceiling_mm, above(0), "Largest of these sizes")
      .in("mm")
      .zero("no bound", kAnySize)
      .needs("size_points");
}

void PointSizeOptions::validate() const {
  require_ranges_of(*this);
  require(ceiling_mm >= floor_mm,
          option_name("size_ceiling") + " must not be less than " + option_name("size_floor"));
}

void BoundarySizeOptions::describe(OptionList& list) {
  list.number("size_boundary", at_boundary_mm, above(0),
              "Size at walls, interfaces and openings, growing inwards")
      .in("mm")
      .zero("none");
  list.number("size_growth", growth, at_least(0), "Growth of that size per distance from them")
      .needs("size_boundary");
}

std::unique_ptr<Sizing> size_per_label(const LabelSizeOptions& options) {
  require_ranges_of(options);
  require_size(options.elsewhere_mm, "the size of labels that are not named");
  return std::make_unique<LabelSizing>(options);
}

void require_size_points(std::span<const Vec3> points_mm) {
  if (points_mm.empty()) throw Error(ErrorKind::kBadInput, "no points to take sizes from: give at least one");
  for (std::size_t i = 0; i < points_mm.size(); ++i)
    if (!points_mm[i].allFinite())
      throw Error(ErrorKind::kBadInput, fmt::format("point {} to take sizes from is not finite", i));
}

std::unique_ptr<Sizing> size_from_points(std::span<const Vec3> points_mm, const PointSizeOptions& options) {
  options.validate();
  if (options.k <= kNearestAlone) require_given_of(options, "size_floor");
  require_size_points(points_mm);
  if (options.k > kNearestAlone) return std::make_unique<MeanDistanceSizing>(points_mm, options);
  return std::make_unique<PointSizing>(points_mm, options);
}

std::unique_ptr<Sizing> size_from_boundary(const Domain& domain, const BoundarySizeOptions& options) {
  require_ranges_of(options);
  require_given_of(options, "size_boundary");
  require_size(options.ceiling_mm, "the size ceiling");
  return std::make_unique<BoundarySizing>(domain, options);
}

std::unique_ptr<Sizing> size_from_image(SizeImage image) {
  const Index3& size = image.frame.size;
  if ((size.array() <= 0).any() || image.sizes_mm.size() != image.frame.voxel_count())
    throw Error(ErrorKind::kBadInput, fmt::format("the size image of {} x {} x {} voxels has {} values",
                                                  size.x(), size.y(), size.z(), image.sizes_mm.size()));
  const auto bad =
      std::find_if(image.sizes_mm.begin(), image.sizes_mm.end(), [](float s) { return !(s >= 0); });
  if (bad != image.sizes_mm.end()) {
    const std::ptrdiff_t at = bad - image.sizes_mm.begin(), row = size.x(), slice = row * size.y();
    throw Error(
        ErrorKind::kBadInput,
        fmt::format("the size image has {:g} at voxel ({}, {}, {}): sizes are mm, > 0, or 0 for any size",
                    *bad, at % row, at % slice / row, at / slice));
  }
  return std::make_unique<ImageSizing>(std::move(image));
}

std::unique_ptr<Sizing> size_from_mesh(TetMesh background, std::span<const double> sizes_mm) {
  if (background.tet_count() == 0) throw Error(ErrorKind::kBadInput, "the size mesh has no tetrahedra");
  if (!background.is_compact() || sizes_mm.size() != background.vertex_count())
    throw Error(ErrorKind::kBadInput,
                fmt::format("the size mesh has {} vertices and {} sizes: give one for each",
                            background.vertex_count(), sizes_mm.size()));
  background.enable_metric();
  for (std::uint32_t v = 0; v < background.vertex_count(); ++v) {
    const double size = sizes_mm[v];
    if (!(size > 0) || !std::isfinite(size))
      throw Error(ErrorKind::kBadInput,
                  fmt::format("the size mesh has {:g} at vertex {}: sizes are finite and > 0 mm", size, v));
    const double inverse = 1 / (size * size), log = -2 * std::log(size);
    background.set_metric(VertexId(v), SymTensor::diagonal(inverse, inverse, inverse),
                          SymTensor::diagonal(log, log, log));
  }
  return std::make_unique<MeshSizing>(std::move(background));
}

std::unique_ptr<Sizing> combined_size(std::vector<std::unique_ptr<Sizing>> parts) {
  return std::make_unique<CombinedSizing>(std::move(parts));
}

}  // namespace lumesh
