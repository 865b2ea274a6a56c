#include "border_sections.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "border_pieces.hpp"
#include "lumesh/field/section_error.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::field {

namespace {

constexpr double kWidest = 8;  // Radius in voxels: sections of wider vessels are right.
constexpr int kFirstSettled = 2, kLastSettled = 4,
              kDeepest = 6;  // Steps: sections between are as true as any.
// A vessel is at least that long, in steps and in radii.
constexpr int kLeastLength = 7, kMaxLength = 11;
constexpr double kLeastRadii = 1.3;
constexpr int kRoom = 3;           // Voxels around sections near the border.
constexpr double kShiftReach = 5;  // Steps: shifts are nothing further in.

// Sections in the logarithms of their areas. Equations and figures: docs/stages/domain.md.
constexpr double kTakenChange = 0.8;  // of the change from the settled sections to the border: it is error
constexpr double kTakenTrend = 0.5;   // of the change a step further in: it goes on to the border
constexpr double kSteady = 0.03;      // changes a step, and off a steady change, of what is a vessel
constexpr double kSteadyThin = 0.3;   // over the radius in voxels: beside it, of thin ones
constexpr double kMostChange = 0.8,
                 kMostChangeThick = 1.5;  // the second over the radius in voxels: of thick ones
constexpr double kSteepest = 1.2;         // slope of the axis against the border's normal
// A disc of radius r holds pi r^2 lattice points, with a standard deviation of about 0.82 sqrt(r).
constexpr double kCountDeviation = 0.82, kAllowedDeviations = 1;
constexpr double kVariancePerLength = 0.108;  // the same of an outline's length: 0.82^2 / (2 pi)
constexpr double kLeastChange = 0.005;        // of a section
constexpr double kFading = 1.2;               // of the error, a step
constexpr double kMostShift = 0.4;            // edges of the smallest voxel, at once

/// Sections of one piece of the object, at the border and further in.
class Vessel {
 public:
  Vessel(const SectionFinder& finder, const SectionWindow& window, const std::vector<std::uint8_t>& in_layer)
      : finder_(finder), window_(window) {
    const std::vector<std::uint8_t>* over = &in_layer;
    cuts_.reserve(kMaxLength + 1);
    for (int depth = 0;
         depth <= kLeastLength || depth <= std::min<double>(kMaxLength, kLeastRadii * radius()); ++depth) {
      std::optional<PlaneSection> cut = finder.find(*over, depth, depth <= kFirstSettled ? kRoom : 1);
      if (!cut) return;
      cuts_.push_back(std::move(*cut));
      over = &cuts_.back().is_inside;
    }
    is_long_ = true;
    squared_slopes_ = squared_slopes();
  }

  [[nodiscard]] const std::vector<PlaneSection>& cuts() const { return cuts_; }

  /// By which factor the section at the border is to change; 1 if nothing tells.
  /// @param in_layer  How many voxels of the image's last layer it has.
  [[nodiscard]] double change(double in_layer) const {
    if (cuts_.size() <= kFirstSettled || radius() > kWidest) return 1;
    const std::optional<PlaneSection> layer = finder_.find(cuts_[0].is_inside, 0.5 / window_.step, 0);
    if (!layer) return 1;
    const double too_much = std::log(layer->area / (in_layer * kSquaresPerVoxel * kSquaresPerVoxel));
    const double allowed = kAllowedDeviations * kCountDeviation * std::sqrt(radius()) / in_layer;
    const double error =
        std::clamp(error_at_border().value_or(0), std::min(0.0, (too_much - allowed) / kLayerShare),
                   std::max(0.0, (too_much + allowed) / kLayerShare));
    const double chance = std::sqrt(kVariancePerLength * layer->growth) / (kSquaresPerVoxel * in_layer);
    const double change = std::log(cuts_[kFirstSettled].area / cuts_[0].area) + error;
    return std::exp(-error - section_error(radius(), change, too_much - kLayerShare * error, chance).mean);
  }

 private:
  /// Logarithm of the section at the border, over that of the sections further in; none if they are not those
  /// of a vessel.
  [[nodiscard]] std::optional<double> error_at_border() const {
    if (!is_long_ || squared_slopes_[0] > kSteepest * kSteepest) return std::nullopt;
    const double last = square_to_axis(0), first = square_to_axis(kFirstSettled),
                 middle = square_to_axis(kLastSettled), deepest = square_to_axis(kDeepest);
    const double trend = (first - deepest) / (kDeepest - kFirstSettled),
                 bend = middle - 0.5 * (first + deepest), slack = kSteadyThin / radius();
    if (std::abs(trend) > kSteady + 0.25 * slack || std::abs(bend) > kSteady + 0.5 * slack ||
        std::abs(last - first) > std::min(kMostChange, kMostChangeThick / radius()))
      return std::nullopt;
    double settled = 0;
    for (int depth = kFirstSettled; depth <= kLastSettled; ++depth)
      settled += square_to_axis(static_cast<std::size_t>(depth)) / (kLastSettled - kFirstSettled + 1);
    return kTakenChange * (last - settled - kTakenTrend * 0.5 * (kFirstSettled + kLastSettled) * trend);
  }

