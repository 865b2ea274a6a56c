#pragma once
/// @file Words and numbers of a text file that may be broken anywhere.

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "file_fault.hpp"

namespace lumesh::io {

/// The whole file in memory; throws Error{kBadInput} if it cannot be read.
inline std::string read_whole_file(const std::filesystem::path& path) {
  check_file(path);
  std::error_code code;
  const auto bytes = std::filesystem::file_size(path, code);
  std::ifstream file(path, std::ios::binary);
  if (code || !file) fail(path, "cannot be read; check path and rights");
  std::string content(static_cast<std::size_t>(bytes), '\0');
  file.read(content.data(), static_cast<std::streamsize>(bytes));
  if (static_cast<std::uintmax_t>(file.gcount()) != bytes)
    fail(path, "cannot be read to its end; check the disk");
  return content;
}

/// Runs once over a text. Every failure throws Error{kBadInput} with file and line.
class TextScanner {
 public:
  /// `comment` starts a comment up to the end of its line; 0 for none.
  explicit TextScanner(const std::filesystem::path& path, char comment = '\0')
      : path_(path), text_(read_whole_file(path)), comment_(comment) {}

  /// A fault of the text, which another writing of the file may cure.
  [[noreturn]] void fail(std::string_view what) const {
    unsuitable(fmt::format("{}; write the file again", what));
  }
  /// A fault of what a well formed text holds, with its own cure if there is one.
  [[noreturn]] void unsuitable(std::string_view what) const {
    std::size_t line = 1;
    for (std::size_t i = 0; i < position_; ++i) line += text_[i] == '\n' ? 1 : 0;
    io::fail(path_, fmt::format("line {}: {}", line, what));
  }

  [[nodiscard]] std::string_view text() const { return text_; }

  /// True behind a blank; false at the end of a text that stops in a word, which may be cut off.
  [[nodiscard]] bool word_is_whole() const {
    return position_ < text_.size() || text_.empty() || is_blank(text_.back());
  }

  bool at_end() {
    skip_blanks();
    return position_ == text_.size();
  }

  /// The next word, empty at the end of the file.
  std::string_view word() {
    skip_blanks();
    const std::size_t begin = position_;
    while (position_ < text_.size() && !is_blank(text_[position_])) ++position_;
    return std::string_view(text_).substr(begin, position_ - begin);
  }

  /// The next word without taking it.
  std::string_view peek() {
    const std::string_view next = word();
    position_ -= next.size();
    return next;
  }

  void expect(std::string_view wanted) {
    if (word() != wanted) fail(fmt::format("\"{}\" is missing, the file is damaged or cut off", wanted));
  }

  std::int64_t integer(std::string_view what) { return number<std::int64_t>(what); }

  /// Also infinite or not a number.
  double any_real(std::string_view what) { return number<double>(what); }

  double real(std::string_view what) {
    const double value = any_real(what);
    if (!std::isfinite(value)) fail(fmt::format("{} is not finite", what));
    return value;
  }

  /// A count of things that take `numbers_each` numbers; refuses what cannot be in the rest of the file.
  std::size_t count(std::string_view what, std::size_t numbers_each) {
    const std::int64_t value = integer(what);
    const std::size_t most = (text_.size() - position_) / (2 * numbers_each) + 1;
    if (value < 0 || static_cast<std::uint64_t>(value) > most)
      fail(fmt::format("{} is {}, more than the file holds", what, value));
    return static_cast<std::size_t>(value);
  }

  /// A text in double quotes.
  std::string quoted(std::string_view what) {
    skip_blanks();
    const std::size_t end = position_ < text_.size() && text_[position_] == '"'
                                ? text_.find('"', position_ + 1)
                                : std::string::npos;
    if (end == std::string::npos) fail(fmt::format("{} is not in quotes", what));
    const std::size_t begin = position_ + 1;
    position_ = end + 1;
    return text_.substr(begin, end - begin);
  }

  /// Goes behind the next line that starts with `mark` and gives the text before it.
  std::string_view skip_behind(std::string_view mark) {
    const std::size_t begin = position_;
    const std::size_t end = text_.find("\n" + std::string(mark), begin);
    if (end == std::string::npos) fail(fmt::format("\"{}\" is missing, the file is cut off", mark));
    position_ = end + 1 + mark.size();
    return std::string_view(text_).substr(begin, end - begin);
  }

 private:
  static bool is_blank(char c) {
    return c == ' ' || c == '\n' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
  }

  void skip_blanks() {
    while (position_ < text_.size()) {
      if (is_blank(text_[position_])) {
        ++position_;
      } else if (comment_ != '\0' && text_[position_] == comment_) {
        while (position_ < text_.size() && text_[position_] != '\n') ++position_;
      } else {
        return;
      }
    }
  }

  template <class T>
  T number(std::string_view what) {
    const std::string_view token = word();
    const char* begin = token.data();
    const char* const end = begin + token.size();
    if (token.size() > 1 && *begin == '+') ++begin;
    T value{};
    const auto result = std::from_chars(begin, end, value);
    if (token.empty()) fail(fmt::format("the file ends before {}", what));
    if (result.ec == std::errc::result_out_of_range && tiny(token)) return T{};
    if (result.ec != std::errc() || result.ptr != end)
      fail(fmt::format("{} is \"{}\", not a number lumesh can hold", what, token.substr(0, 40)));
    return value;
  }

  /// A real number too small for a double, as opposed to one too large.
  static bool tiny(std::string_view token) {
    return token.find("e-") != std::string_view::npos || token.find("E-") != std::string_view::npos;
  }

  std::filesystem::path path_;
  std::string text_;
  std::size_t position_ = 0;
  char comment_;
};

}  // namespace lumesh::io
