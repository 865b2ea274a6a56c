#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/core/sort_unique.hpp"
#include "lumesh/image/grey_values.hpp"
#include "lumesh/parallel/loops.hpp"
#include "lumesh/parallel/sum.hpp"
#include "raw_image.hpp"

namespace lumesh::io {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kVoxelsPerBlock = std::size_t{1} << 18;
constexpr std::size_t kMaxLabels = std::numeric_limits<LabelImage::Index>::max();
constexpr std::size_t kListedLabels = 20;

/// Different values of a part of the image.
template <class Voxel>
struct ValueSet {
  std::vector<Voxel> values;  ///< Ascending, without repeats.
  bool fractional = false;
};

template <class Voxel>
ValueSet<Voxel> values_of_block(const Voxel* begin, const Voxel* end) {
  ValueSet<Voxel> set;
  for (const Voxel* v = begin; v != end;) {
    const Voxel value = *v;
    if constexpr (std::is_floating_point_v<Voxel>) {
      set.fractional = set.fractional || std::trunc(value) != value;
    }
    set.values.push_back(value);
    if (set.fractional) break;
    // Runs of one value are long in label images.
    while (v != end && *v == value) ++v;
  }
  sort_unique(set.values);
  return set;
}

template <class Voxel>
ValueSet<Voxel> merge(ValueSet<Voxel> a, ValueSet<Voxel> b) {
  a.fractional = a.fractional || b.fractional;
  if (b.values.empty() || a.values.size() > kMaxLabels + 1) return a;
  std::vector<Voxel> both;
  both.reserve(a.values.size() + b.values.size());
  std::set_union(a.values.begin(), a.values.end(), b.values.begin(), b.values.end(),
                 std::back_inserter(both));
  a.values = std::move(both);
  return a;
}

/// What to do with an image that is none of labels.
template <class Voxel>
[[noreturn]] void fail_as_values(std::span<const Voxel> voxels, const fs::path& path,
                                 const std::string& why) {
  const GreyValues grey = grey_values(voxels);
  const double threshold = grey.otsu_threshold();
  throw NotLabels(
      ErrorKind::kBadInput,
      fmt::format(
          "{}: {}; its values are from {:.6g} to {:.6g}: mesh what is at or above one by `threshold` "
          "VALUE, at or below one by `below` VALUE ({:.4g} parts them best, {:.1f} % are at or above; "
          "lumesh info shows the histogram)",
          path.string(), why, grey.least, grey.most, threshold, 100 * grey.share_from(threshold)));
}

template <class Voxel>
std::vector<Voxel> find_values(std::span<const Voxel> voxels, const fs::path& path) {
  const ValueSet<Voxel> set = parallel::reduce_blocks(
      voxels.size(), kVoxelsPerBlock, ValueSet<Voxel>{},
      [&](std::size_t begin, std::size_t end) {
        return values_of_block(voxels.data() + begin, voxels.data() + end);
      },
      [](ValueSet<Voxel> a, ValueSet<Voxel> b) { return merge(std::move(a), std::move(b)); });
  if (set.fractional) fail_as_values(voxels, path, "has voxels with fractions, so it is no label image");
  const auto background = std::ranges::count(set.values, Voxel{0});
  if (set.values.size() - static_cast<std::size_t>(background) > kMaxLabels)
    fail_as_values(voxels, path, fmt::format("has more than {} different labels", kMaxLabels));
  return set.values;
}

/// The file's labels in ascending order with 0 in front, checked.
template <class Voxel>
std::vector<Label> labels_from_values(std::span<const Voxel> voxels, const fs::path& path) {
  const std::vector<Voxel> values = find_values(voxels, path);
  std::vector<Label> labels = {kBackground};
  for (const Voxel value : values) {
    if constexpr (std::is_signed_v<Voxel>)
      if (value < 0)
        fail_as_values(
            voxels, path,
            fmt::format("has the negative label {}, and labels are positive", static_cast<double>(value)));
    if (static_cast<double>(value) > static_cast<double>(std::numeric_limits<Label>::max()))
      fail(path, fmt::format("has the label {}; labels must be below 2^31: renumber them",
                             static_cast<double>(value)));
    if (value != 0) labels.push_back(static_cast<Label>(value));
  }
  if (labels.size() == 1) fail(path, "no voxel has a label (all are 0)");
  return labels;
}

std::string list_labels(const std::vector<Label>& labels) {
  std::string list;
  for (std::size_t i = 1; i < labels.size(); ++i) {
    if (i > kListedLabels) return list + ", ...";
    if (i > 1) list += ", ";
    list += std::to_string(labels[i]);
  }
  return list;
}

std::vector<Label> keep_labels(const std::vector<Label>& present, std::vector<Label> wanted,
                               const fs::path& path) {
  sort_unique(wanted);
  for (const Label label : wanted) {
    if (label <= 0) fail(path, fmt::format(kNoMaterial, label));
    if (!std::ranges::binary_search(present, label))
      fail(path, fmt::format("no voxel has label {}; labels present: {}", label, list_labels(present)));
  }
  wanted.insert(wanted.begin(), kBackground);
  return wanted;
}

/// Index of each value in `labels`, 0 for those that are not kept.
template <class Voxel>
void map_voxels(std::span<const Voxel> voxels, const std::vector<Label>& labels, LabelImage& image) {
  parallel::for_each_block(
      voxels.size(), kVoxelsPerBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
        LabelImage::Index* const out = image.voxels().data();
        for (std::size_t i = begin; i < end;) {
          const Voxel value = voxels[i];
          const auto found = std::ranges::lower_bound(labels, static_cast<Label>(value));
          const bool kept = found != labels.end() && *found == static_cast<Label>(value);
          const auto index = static_cast<LabelImage::Index>(kept ? found - labels.begin() : 0);
          for (; i < end && voxels[i] == value; ++i) out[i] = index;
        }
      });
}

