// Labels from several masks or probabilities, and voxels that are not numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "file_fault.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"
#include "raw_image.hpp"

namespace lumesh::io {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSourceVoxelsPerBlock = std::size_t{1} << 18;
constexpr double kRounding = 1e-3;  // As sums of a network's outputs have it.
constexpr double kSumRounding = 0.02;
constexpr float kCertain = std::numeric_limits<float>::infinity();  // A mask's voxel has no value beside it.

/// Labels from sources one after the other, of which the first that is more likely than not decides; among
/// voxels that only all of them together are, the likeliest.
class LabelSum {
 public:
  LabelSum(const ImageFrame& frame, std::vector<Label> labels)
      : image_(frame, with_background(std::move(labels))),
        total_(frame.voxel_count(), 0.0F),
        most_(frame.voxel_count(), 0.0F) {}

  /// @param likelihood_at  Of a voxel: from 0 to 1, or kCertain.
  /// @return How many voxels belong to a source before this, too.
  template <class LikelihoodAt>
  std::size_t add(Label label, const LikelihoodAt& likelihood_at) {
    const auto index = static_cast<LabelImage::Index>(
        std::lower_bound(image_.values().begin() + 1, image_.values().end(), label) -
        image_.values().begin());
    return parallel::sum<std::size_t>(total_.size(), kSourceVoxelsPerBlock, [&](std::size_t v) {
      const float likelihood = likelihood_at(v);
      if (!(likelihood > 0)) return 0;
      const bool is_taken = most_[v] >= kHalf;
      total_[v] += likelihood;
      if (is_taken) return likelihood >= kHalf ? 1 : 0;
      if (likelihood > most_[v]) {
        most_[v] = likelihood;
        image_.voxels()[v] = index;
      }
      return 0;
    });
  }

  /// With crossings where no mask stands at the boundary.
  LabelImage finish() && {
    parallel::for_each_index(total_.size(), [&](std::size_t v) {
      if (!(total_[v] >= kHalf)) image_.voxels()[v] = 0;
    });
    static_cast<void>(find_crossings(std::span<const float>(total_), kEvenProbability, image_));
    return std::move(image_);
  }

 private:
  static constexpr float kHalf = static_cast<float>(kEvenProbability);

  static std::vector<Label> with_background(std::vector<Label> labels) {
    labels.push_back(kBackground);
    sort_unique(labels);
    return labels;
  }

  LabelImage image_;
  std::vector<float> total_, most_;
};

/// What several volumes are together, voxel by voxel.
struct ClassValues {
  bool are_probabilities = true, add_up_to_one = true;
};

template <class Value>
ClassValues class_values(std::span<const Value> values, std::size_t voxels, std::size_t volumes) {
  return parallel::reduce(
      voxels, kSourceVoxelsPerBlock, ClassValues{},
      [&](ClassValues& found, std::size_t v) {
        double sum = 0;
        for (std::size_t n = 0; n < volumes; ++n) {
          const auto value = static_cast<double>(values[n * voxels + v]);
          found.are_probabilities &= value >= -kRounding && value <= 1 + kRounding;
          sum += value;
        }
        found.add_up_to_one &= std::abs(sum - 1) <= kSumRounding;
      },
      [](const ClassValues& a, const ClassValues& b) {
        return ClassValues{a.are_probabilities && b.are_probabilities, a.add_up_to_one && b.add_up_to_one};
      });
}

std::vector<Label> wanted_classes(std::size_t classes, const std::vector<Label>& wanted,
                                  const fs::path& path) {
  std::vector<Label> labels;
  for (std::size_t c = 1; c <= classes; ++c) labels.push_back(static_cast<Label>(c));
  if (wanted.empty()) return labels;
  for (const Label label : wanted)
    if (label < 1 || label > labels.back())
      fail(path,
           fmt::format("has no label {}; its probabilities are of the labels 1 to {}", label, labels.back()));
  labels = wanted;
  sort_unique(labels);
  return labels;
}

/// The likelihood of each voxel of a file, as kCertain where it is a mask.
std::vector<float> likelihoods_of(const RawImage& raw, const fs::path& path) {
  std::vector<float> result(raw.frame.voxel_count());
  const bool is_soft = are_probabilities(raw);
  const bool is_mask = visit_voxels(raw, [&](auto voxels) {
    return is_soft || std::ranges::all_of(voxels, [](auto v) {
             return static_cast<double>(v) >= 0 &&
                    std::trunc(static_cast<double>(v)) == static_cast<double>(v);
           });
  });
  if (!is_mask)
    fail(path, "is neither a mask nor probabilities from 0 to 1; label images are one or the other");
  visit_voxels(raw, [&](auto voxels) {
    parallel::for_each_index(voxels.size(), [&](std::size_t v) {
      const auto value = static_cast<float>(voxels[v]);
      result[v] = is_soft ? value : value != 0 ? kCertain : 0.0F;
    });
  });
  if (std::ranges::none_of(result, [](float p) { return p >= 0.5F; }))
    fail(path, "no voxel of it is in the mask");
  return result;
}

/// Crossings of the first where both have one.
std::vector<FaceCrossing> merged_crossings(const std::vector<FaceCrossing>& first,
                                           const std::vector<FaceCrossing>& second) {
  const auto is_before = [](const FaceCrossing& a, const FaceCrossing& b) {
    return a.voxel != b.voxel ? a.voxel < b.voxel : a.axis < b.axis;
  };
  std::vector<FaceCrossing> all;
  std::set_union(first.begin(), first.end(), second.begin(), second.end(), std::back_inserter(all),
                 is_before);
  return all;
}

}  // namespace

