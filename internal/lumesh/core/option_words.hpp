#pragma once
/// @file Options as words of a command line, as files note them, and back.

#include <string>
#include <string_view>
#include <vector>

#include "lumesh/core/option.hpp"

namespace lumesh {

/// Rows and texts of options as such words: "--cut-at 1,2,3" for each row that there is, and each value of a
/// text. Options of other kinds are left out.
[[nodiscard]] std::vector<std::string> option_words(const OptionList& list);
/// Takes such words. Other options among them, and what has no sense, are skipped: the words are what a file
/// says, which may be damaged.
void take_option_words(const std::string& words, const OptionList& list);

/// Makes an option what value_text() calls "none". False, and nothing is changed, where it is never so, or
/// where "none" is one of its words.
bool take_none(const Option& option);

/// An option's name there: "--split-above" for "split_above".
[[nodiscard]] std::string flag_of(std::string_view name);

}  // namespace lumesh
