// Medit's .sol and .solb: SolAtVertices, rows, fields, the kind of each field, then the numbers.
#include "lumesh/io/metric_file.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cstdint>

#include "file_fault.hpp"
#include "format_table.hpp"
#include "lumesh/geometry/metric_fault.hpp"
#include "medit_bytes.hpp"
#include "mesh_formats.hpp"
#include "metric_tensors.hpp"
#include "output_file.hpp"
#include "text_scanner.hpp"

namespace lumesh {

namespace {

constexpr std::string_view kSection = "SolAtVertices";
constexpr std::int32_t kSectionNumber = 62;
constexpr std::int64_t kSizeField = 1;
constexpr std::int64_t kTensorField = 3;
constexpr std::string_view kOrder = "xx xy yy xz yz zz";

enum class Encoding : std::uint8_t { kText, kBinary };

Encoding encoding_of(const std::filesystem::path& path) {
  const io::FileFormat& format = io::format_of(path, FileUse::kMetricAlone);
  return format.extension == ".sol" ? Encoding::kText : Encoding::kBinary;
}

/// The text of a .sol file, as FieldReader needs it.
class TextSource {
 public:
  explicit TextSource(const std::filesystem::path& path) : scanner_(path, '#') {
    scanner_.expect("MeshVersionFormatted");
    scanner_.integer("the format's version");
  }

  /// Goes to the field's section; false if there is none (any more).
  bool find_section() {
    for (std::string_view word = scanner_.word(); !word.empty() && word != "End"; word = scanner_.word()) {
      if (word == kSection) return true;
      if (word == "Dimension") check_dimension();
    }
    return false;
  }
  std::int64_t count() { return scanner_.integer("the number of vertices"); }
  std::int64_t kind() { return scanner_.integer("the kind of a field"); }
  double real() { return scanner_.any_real("a number of the metric"); }
  /// The word End may be missing, as in the files of refine; a number must not be cut off then.
  void leave_section() {
    if (!scanner_.word_is_whole())
      scanner_.fail("the file stops behind its last number and may be cut off: no new line, no \"End\"");
    const std::string_view next = scanner_.peek();
    if (!next.empty() && std::isalpha(static_cast<unsigned char>(next[0])) == 0)
      scanner_.fail(fmt::format("{} holds more numbers than it says", kSection));
  }
  [[noreturn]] void unsuitable(std::string_view what) const { scanner_.unsuitable(what); }

 private:
  void check_dimension() {
    if (const std::int64_t dimension = scanner_.integer("the dimension"); dimension != 3)
      scanner_.unsuitable(fmt::format(
          "has dimension {}; only metrics of dimension 3 can be read, of a volume mesh", dimension));
  }

  io::TextScanner scanner_;
};

/// The bytes of a .solb file, as FieldReader needs them.
class ByteSource {
 public:
  explicit ByteSource(const std::filesystem::path& path) : bytes_(path) {}

  bool find_section() {
    for (auto keyword = bytes_.enter_section(); keyword != io::kMeditEnd; keyword = bytes_.enter_section()) {
      if (keyword == kSectionNumber) return true;
      bytes_.leave_section();
    }
    return false;
  }
  /// A row has at least one number.
  std::int64_t count() { return static_cast<std::int64_t>(bytes_.count(bytes_.real_bytes())); }
  std::int64_t kind() { return bytes_.small_integer(); }
  double real() { return bytes_.real(); }
  void leave_section() { bytes_.leave_section(); }
  [[noreturn]] void unsuitable(std::string_view what) const { bytes_.unsuitable(what); }

 private:
  io::MeditByteReader bytes_;
};

/// Tells a metric from what else a solution file may hold.
template <class Source>
class FieldReader {
 public:
  FieldReader(const std::filesystem::path& path, std::size_t expected_count)
      : source_(path), expected_count_(expected_count) {}

  std::vector<SymTensor> read() {
    const bool tensors = enter(Wanted::kMetric) == kTensorField;
    // Not reserved: the text may hold less than it says, and the mesh be large.
    std::vector<SymTensor> metric;
    for (std::size_t vertex = 1; vertex <= expected_count_; ++vertex)
      metric.push_back(tensors ? read_tensor(vertex) : read_size(vertex));
    leave();
    return metric;
  }

  std::vector<double> read_numbers() {
    enter(Wanted::kNumbers);
    std::vector<double> numbers;  // Not reserved, as above.
    for (std::size_t vertex = 1; vertex <= expected_count_; ++vertex) numbers.push_back(source_.real());
    leave();
    return numbers;
  }

 private:
  enum class Wanted : std::uint8_t { kMetric, kNumbers };

