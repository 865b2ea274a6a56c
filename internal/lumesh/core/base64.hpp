#pragma once
/// @file Base64 (RFC 4648, section 4), in which VTK's XML files hold numbers and web pages pictures.

#include <string>
#include <string_view>

namespace lumesh {

/// Four letters for each three bytes; the last ones are padded by `=`.
[[nodiscard]] std::string encode_base64(std::string_view bytes);

/// Skips what is no digit, such as white space. Padding may stand in the middle, where two encoded parts
/// meet.
[[nodiscard]] std::string decode_base64(std::string_view text);

}  // namespace lumesh
