#pragma once
/// @file DICOM files byte by byte.

#include <string>

#include "image_bytes.hpp"

namespace lumesh::fixtures {

/// Slice number k of a series, 1 mm apart, 6 x 10 pixels of 16 bits: those of columns 2 to 3 are 1.
struct DicomBytes {
  int k = 0;
  std::string series = "1.2.3";
  std::string sop_class = "1.2.840.10008.5.1.4.1.1.2";  ///< CT.
  bool has_types = true;                                ///< Explicit VR.
  bool has_pixels = true;
  std::string pixel_size = "1\\1";  ///< Empty: left out.
  std::string further = {};         ///< Elements between the header and the pixels.

  static std::string number(std::size_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xFFU);
    return text;
  }
  static std::string tag(unsigned group, unsigned element) { return number(group, 2) + number(element, 2); }
  static std::string element(unsigned group, unsigned element, const std::string& type, std::string value,
                             bool has_types = true) {
    if (value.size() % 2 == 1) value += type == "UI" ? '\0' : ' ';
    if (!has_types) return tag(group, element) + number(value.size(), 4) + value;
    const bool is_long = type == "OB" || type == "OW" || type == "SQ" || type == "UN";
    return tag(group, element) + type + (is_long ? number(0, 2) : "") +
           number(value.size(), is_long ? 4 : 2) + value;
  }

  [[nodiscard]] std::string bytes() const {
    const std::string uid = series + "." + std::to_string(k + 1);
    const auto add = [this](unsigned group, unsigned e, const char* type, const std::string& value) {
      return element(group, e, type, value, has_types);
    };
    std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) + element(2, 2, "UI", sop_class) +
                       element(2, 3, "UI", uid) +
                       element(2, 0x10, "UI", has_types ? "1.2.840.10008.1.2.1" : "1.2.840.10008.1.2");
    meta = element(2, 0, "UL", number(meta.size(), 4)) + meta;
    std::string data = add(8, 0x16, "UI", sop_class) + add(8, 0x18, "UI", uid) + add(8, 0x60, "CS", "CT") +
                       add(0x20, 0xD, "UI", "1.2") + add(0x20, 0xE, "UI", series) +
                       add(0x20, 0x13, "IS", std::to_string(k + 1)) +
                       add(0x20, 0x32, "DS", "0\\0\\" + std::to_string(k)) +
                       add(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0") + add(0x28, 2, "US", number(1, 2)) +
                       add(0x28, 4, "CS", "MONOCHROME2") + add(0x28, 0x10, "US", number(10, 2)) +
                       add(0x28, 0x11, "US", number(6, 2)) +
                       (pixel_size.empty() ? std::string() : add(0x28, 0x30, "DS", pixel_size)) +
                       add(0x28, 0x100, "US", number(16, 2)) + add(0x28, 0x101, "US", number(16, 2)) +
                       add(0x28, 0x102, "US", number(15, 2)) + add(0x28, 0x103, "US", number(0, 2));
    data += further;
    std::string pixels;
    for (int row = 0; row < 10; ++row)
      for (int column = 0; column < 6; ++column) pixels += number(column == 2 || column == 3 ? 1 : 0, 2);
    if (has_pixels) data += add(0x7FE0, 0x10, "OW", pixels);
    return std::string(128, '\0') + "DICM" + meta + data;
  }
};

}  // namespace lumesh::fixtures
