#pragma once
/// @file Options of three numbers, one for each axis.

#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/core/option.hpp"

namespace lumesh {

/// Three numbers; a number alone stands for all of them. @param target  A vector of core/types.hpp.
template <class Vector>
[[nodiscard]] OptionRows three_numbers(Vector& target, std::string example) {
  using Number = typename Vector::Scalar;
  OptionRows numbers = {
      3, std::move(example), true,
      [&target] {
        std::vector<double> row;
        for (int i = 0; i < 3; ++i) row.push_back(static_cast<double>(target[i]));
        return std::vector<std::vector<double>>{std::move(row)};
      },
      [&target](const auto& rows) {
        for (int i = 0; i < 3; ++i) {
          const double value = rows[0][static_cast<std::size_t>(i)];
          if (std::is_integral_v<Number> &&
              (value != std::floor(value) || std::abs(value) > std::numeric_limits<Number>::max()))
            throw Error(ErrorKind::kUsage, "must be whole numbers");
          target[i] = static_cast<Number>(value);
        }
      }};
  numbers.may_be_none = false;
  return numbers;
}

/// The same where a number alone stands for nothing, such as angles about three axes.
template <class Vector>
[[nodiscard]] OptionRows exactly_three_numbers(Vector& target, std::string example) {
  OptionRows rows = three_numbers(target, std::move(example));
  rows.least = rows.width;
  return rows;
}

}  // namespace lumesh