  /// Goes to the field's first number. @return its kind.
  std::int64_t enter(Wanted wanted) {
    if (!source_.find_section())
      source_.unsuitable(fmt::format("has no section {}; give a file of a solution", kSection));
    const std::int64_t count = source_.count(), kind = read_kind();
    if (wanted == Wanted::kNumbers && kind != kSizeField)
      source_.unsuitable("has a field of tensors; give one with a number per vertex");
    const std::string_view things = wanted == Wanted::kNumbers ? "values"
                                    : kind == kTensorField     ? "tensors"
                                                               : "sizes";
    if (count < 0 || static_cast<std::uint64_t>(count) != expected_count_)
      source_.unsuitable(fmt::format("has {} {}, the mesh has {} vertices; give the one of this mesh", count,
                                     things, expected_count_));
    return kind;
  }

  void leave() {
    source_.leave_section();
    if (source_.find_section())
      source_.unsuitable(fmt::format("has several sections {}; keep one", kSection));
  }

  std::int64_t read_kind() {
    const std::int64_t fields = source_.kind();
    if (fields != 1)
      source_.unsuitable(fmt::format("has {} fields where a metric is one; keep that field alone", fields));
    const std::int64_t kind = source_.kind();
    if (kind != kSizeField && kind != kTensorField)
      source_.unsuitable(
          fmt::format("has a field of kind {}; a metric is of kind {} (size) or {} (symmetric tensor)", kind,
                      kSizeField, kTensorField));
    return kind;
  }

  SymTensor read_tensor(std::size_t vertex) {
    io::TensorNumbers numbers{};
    for (double& number : numbers) number = source_.real();
    const SymTensor tensor = io::from_medit_order(numbers);
    if (const std::string_view fault = metric_fault(tensor); !fault.empty())
      source_.unsuitable(fmt::format("the tensor of vertex {} {}; the order is {}", vertex, fault, kOrder));
    return tensor;
  }

  SymTensor read_size(std::size_t vertex) {
    const double size_mm = source_.real();
    const double inverse_square = 1 / size_mm / size_mm;
    const SymTensor tensor = SymTensor::diagonal(inverse_square, inverse_square, inverse_square);
    if (!(size_mm > 0) || !metric_fault(tensor).empty())
      source_.unsuitable(
          fmt::format("the size of vertex {} is {}, not a usable length above 0", vertex, size_mm));
    return tensor;
  }

  Source source_;
  std::size_t expected_count_;
};

template <class Read>
auto read_field(const std::filesystem::path& path, std::size_t expected_count, const Read& read) {
  const Encoding encoding = encoding_of(path);
  io::check_file(path);
  return encoding == Encoding::kText ? read(FieldReader<TextSource>(path, expected_count))
                                     : read(FieldReader<ByteSource>(path, expected_count));
}

void write_text(const std::filesystem::path& path, std::span<const SymTensor> metric) {
  io::OutputFile file(path);
  file.print("MeshVersionFormatted 2\nDimension 3\n{}\n{}\n1 {}\n", kSection, metric.size(), kTensorField);
  for (const SymTensor& tensor : metric) file.print("{}\n", fmt::join(io::to_medit_order(tensor), " "));
  file.print("End\n");
  file.commit();
}

void write_binary(const std::filesystem::path& path, std::span<const SymTensor> metric) {
  constexpr std::size_t kHeaderBytes = 3 * sizeof(std::int32_t);
  if (metric.size() > io::kMaxMeditRows) io::fail(path, "too many vertices for .solb; choose .sol");
  const std::size_t bytes = kHeaderBytes + metric.size() * sizeof(io::TensorNumbers);
  io::MeditByteWriter out(path, 1024 + bytes);
  out.begin_section(kSectionNumber, bytes);
  out.put(static_cast<std::int32_t>(metric.size()));
  out.put(1);
  out.put(static_cast<std::int32_t>(kTensorField));
  for (const SymTensor& tensor : metric) {
    const io::TensorNumbers numbers = io::to_medit_order(tensor);
    out.write(numbers.data(), sizeof(numbers));
  }
  out.commit();
}

}  // namespace

std::vector<SymTensor> read_metric(const std::filesystem::path& path, std::size_t expected_count) {
  return read_field(path, expected_count, [](auto&& reader) { return reader.read(); });
}

std::vector<double> read_solution(const std::filesystem::path& path, std::size_t expected_count) {
  return read_field(path, expected_count, [](auto&& reader) { return reader.read_numbers(); });
}

void write_metric(const std::filesystem::path& path, std::span<const SymTensor> metric) {
  const Encoding encoding = encoding_of(path);
  for (std::size_t i = 0; i < metric.size(); ++i) {
    if (const std::string_view fault = metric_fault(metric[i]); !fault.empty())
      io::fail(path, fmt::format("is not written: the tensor of vertex {} {}", i + 1, fault));
  }
  if (encoding == Encoding::kText) return write_text(path, metric);
  write_binary(path, metric);
}

}  // namespace lumesh
