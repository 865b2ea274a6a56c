#include "lumesh/core/base64.hpp"

#include <array>
#include <cstddef>

namespace lumesh {

namespace {

constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// The value of each letter; -1 if it is no digit.
constexpr std::array<signed char, 256> kValues = [] {
  std::array<signed char, 256> values{};
  values.fill(-1);
  for (std::size_t i = 0; i < kDigits.size(); ++i)
    values[static_cast<unsigned char>(kDigits[i])] = static_cast<signed char>(i);
  return values;
}();

void encode_group(const char* three, char* four) {
  unsigned bits = 0;
  for (int i = 0; i < 3; ++i) bits = bits << 8U | static_cast<unsigned char>(three[i]);
  for (int i = 3; i >= 0; --i, bits >>= 6U) four[i] = kDigits[bits & 63U];
}

}  // namespace

std::string encode_base64(std::string_view bytes) {
  std::string out((bytes.size() + 2) / 3 * 4, '=');
  const std::size_t whole = bytes.size() / 3;
  for (std::size_t i = 0; i < whole; ++i) encode_group(bytes.data() + 3 * i, out.data() + 4 * i);
  const std::string_view rest = bytes.substr(3 * whole);
  if (rest.empty()) return out;
  std::array<char, 3> last = {};
  rest.copy(last.data(), rest.size());
  std::array<char, 4> four = {};
  encode_group(last.data(), four.data());
  out.replace(4 * whole, rest.size() + 1, four.data(), rest.size() + 1);
  return out;
}

std::string decode_base64(std::string_view text) {
  std::string out;
  out.reserve(text.size() / 4 * 3);
  unsigned bits = 0;
  int held = 0;
  for (const char c : text) {
    if (c == '=') {
      bits = 0;
      held = 0;
      continue;
    }
    const signed char digit = kValues[static_cast<unsigned char>(c)];
    if (digit < 0) continue;
    bits = bits << 6U | static_cast<unsigned>(digit);
    held += 6;
    if (held >= 8) {
      held -= 8;
      out.push_back(static_cast<char>(bits >> static_cast<unsigned>(held) & 0xffU));
    }
  }
  return out;
}

}  // namespace lumesh
