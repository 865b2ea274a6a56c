// The structure of DICOM files, https://dicom.nema.org/medical/dicom/current/output/html/part05.html,
// section 7.
#include "dicom_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string_view>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/core/trimmed.hpp"

namespace lumesh::io {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kUnknownLength = 0xFFFFFFFF;
constexpr std::uint32_t kItem = 0xFFFEE000, kItemEnd = 0xFFFEE00D, kSequenceEnd = 0xFFFEE0DD;
constexpr std::uint32_t kTransferSyntax = 0x00020010, kMediaClass = 0x00020002, kClass = 0x00080016,
                        kSeries = 0x0020000E, kNumber = 0x00200013, kPosition = 0x00200032,
                        kOrientation = 0x00200037, kSamples = 0x00280002, kFrames = 0x00280008,
                        kRows = 0x00280010, kColumns = 0x00280011, kPixelSize = 0x00280030,
                        kBitsAllocated = 0x00280100, kBitsStored = 0x00280101, kHighBit = 0x00280102,
                        kSigned = 0x00280103, kPlanes = 0x00280006, kIntercept = 0x00281052,
                        kSlope = 0x00281053, kPixels = 0x7FE00010;
bool is_pixels(std::uint32_t tag) {
  return tag == kPixels || tag == 0x7FE00008 || tag == 0x7FE00009;
}

/// Types of values (VR): two letters.
constexpr std::uint16_t type_of(std::string_view letters) {
  return static_cast<std::uint16_t>(static_cast<unsigned char>(letters[0]) << 8U |
                                    static_cast<unsigned char>(letters[1]));
}
constexpr std::uint16_t kNoType = 0, kSequenceType = type_of("SQ"), kUnknownType = type_of("UN");

bool has_long_length(std::uint16_t type) {
  for (const char* one : {"OB", "OD", "OF", "OL", "OV", "OW", "SQ", "SV", "UC", "UN", "UR", "UT", "UV"})
    if (type == type_of(one)) return true;
  return false;
}
bool is_type(std::uint16_t type) {
  for (const char* one : {"AE", "AS", "AT", "CS", "DA", "DS", "DT", "FD", "FL", "IS", "LO",
                          "LT", "PN", "SH", "SL", "SS", "ST", "TM", "UI", "UL", "US"})
    if (type == type_of(one)) return true;
  return has_long_length(type);
}

/// An element that is kept, with its type: GDCM ends the program where it is another.
struct Kept {
  std::uint32_t tag;
  std::uint16_t type;
};
constexpr std::uint16_t kNumberType = type_of("US"), kDecimalType = type_of("DS"), kTextType = type_of("UI"),
                        kIntegerType = type_of("IS");
constexpr std::array<Kept, 19> kKept = {{{kTransferSyntax, kTextType},
                                         {kMediaClass, kTextType},
                                         {kClass, kTextType},
                                         {kSeries, kTextType},
                                         {kNumber, kIntegerType},
                                         {kPosition, kDecimalType},
                                         {kOrientation, kDecimalType},
                                         {kSamples, kNumberType},
                                         {kFrames, kIntegerType},
                                         {kRows, kNumberType},
                                         {kColumns, kNumberType},
                                         {kPixelSize, kDecimalType},
                                         {kBitsAllocated, kNumberType},
                                         {kBitsStored, kNumberType},
                                         {kHighBit, kNumberType},
                                         {kSigned, kNumberType},
                                         {kPlanes, kNumberType},
                                         {kIntercept, kDecimalType},
                                         {kSlope, kDecimalType}}};

/// How elements are written.
struct Coding {
  bool has_types = true;
  bool is_big = false;
};

struct Element {
  std::uint32_t tag = 0;
  std::uint16_t type = kNoType;
  std::uint32_t length = 0;
};

/// Walks through the elements of a file and keeps the few values that are wanted.
class Walk {
 public:
  explicit Walk(const fs::path& path)
      : path_(path), in_(path, std::ios::binary), size_(fs::file_size(path)) {}