std::string nothing_found(const ObjectValues& object, const GreyValues& grey) {
  const std::string range = fmt::format("its values are from {:.6g} to {:.6g}", grey.least, grey.most);
  if (!std::isfinite(object.high))
    return fmt::format("no voxel is at or above the threshold {}; {}", object.low, range);
  if (!std::isfinite(object.low)) return fmt::format("no voxel is at or below {}; {}", object.high, range);
  return fmt::format("no voxel is from {} to {}; {}", object.low, object.high, range);
}

template <class Voxel>
LabelImage label_range(std::span<const Voxel> voxels, const ImageFrame& frame, const ObjectValues& wanted,
                       const fs::path& path) {
  const ObjectValues object = as_stored<Voxel>(wanted);
  LabelImage image(frame, {kBackground, 1});
  const auto inside = parallel::sum<std::size_t>(voxels.size(), kVoxelsPerBlock, [&](std::size_t i) {
    image.voxels()[i] = object.contain(static_cast<double>(voxels[i])) ? 1 : 0;
    return image.voxels()[i];
  });
  if (inside == 0) fail(path, nothing_found(wanted, grey_values(voxels)));
  return image;
}

/// As grey values do, unlike labels: along two axes or more, of the neighbours that are both in the object.
bool neighbours_mostly_differ(const LabelImage& image) {
  constexpr std::size_t kFewLabels = 32;
  if (image.values().size() <= kFewLabels) return false;
  struct Pairs {
    std::array<std::size_t, 3> all = {}, different = {};
  };
  const Index3& size = image.frame().size;
  const Pairs pairs = parallel::reduce(
      grid_row_count(size), 256, Pairs{},
      [&](Pairs& block, std::size_t row) {
        for_each_step_from_row(size, row, [&](std::size_t i, std::size_t next, std::size_t axis) {
          const LabelImage::Index a = image.voxels()[i], b = image.voxels()[next];
          block.all[axis] += static_cast<std::size_t>(a != 0 && b != 0);
          block.different[axis] += static_cast<std::size_t>(a != 0 && b != 0 && a != b);
        });
      },
      [](const Pairs& a, const Pairs& b) {
        return Pairs{parallel::AddEach()(a.all, b.all), parallel::AddEach()(a.different, b.different)};
      });
  int axes = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) axes += 2 * pairs.different[axis] > pairs.all[axis] ? 1 : 0;
  return axes >= 2;
}

/// Voxels of each label, and those among them with a smaller value on one side and a greater one on the
/// other.
struct StepVoxels {
  std::vector<std::uint64_t> all, between;
};