  /// Radius of a circle of the settled section's area, in voxels.
  [[nodiscard]] double radius() const {
    return std::sqrt(cuts_[kFirstSettled].area / std::numbers::pi) / kSquaresPerVoxel;
  }

  /// Logarithm of the section square to the axis.
  [[nodiscard]] double square_to_axis(std::size_t depth) const {
    return std::log(cuts_[depth].area) - 0.5 * std::log1p(squared_slopes_[depth]);
  }

  /// Squares of the slope of the axis, a parabola through the centres, by depth.
  [[nodiscard]] std::vector<double> squared_slopes() const {
    const auto [u, v] = axes_across(window_.axis);
    Eigen::Matrix<double, kDeepest, 3> powers;
    Eigen::Matrix<double, kDeepest, 2> centres;
    for (int d = 1; d <= kDeepest; ++d) {
      powers.row(d - 1) << 1, d, d * d;
      centres.row(d - 1) = cuts_[static_cast<std::size_t>(d)].centre.transpose();
    }
    const Eigen::Matrix<double, 3, 2> parabola = powers.householderQr().solve(centres);
    const double step = finder_.edges()[window_.axis] * window_.step;
    const Eigen::Vector2d per_square =
        Eigen::Vector2d(finder_.edges()[u], finder_.edges()[v]) / (kSquaresPerVoxel * step);
    std::vector<double> result;
    for (int d = 0; d <= kDeepest; ++d) {
      const Eigen::Vector2d slope = parabola.row(1) + 2 * d * parabola.row(2);
      result.push_back(slope.cwiseProduct(per_square).squaredNorm());
    }
    return result;
  }

  const SectionFinder& finder_;
  const SectionWindow& window_;
  std::vector<PlaneSection> cuts_;
  std::vector<double> squared_slopes_;
  bool is_long_ = false;
};

/// Voxels around the sections near the border, and beyond it.
IndexBox voxels_around(const Vessel& vessel, const SectionWindow& window) {
  IndexBox box{Index3::Constant(std::numeric_limits<int>::max()), Index3::Constant(-1)};
  for (std::size_t depth = 0; depth <= kFirstSettled; ++depth) {
    const std::vector<std::uint8_t>& inside = vessel.cuts()[depth].is_inside;
    for (std::size_t s = 0; s < inside.size(); ++s)
      if (inside[s] != 0) box = {box.low.cwiseMin(window.voxel(s)), box.high.cwiseMax(window.voxel(s))};
  }
  Index3 around = Index3::Constant(kRoom);
  around[window.axis] = static_cast<int>(std::ceil(kShiftReach * window.step));
  return {box.low - around, box.high + around};
}

}  // namespace

float BorderShift::at(const Index3& voxel) const {
  const double depth = std::max(0.0, is_upper ? border - voxel[axis] : voxel[axis] - border);
  return static_cast<float>(at_border * std::exp(-depth / fading));
}

BorderSections::BorderSections(const LabelImage& image, const LabelField& field) {
  for (const BorderParts parts : {BorderParts::kObject, BorderParts::kEnclosedLabels}) {
    constexpr std::size_t kLumenAndWall = 3;  // With the background.
    if (parts == BorderParts::kEnclosedLabels && image.values().size() < kLumenAndWall) continue;
    for (int face = 0; face < 6; ++face) {
      const BorderLayer layer(image, parts, face / 2, face % 2 != 0, kMaxLength);
      const std::vector<BorderPiece> pieces = layer.pieces(kWidest, kRoom);
      std::vector<std::optional<Section>> found(pieces.size());
      parallel::for_each_index(pieces.size(), 1, [&](std::size_t i) {
        const BorderPiece& piece = pieces[i];
        const SectionFinder finder(field, piece.window, piece.label);
        const Vessel vessel(finder, piece.window, layer.squares_of(piece));
        const double change = vessel.change(static_cast<double>(piece.count));
        if (std::abs(change - 1) < kLeastChange) return;
        const PlaneSection& last = vessel.cuts().front();
        found[i] = {.label = piece.label,
                    .around = piece.around,
                    .window = piece.window,
                    .squares = last.is_inside,
                    .area = change * last.area,
                    .voxels = voxels_around(vessel, piece.window)};
      });
      for (std::optional<Section>& section : found)
        if (section) sections_.push_back(std::move(*section));
    }
  }
}

std::vector<BorderShift> BorderSections::shifts(const LabelField& field) const {
  std::vector<BorderShift> result(sections_.size());
  parallel::for_each_index(sections_.size(), 1, [&](std::size_t i) {
    const Section& section = sections_[i];
    const SectionWindow& window = section.window;
    const std::optional<PlaneSection> cut =
        SectionFinder(field, window, section.label).find(section.squares, 0, 0);
    if (!cut || std::abs(section.area / cut->area - 1) < kLeastChange) return;
    result[i] = {.label = section.label,
                 .around = section.around,
                 .axis = window.axis,
                 .is_upper = window.is_upper,
                 .voxels = section.voxels,
                 .border = window.border,
                 .fading = window.step / kFading,
                 .at_border = std::clamp((section.area - cut->area) / cut->growth, -kMostShift, kMostShift)};
  });
  std::erase_if(result, [](const BorderShift& shift) { return shift.at_border == 0; });
  return result;
}

}  // namespace lumesh::field