  /// Whether it says that it is DICOM; goes to its first element. Old files do not say it, but begin with
  /// one.
  bool begin() {
    constexpr std::uint64_t kPreamble = 128;
    if (size_ < 8) return false;
    if (!in_) fail(path_, kNoPermission);
    if (size_ >= kPreamble + 4) {
      go_to(kPreamble);
      const auto mark = take<4>();
      if (std::string_view(mark.data(), 4) == "DICM") return is_marked_ = true;
    }
    go_to(0);
    const auto first = take<4>();
    const std::uint32_t group = number(first.data(), 2, false);
    go_to(0);
    return in_.good() && (group == 2 || group == 8);
  }
  [[nodiscard]] bool is_marked() const { return is_marked_; }

  void read() {
    while (at_ < size_ && next_group() == 2) value(element({}, size_), {}, size_, 0);
    coding_ = coding_of_data();
    elements(size_, coding_, Ends::kThere, 0);
  }

  [[nodiscard]] std::string text(std::uint32_t tag) const {
    const auto at = values_.find(tag);
    // A blank or a zero makes the length even.
    return at == values_.end() ? std::string() : std::string(trimmed(at->second, {" \0", 2}));
  }
  [[nodiscard]] std::uint64_t short_number(std::uint32_t tag, std::uint64_t otherwise) const {
    const auto at = values_.find(tag);
    if (at == values_.end()) return otherwise;
    if (at->second.size() != 2) damaged();
    return number(at->second.data(), 2, coding_.is_big);
  }
  /// Bytes of the image's own pixels; none if they are packed.
  [[nodiscard]] std::optional<std::uint64_t> pixel_bytes() const { return pixel_bytes_; }
  [[nodiscard]] bool has_pixels() const { return has_pixels_; }

  [[noreturn]] void damaged() const {
    fail(path_, "is a damaged DICOM file: its elements make no sense; copy it again");
  }

 private:
  enum class Ends : std::uint8_t { kThere, kAtMark };

  static std::uint32_t number(const char* bytes, int count, bool is_big) {
    std::uint32_t value = 0;
    for (int i = 0; i < count; ++i)
      value = value << 8U | static_cast<unsigned char>(bytes[is_big ? i : count - 1 - i]);
    return value;
  }

  void go_to(std::uint64_t place) {
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(place));
    at_ = place;
  }
  void skip(std::uint64_t bytes) {
    constexpr std::uint64_t kNear = 2000;  // Seeking empties the buffer.
    if (bytes > kNear)
      go_to(at_ + bytes);
    else
      in_.ignore(static_cast<std::streamsize>(bytes)), at_ += bytes;
  }
  /// The next bytes, which must be there.
  template <std::size_t N>
  std::array<char, N> take() {
    std::array<char, N> bytes = {};
    if (!in_.read(bytes.data(), N)) cut();
    at_ += N;
    return bytes;
  }
  void require(std::uint64_t bytes, std::uint64_t end) const {
    if (bytes <= end - at_) return;
    if (end == size_) cut();
    damaged();
  }
  [[noreturn]] void cut() const {
    fail(path_, "is a DICOM file that is cut or damaged: it ends within an element; copy it again");
  }

  std::uint32_t next_group() {
    require(2, size_);
    const std::uint64_t here = at_;
    const auto bytes = take<2>();
    go_to(here);
    return number(bytes.data(), 2, false);
  }

  [[nodiscard]] Coding coding_of_data() {
    const std::string syntax = text(kTransferSyntax);
    if (syntax == "1.2.840.10008.1.2.1.99")
      fail(path_, "is a DICOM file that is deflated as a whole; save it uncompressed");
    if (syntax == "1.2.840.10008.1.2") return {.has_types = false};
    if (syntax == "1.2.840.10008.1.2.2") return {.is_big = true};
    if (!syntax.empty()) return {};
    if (is_marked_) damaged();
    require(6, size_);  // An old file.
    const std::uint64_t here = at_;
    const auto bytes = take<6>();
    go_to(here);
    return {.has_types = is_type(type_of({bytes.data() + 4, 2}))};
  }

