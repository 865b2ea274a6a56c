#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/core/parse_number.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "lumesh/stages/input.hpp"
#include "lumesh/stages/input_parts.hpp"
#include "lumesh/stages/mesh_cut.hpp"

namespace lumesh {
namespace {

std::vector<std::vector<double>> rows_of(const std::vector<CutPlane>& planes) {
  std::vector<std::vector<double>> rows;
  for (const CutPlane& plane : planes) {
    const Vec3 &p = plane.point_mm, &n = plane.normal;
    rows.push_back({p[0], p[1], p[2], n[0], n[1], n[2]});
  }
  return rows;
}

std::vector<CutPlane> planes_from(const std::vector<std::vector<double>>& rows) {
  std::vector<CutPlane> planes;
  for (const std::vector<double>& n : rows) {
    planes.push_back({Vec3(n[0], n[1], n[2]), Vec3(n[3], n[4], n[5])});
    const double squared = planes.back().normal.squaredNorm();
    if (squared == 0 && planes.back().normal.isZero(0))
      throw Error(ErrorKind::kUsage, "has a plane whose normal is zero");
    if (!std::isnormal(squared))
      throw Error(
          ErrorKind::kUsage,
          "has a plane whose normal is too short or too long to tell a direction; give it a length of "
          "about 1");
  }
  return planes;
}

std::vector<std::vector<double>> threshold_rows(const std::optional<double>& low,
                                                const std::optional<double>& high) {
  if (!low) return {};
  return {high ? std::vector<double>{*low, *high} : std::vector<double>{*low}};
}

}  // namespace

void ImageSelection::require_image(const std::string& path) const {
  if (const std::vector<std::string> options = given(); path.empty() && !options.empty())
    throw Error(ErrorKind::kUsage, fmt::format("{} says what of {} to take; give it",
                                               option_name(options.front()), option_name("image")));
}

std::vector<std::string> ImageSelection::given() const {
  return differing_options(*this, ImageSelection());
}

std::vector<std::string> ImageSelection::other_files() const {
  std::vector<std::string> files = {probabilities};
  for (const auto& [file, label] : label_images) files.push_back(file);
  return files;
}

std::optional<std::size_t> ImageSelection::one_frame() const {
  if (all_frames)
    throw Error(ErrorKind::kUsage, "`all_frames` is for making a mesh of each frame; choose one by `frame`");
  if (!frame) return std::nullopt;
  constexpr double kMax = 1e9;
  if (*frame != std::floor(*frame) || *frame > kMax)
    throw Error(ErrorKind::kUsage, "`frame` must be a whole number");
  return static_cast<std::size_t>(*frame);
}

ImageReadOptions ImageSelection::read_options() const {
  ImageReadOptions options;
  for (const std::string& word : labels)
    if (const std::optional<Label> number = parse_number<Label>(word))
      options.labels.push_back(*number);
    else
      options.label_names.push_back(word);
  options.threshold = threshold;
  options.below = threshold ? threshold_up_to : below;
  options.level_set = level_set;
  options.probabilities = probabilities;
  for (const auto& [file, label] : label_images) options.label_images.push_back({file, label});
  options.frame = one_frame();
  if (!unit.empty()) options.unit_mm = unit_in_mm(unit);
  return options;
}

namespace {

void set_threshold(ImageSelection& selection, const std::vector<std::vector<double>>& rows) {
  selection.threshold.reset();
  selection.threshold_up_to.reset();
  if (rows.empty()) return;
  selection.threshold = rows[0][0];
  if (rows[0].size() > 1) selection.threshold_up_to = rows[0][1];
  if (selection.threshold_up_to && *selection.threshold_up_to < *selection.threshold)
    throw Error(ErrorKind::kUsage, "must have the lower value first");
}

/// Options of images that hold values rather than labels.
void describe_values(OptionList& list, ImageSelection& selection) {
  list.rows("threshold",
            {2, "150,400", true,
             [&selection] { return threshold_rows(selection.threshold, selection.threshold_up_to); },
             [&selection](const auto& rows) { set_threshold(selection, rows); }, 1, "LOW[,HIGH]"},
            "Voxels at or above, or from one value to another, become label 1, the rest background; their "
            "values place the boundary between voxels")
      .in("image value")
      .excludes("below");
  list.number("below", selection.below, any_number(),
              "The same for voxels at or below, where the object is dark")
      .in("image value");
  using Side = std::optional<LevelSetSide>;
  list.choice(
          "level_set", selection.level_set,
          {{"auto", Side()}, {"negative", LevelSetSide::kNegative}, {"positive", LevelSetSide::kPositive}},
          "Level sets and signed distances: the sign inside of the object, label 1. auto: values that "
          "look like distances are taken for such, the rarer sign for the inside, with a warning")
      .excludes("labels")
      .excludes("threshold")
      .excludes("below");
}

/// Options that change voxels before anything is made of them.
void describe_edits(OptionList& list, ImageSelection& selection) {
  list.flag("largest_component", selection.largest_component,
            "Only the largest connected piece of all labels together");
  list.number("drop_below", selection.drop_below, at_least(1),
              "Pieces of all labels together that have fewer voxels go")
      .in("voxels")
      .zero("none");
  list.flag("fill_cavities", selection.fill_cavities, "Background that is enclosed gets the label around it");
  list.choice(
      "touching", selection.touching,
      {{"keep", TouchChoice::kKeep}, {"separate", TouchChoice::kSeparate}, {"join", TouchChoice::kJoin}},
      "Vessels side by side that touch, or a voxel apart: stay so, are separated by a layer of voxels or "
      "two, "
      "or joined by filling the cleft; lumesh check lists them");
}

}  // namespace

void ImageSelection::describe(OptionList& list, bool has_probabilities) {
  list.labels("labels", labels, "Labels of the image to take, by their numbers or names; none: all")
      .excludes("threshold")
      .excludes("below");
  describe_values(list, *this);
  if (has_probabilities)
    list.path("probabilities", probabilities,
              "Image of the object's probability, 0 to 1, on the label image's grid, which places the "
              "boundary between voxels")
        .excludes("threshold")
        .excludes("below")
        .excludes("level_set")
        .excludes("label_images");
  list.labelled_files(
          "label_images", label_images,
          "Mask, or probabilities, on the same grid that becomes another label; voxels of several "
          "have the label of the first, and the image comes before all")
      .alias("label_image");
  list.number("frame", frame, at_least(0),
              "Of an image of several volumes, such as a series in time: which; 0 is the first")
      .excludes("all_frames");
  list.flag("all_frames", all_frames,
            "Every volume in its turn, each with files of its own: NAME_000, NAME_001, …");
  describe_edits(list, *this);
}

void describe_unit(OptionList& list, std::string& unit) {
  list.choice("unit", unit, length_units(true),
              "Unit of lengths in the input, whatever it says itself; file: as it says, else mm");
}

void describe_out_unit(OptionList& list, std::string& unit, bool may_stay) {
  list.choice("out_unit", unit, length_units(may_stay),
              fmt::format("Unit of lengths in files that are written; {}OpenFOAM gets metres in any case",
                          may_stay ? "file: as they are; " : ""));
}

void describe_planes(OptionList& list, std::vector<CutPlane>& planes) {
  list.rows("cut_planes",
            {6, "0,0,10,0,0,-1", false, [&planes] { return rows_of(planes); },
             [&planes](const auto& rows) { planes = planes_from(rows); }},
            "Planes x, y, z, nx, ny, nz, through everything: what lies on the normal's side is cut off")
      .in("mm")
      .alias("cut_plane");
}

void InputCuts::describe(OptionList& list) {
  describe_planes(list, planes);
  list.rows("cut_at",
            {3, "12.5,-40,8", false,
             [this] {
               std::vector<std::vector<double>> rows;
               for (const Vec3& p : places_mm) rows.push_back({p[0], p[1], p[2]});
               return rows;
             },
             [this](const auto& rows) {
               places_mm.clear();
               for (const std::vector<double>& p : rows) places_mm.emplace_back(p[0], p[1], p[2]);
             }},
            "Places x, y, z: the vessel there, and no other, is cut square to its axis, and its smaller part "
            "goes")
      .in("mm");
  list.parsed("clip_ends", local_length_option(ends),
              "Every end of a vessel is cut off square to its axis, so far before it: a number in mm, or 1r "
              "in local radii");
  extension.describe(list);
}

void InputCuts::validate() const {
  if (ends && !ends->is_valid()) throw Error(ErrorKind::kUsage, option_name("clip_ends") + " is no length");
  extension.validate();
}

}  // namespace lumesh