void warn_of_nan(NanVoxels what, const fs::path& path, const Context& context, RawImage& raw) {
  struct Found {
    std::size_t count = 0, first = std::numeric_limits<std::size_t>::max();
  };
  const Found found = visit_voxels(raw, [&](auto voxels) {
    return parallel::reduce(
        voxels.size(), kSourceVoxelsPerBlock, Found{},
        [&](Found& block, std::size_t v) {
          if (!std::isnan(static_cast<double>(voxels[v]))) return;
          ++block.count;
          block.first = std::min(block.first, v);
        },
        [](const Found& a, const Found& b) {
          return Found{a.count + b.count, std::min(a.first, b.first)};
        });
  });
  if (found.count == 0) return;
  const ImageFrame& frame = raw.frame;
  const Index3 voxel = frame.voxel_at(found.first % frame.voxel_count());
  const Vec3 place = frame.to_physical(voxel.cast<double>());
  context.warn(fmt::format(
      "{}: has {} voxels that are not numbers (NaN), such as ({}, {}, {}) at {:.4g}, {:.4g}, "
      "{:.4g} mm; they are taken for background",
      path.string(), found.count, voxel.x(), voxel.y(), voxel.z(), place.x(), place.y(), place.z()));
  if (what == NanVoxels::kStay) return;
  visit_voxel_type(raw.type, [&](auto example) {
    auto* const values = reinterpret_cast<decltype(example)*>(raw.voxels.get());
    parallel::for_each_index(raw.value_count(), [&](std::size_t i) {
      if (std::isnan(static_cast<double>(values[i]))) values[i] = 0;
    });
  });
}

LabelImage label_classes(const RawImage& raw, const fs::path& path, const std::vector<Label>& wanted,
                         const Context& context) {
  const std::size_t voxels = raw.frame.voxel_count();
  const ClassValues are =
      visit_voxels(raw, [&](auto values) { return class_values(values, voxels, raw.volumes); });
  if (!are.are_probabilities) fail(path, several_volumes_text(raw.volumes));
  const std::size_t first = are.add_up_to_one ? 1 : 0;
  const std::vector<Label> labels = wanted_classes(raw.volumes - first, wanted, path);
  context.warn(fmt::format(
      "{}: its {} volumes are taken for probabilities, {}", path.string(), raw.volumes,
      are.add_up_to_one
          ? "the first of the background, since they add up to 1, the others of the labels 1, 2, …"
          : "of the labels 1, 2, …"));
  LabelSum sum(raw.frame, labels);
  visit_voxels(raw, [&](auto values) {
    for (const Label label : labels) {
      const std::size_t offset = (static_cast<std::size_t>(label) - 1 + first) * voxels;
      static_cast<void>(
          sum.add(label, [&](std::size_t v) { return static_cast<float>(values[offset + v]); }));
    }
  });
  LabelImage image = std::move(sum).finish();
  if (std::ranges::all_of(image.voxels(), [](LabelImage::Index l) { return l == 0; }))
    fail(path, "in no voxel is a label more probable than the background");
  return image;
}

void add_label_images(std::span<const LabelledFile> files, const ImageReadOptions& options,
                      const fs::path& path, Context& context, LabelImage& image) {
  std::vector<Label> labels(image.values().begin() + 1, image.values().end());
  for (const LabelledFile& file : files) {
    if (file.label <= 0) fail(file.path, fmt::format(kNoMaterial, file.label));
    labels.push_back(file.label);
  }
  LabelSum sum(image.frame(), labels);
  for (std::size_t l = 1; l < image.values().size(); ++l)
    static_cast<void>(
        sum.add(image.values()[l], [&](std::size_t v) { return image.voxels()[v] == l ? kCertain : 0.0F; }));
  for (const LabelledFile& file : files) {
    const FileChoice choice = {count_frames(file.path) > 1 ? options.frame : std::nullopt, options.unit_mm};
    RawImage raw = read_raw(file.path, choice, context);
    if (raw.volumes > 1) fail(file.path, several_volumes_text(raw.volumes));
    require_same_grid(raw.frame, image.frame(), file.path);
    warn_of_nan(NanVoxels::kBecomeZero, file.path, context, raw);
    const std::vector<float> likelihoods = likelihoods_of(raw, file.path);
    const std::size_t shared = sum.add(file.label, [&](std::size_t v) { return likelihoods[v]; });
    if (shared > 0)
      context.warn(fmt::format("{}: {} of its voxels are in {} or a file before it, too, and keep that label",
                               file.path.string(), shared, path.filename().string()));
  }
  std::vector<FaceCrossing> own = std::move(image.crossings());
  std::map<Label, std::string> names = std::move(image.label_names());
  image = std::move(sum).finish();
  image.crossings() = merged_crossings(own, image.crossings());
  image.label_names() = std::move(names);
}

}  // namespace lumesh::io