  Element element(Coding coding, std::uint64_t end) {
    require(8, end);
    const auto bytes = take<8>();
    Element e;
    e.tag = number(bytes.data(), 2, coding.is_big) << 16U | number(bytes.data() + 2, 2, coding.is_big);
    if (!coding.has_types || e.tag >> 16U == kItem >> 16U) {
      e.length = number(bytes.data() + 4, 4, coding.is_big);
      return e;
    }
    e.type = type_of({bytes.data() + 4, 2});
    if (!is_type(e.type)) damaged();
    if (has_long_length(e.type)) {
      require(4, end);
      e.length = number(take<4>().data(), 4, coding.is_big);
    } else {
      e.length = number(bytes.data() + 6, 2, coding.is_big);
    }
    return e;
  }

  void elements(std::uint64_t end, Coding coding, Ends ends, int depth) {
    constexpr int kDeepest = 32;
    if (depth > kDeepest) damaged();
    while (ends == Ends::kAtMark || at_ < end) {
      const Element e = element(coding, end);
      if (e.tag == kItemEnd && ends == Ends::kAtMark) return;
      if (e.tag >> 16U == kItem >> 16U) damaged();
      value(e, coding, end, depth);
    }
  }

  void value(const Element& e, Coding coding, std::uint64_t end, int depth) {
    if (is_pixels(e.tag) && depth == 0) has_pixels_ = true;
    if (e.length == kUnknownLength) {
      if (is_pixels(e.tag)) return fragments(coding, end);
      if (e.type == kUnknownType) return items(end, {.has_types = false}, Ends::kAtMark, depth);
      if (e.type == kSequenceType || !coding.has_types) return items(end, coding, Ends::kAtMark, depth);
      damaged();
    }
    require(e.length, end);
    if (e.tag == kPixels && depth == 0) pixel_bytes_ = e.length;
    const bool is_sequence = e.type == kSequenceType || (!coding.has_types && !is_pixels(e.tag) &&
                                                         e.length >= 8 && is_item_next(coding));
    if (is_sequence) return items(at_ + e.length, coding, Ends::kThere, depth);
    const auto* const kept = std::ranges::find_if(kKept, [&](const Kept& k) { return k.tag == e.tag; });
    if (depth > 0 || kept == kKept.end()) return skip(e.length);
    if (e.type != kNoType && e.type != kept->type) damaged();
    keep(e);
  }

  void keep(const Element& e) {
    constexpr std::uint32_t kLongest = 1000;
    if (e.length > kLongest) damaged();
    std::string& kept = values_[e.tag];
    kept.resize(e.length);
    if (!in_.read(kept.data(), e.length)) cut();
    at_ += e.length;
  }

  bool is_item_next(Coding coding) {
    const std::uint64_t here = at_;
    const auto bytes = take<4>();
    go_to(here);
    return (number(bytes.data(), 2, coding.is_big) << 16U | number(bytes.data() + 2, 2, coding.is_big)) ==
           kItem;
  }

  /// Reads the items of a sequence.
  void items(std::uint64_t end, Coding coding, Ends ends, int depth) {
    while (ends == Ends::kAtMark || at_ < end) {
      const Element item = element(coding, end);
      if (item.tag == kSequenceEnd && ends == Ends::kAtMark) return;
      if (item.tag != kItem) damaged();
      if (item.length == kUnknownLength) {
        elements(end, coding, Ends::kAtMark, depth + 1);
      } else {
        require(item.length, end);
        elements(at_ + item.length, coding, Ends::kThere, depth + 1);
      }
    }
  }

  /// Reads the fragments of packed pixels.
  void fragments(Coding coding, std::uint64_t end) {
    for (;;) {
      const Element fragment = element(coding, end);
      if (fragment.tag == kSequenceEnd) return;
      if (fragment.tag != kItem) damaged();
      require(fragment.length, end);
      skip(fragment.length);
    }
  }

  const fs::path& path_;
  std::ifstream in_;
  std::uint64_t size_, at_ = 0;
  bool is_marked_ = false, has_pixels_ = false;
  Coding coding_;
  std::map<std::uint32_t, std::string> values_;
  std::optional<std::uint64_t> pixel_bytes_;
};

std::optional<int> integer_of(const std::string& text) {
  int number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end) return std::nullopt;
  return number;
}

