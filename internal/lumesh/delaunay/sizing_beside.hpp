#pragma once
/// @file Sizes of a mesher's own beside those that users ask for.

#include <algorithm>
#include <array>

#include "lumesh/delaunay/sizing.hpp"

namespace lumesh {

/// The smaller of two sizes, with the criterion of the one that was asked for.
class SizingBeside : public Sizing {
 public:
  /// @param asked  Lives as long as this; null: none.
  explicit SizingBeside(const Sizing* asked) : asked_(asked) {}

  [[nodiscard]] double size_at(const Vec3& point_mm, Label label) const final {
    const double size_mm = own_size_at(point_mm, label);
    return asked_ == nullptr ? size_mm : std::min(size_mm, asked_->size_at(point_mm, label));
  }
  [[nodiscard]] bool wants_finer(const std::array<Vec3, 4>& corners_mm) const final {
    return asked_ != nullptr && asked_->wants_finer(corners_mm);
  }
  [[nodiscard]] bool has_criterion() const final { return asked_ != nullptr && asked_->has_criterion(); }

 private:
  [[nodiscard]] virtual double own_size_at(const Vec3& point_mm, Label label) const = 0;

  const Sizing* asked_;
};

}  // namespace lumesh