StepVoxels step_voxels(const LabelImage& image) {
  const Index3& size = image.frame().size;
  const std::array<std::size_t, 3> steps = {
      1, static_cast<std::size_t>(size.x()),
      static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y())};
  const std::span<const LabelImage::Index> voxels = image.voxels();
  std::vector<StepVoxels> slices(static_cast<std::size_t>(size.z()));
  parallel::for_each_index(slices.size(), 1, [&](std::size_t k) {
    StepVoxels& slice = slices[k];
    slice.all.assign(image.values().size(), 0);
    slice.between.assign(image.values().size(), 0);
    Index3 at(0, 0, static_cast<int>(k));
    for (std::size_t i = k * steps[2]; i < (k + 1) * steps[2]; ++i) {
      const LabelImage::Index own = voxels[i];
      if (own != 0) {
        bool is_between = false;
        for (int axis = 0; axis < 3; ++axis) {
          const std::size_t step = steps.at(static_cast<std::size_t>(axis));
          const LabelImage::Index before = at[axis] > 0 ? voxels[i - step] : own,
                                  behind = at[axis] + 1 < size[axis] ? voxels[i + step] : own;
          is_between = is_between || (before < own && own < behind) || (before > own && own > behind);
        }
        ++slice.all[own];
        slice.between[own] += static_cast<std::uint64_t>(is_between);
      }
      if (++at.x() == size.x()) at.x() = 0, ++at.y();
    }
  });
  StepVoxels sum = std::move(slices.front());
  for (std::size_t k = 1; k < slices.size(); ++k)
    for (std::size_t label = 0; label < sum.all.size(); ++label) {
      sum.all[label] += slices[k].all[label];
      sum.between[label] += slices[k].between[label];
    }
  return sum;
}

/// Whether most labels are but steps from smaller to greater values, as those of a soft mask: in half of
/// them, more than 2 in 5 voxels lie between the two. In masks blurred by 0.4 to 2 voxels, with noise or
/// without, in 8 to 31 steps, this median is 0.64 to 1; of segmentations of 5 to 312 labels 0.01 at most.
bool are_mostly_steps(const LabelImage& image) {
  constexpr std::size_t kFewest = 6, kMost = 1024;  // Labels; lumens in walls of four layers are nested, too.
  constexpr double kMedian = 0.4;
  const std::size_t labels = image.values().size() - 1;
  if (labels < kFewest || labels > kMost) return false;
  const StepVoxels counts = step_voxels(image);
  std::size_t present = 0, steps = 0;
  for (std::size_t label = 1; label <= labels; ++label) {
    present += counts.all[label] > 0 ? 1U : 0U;
    steps += static_cast<double>(counts.between[label]) > kMedian * static_cast<double>(counts.all[label])
                 ? 1U
                 : 0U;
  }
  return 2 * steps > present;
}

/// Why an image that is read as one of labels looks like one of grey values; empty if it does not.
std::string looks_grey(const LabelImage& image) {
  const std::size_t labels = image.values().size() - 1;
  if (neighbours_mostly_differ(image))
    return fmt::format("has {} different values, and neighbours mostly differ", labels);
  if (are_mostly_steps(image))
    return fmt::format(
        "has {} different values, and voxels of most of them lie between smaller and greater ones", labels);
  return "";
}

template <class Voxel>
LabelImage number_typed(std::span<const Voxel> voxels, const ImageFrame& frame, const fs::path& path,
                        const std::vector<Label>& wanted) {
  std::vector<Label> labels = labels_from_values(voxels, path);
  if (!wanted.empty()) labels = keep_labels(labels, wanted, path);
  LabelImage image(frame, labels);
  map_voxels(voxels, labels, image);
  if (!wanted.empty()) return image;
  if (const std::string why = looks_grey(image); !why.empty())
    fail_as_values(voxels, path,
                   why +
                       ": these look like grey values rather than labels (if they are labels, name them by "
                       "`labels`)");
  return image;
}

}  // namespace

void fail_as_grey(const RawImage& raw, const fs::path& path, const std::string& why) {
  visit_voxels(raw, [&](auto voxels) { fail_as_values(voxels, path, why); });
  throw Error(ErrorKind::kBadInput, why);  // Not reached.
}

LabelImage number_labels(const RawImage& raw, const fs::path& path, const std::vector<Label>& wanted) {
  return visit_voxels(raw, [&](auto voxels) { return number_typed(voxels, raw.frame, path, wanted); });
}

LabelImage label_values(const RawImage& raw, const ObjectValues& object, const fs::path& path) {
  return visit_voxels(raw, [&](auto voxels) { return label_range(voxels, raw.frame, object, path); });
}

}  // namespace lumesh::io