/// Numbers with backslashes between them.
std::vector<double> numbers_of(const std::string& text) {
  std::vector<double> numbers;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, '\\');) numbers.push_back(std::strtod(part.c_str(), nullptr));
  return numbers;
}

std::optional<DicomSlice> slice_of(const fs::path& path, const Walk& walk) {
  const std::string size = walk.text(kPixelSize);
  const std::vector<double> place = numbers_of(walk.text(kPosition)),
                            axes = numbers_of(walk.text(kOrientation)), pixel = numbers_of(size);
  const auto is_good = [](double x) { return std::isfinite(x) && x > 0; };
  if (!size.empty() && (pixel.size() != 2 || !std::ranges::all_of(pixel, is_good)))
    fail(path, fmt::format("has a pixel spacing of \"{}\"; two numbers above 0 are needed", size));
  const auto is_finite = [](double x) { return std::isfinite(x); };
  if (!std::ranges::all_of(place, is_finite) || !std::ranges::all_of(axes, is_finite))
    fail(path, "has a place or directions that are no finite numbers");
  if (place.size() != 3 || axes.size() != 6 || pixel.size() != 2) return std::nullopt;
  return DicomSlice{path.filename().string(), Vec3(place[0], place[1], place[2]),
                    Vec3(axes[0], axes[1], axes[2]), Vec3(axes[3], axes[4], axes[5]),
                    Vec3(pixel[0], pixel[1], 0)};
}

/// Whether the numbers that describe the pixels are possible ones.
void check_description(const Walk& walk) {
  const std::uint64_t bits = walk.short_number(kBitsAllocated, 0), samples = walk.short_number(kSamples, 1);
  constexpr std::array<std::uint64_t, 7> kBits = {1, 8, 12, 16, 24, 32, 64};
  const bool is_good =
      walk.short_number(kRows, 0) > 0 && walk.short_number(kColumns, 0) > 0 &&
      std::ranges::find(kBits, bits) != kBits.end() && (samples == 1 || samples == 3 || samples == 4) &&
      walk.short_number(kBitsStored, bits) <= bits && walk.short_number(kHighBit, 0) < bits &&
      walk.short_number(kSigned, 0) <= 1 && walk.short_number(kPlanes, 0) <= 1;
  if (!is_good) walk.damaged();
}

/// Whether the pixels are all there; of packed ones that is not known.
void check_pixels(const fs::path& path, const Walk& walk) {
  check_description(walk);
  const std::string text = walk.text(kFrames);
  const int frames = text.empty() ? 1 : integer_of(text).value_or(0);
  if (frames < 1) walk.damaged();
  if (!walk.pixel_bytes() || walk.short_number(kSamples, 1) != 1) return;
  const std::uint64_t rows = walk.short_number(kRows, 0), columns = walk.short_number(kColumns, 0),
                      bits = walk.short_number(kBitsAllocated, 0),
                      wanted = (rows * columns * bits * static_cast<std::uint64_t>(frames) + 7) / 8;
  if (*walk.pixel_bytes() < wanted)
    fail(path, fmt::format(
                   "is a DICOM file with {} bytes of voxels where {} x {} of {} bits need {}; copy it again",
                   *walk.pixel_bytes(), columns, rows, bits, wanted));
}

}  // namespace

std::optional<DicomFile> read_dicom_file(const fs::path& path) {
  Walk walk(path);
  if (!walk.begin()) return std::nullopt;
  try {
    walk.read();
    if (walk.has_pixels()) check_pixels(path, walk);
  } catch (const Error&) {
    if (walk.is_marked()) throw;
    return std::nullopt;
  }
  const std::string media_class = walk.text(kMediaClass);
  return DicomFile{path,
                   walk.text(kSeries),
                   media_class.empty() ? walk.text(kClass) : media_class,
                   walk.has_pixels(),
                   integer_of(walk.text(kNumber)),
                   slice_of(path, walk),
                   integer_of(walk.text(kFrames)).value_or(1) <= 1,
                   !walk.text(kPixelSize).empty()};
}

}  // namespace lumesh::io
