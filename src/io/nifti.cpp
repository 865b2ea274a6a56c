#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "file_fault.hpp"
#include "lumesh/parallel/loops.hpp"
#include "raw_image.hpp"
#include "unpacked_file.hpp"

// Layout of the headers: https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h and nifti2.h.
namespace lumesh::io {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHeader1Bytes = 348;
constexpr std::size_t kHeader2Bytes = 540;

/// Fields of a header in either version and byte order.
class NiftiHeader {
 public:
  explicit NiftiHeader(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {
    if (bytes_.size() < kHeader1Bytes) return;
    std::int32_t size = 0;
    std::memcpy(&size, bytes_.data(), sizeof(size));
    swapped_ = size != 348 && size != 540;
    if (swapped_) size = static_cast<std::int32_t>(__builtin_bswap32(static_cast<std::uint32_t>(size)));
    version_ = size == 348 ? 1 : size == 540 && bytes_.size() >= kHeader2Bytes ? 2 : 0;
  }

  [[nodiscard]] int version() const { return version_; }
  [[nodiscard]] bool swapped() const { return swapped_; }
  [[nodiscard]] std::string_view magic() const {
    const std::size_t at = version_ == 1 ? 344 : 4;
    return {reinterpret_cast<const char*>(bytes_.data()) + at, 3};
  }
  [[nodiscard]] std::int64_t dimension(std::size_t i) const {
    return version_ == 1 ? get<std::int16_t>(40 + 2 * i) : get<std::int64_t>(16 + 8 * i);
  }
  [[nodiscard]] double pixel_size(std::size_t i) const {
    return version_ == 1 ? static_cast<double>(get<float>(76 + 4 * i)) : get<double>(104 + 8 * i);
  }
  [[nodiscard]] int data_type() const { return get<std::int16_t>(version_ == 1 ? 70 : 12); }
  /// Where the voxels of a single file begin: behind the header and its four flags of extensions, where the
  /// writer left it 0.
  [[nodiscard]] double data_offset() const {
    const bool is_first = version_ == 1;
    const double offset =
        is_first ? static_cast<double>(get<float>(108)) : static_cast<double>(get<std::int64_t>(168));
    return std::max(offset, is_first ? 352.0 : 544.0);
  }
  [[nodiscard]] double slope() const { return real(112, 176); }
  [[nodiscard]] double intercept() const { return real(116, 184); }
  [[nodiscard]] int units() const {
    return version_ == 1 ? std::to_integer<int>(bytes_[123]) : get<std::int32_t>(500);
  }
  [[nodiscard]] int qform_code() const {
    return version_ == 1 ? get<std::int16_t>(252) : get<std::int32_t>(344);
  }
  [[nodiscard]] int sform_code() const {
    return version_ == 1 ? get<std::int16_t>(254) : get<std::int32_t>(348);
  }
  /// b, c, d of the quaternion, then the offset x, y, z.
  [[nodiscard]] double qform(std::size_t i) const { return real(256 + 4 * i, 352 + 8 * i); }
  [[nodiscard]] double sform(std::size_t row, std::size_t column) const {
    return real(280 + 4 * (4 * row + column), 400 + 8 * (4 * row + column));
  }

 private:
  template <class Value>
  [[nodiscard]] Value get(std::size_t at) const {
    std::array<std::byte, sizeof(Value)> raw;
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at), sizeof(Value), raw.begin());
    if (swapped_) std::ranges::reverse(raw);
    return std::bit_cast<Value>(raw);
  }
  [[nodiscard]] double real(std::size_t at1, std::size_t at2) const {
    return version_ == 1 ? static_cast<double>(get<float>(at1)) : get<double>(at2);
  }

  std::vector<std::byte> bytes_;
  int version_ = 0;  ///< 0 = not NIfTI.
  bool swapped_ = false;
};

NiftiHeader read_nifti_header(GzipInput& input) {
  std::vector<std::byte> bytes(kHeader2Bytes);
  bytes.resize(input.read(bytes.data(), bytes.size()));
  return NiftiHeader(std::move(bytes));
}

VoxelType voxel_type(const fs::path& path, int code) {
  for (const VoxelTypeNames& known : kVoxelTypes)
    if (known.nifti == code) return known.type;
  fail(path,
       fmt::format("has voxels of NIfTI type {}, which are not single numbers; save it with integer voxels",
                   code));
}

std::array<std::int64_t, 3> volume_size(const fs::path& path, const NiftiHeader& header) {
  const std::int64_t dimensions = header.dimension(0);
  if (dimensions < 1 || dimensions > 7)
    fail(path, "has a damaged header (number of dimensions); save it again");
  if (dimensions < 3) fail(path, fmt::format(kFlatImage, dimensions));
  return {header.dimension(1), header.dimension(2), header.dimension(3)};
}

std::size_t volume_count(const fs::path& path, const NiftiHeader& header) {
  std::vector<std::int64_t> sizes;
  for (std::int64_t i = 4; i <= header.dimension(0); ++i)
    sizes.push_back(header.dimension(static_cast<std::size_t>(i)));
  return product_of_sizes(path, sizes);
}

/// Axes of the quaternion (nifti1.h, "METHOD 2"), in RAS. Rotations by 180 degrees have a = 0; of numbers in
/// single precision it comes out up to 3e-4, which its reference implementation takes for 0, too
/// (nifti_quatern_to_mat44()).
Mat3 quaternion_axes(const NiftiHeader& header) {
  constexpr double kMinSquare = 1e-7;
  Vec3 bcd(header.qform(0), header.qform(1), header.qform(2));
  const double square = 1 - bcd.squaredNorm();
  const double a = square < kMinSquare ? 0 : std::sqrt(square);
  if (a == 0) bcd.normalize();
  const double b = bcd[0], c = bcd[1], d = bcd[2];
  Mat3 axes;
  axes << a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c),  //
      2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b),      //
      2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c;
  if (header.pixel_size(0) < 0) axes.col(2) = -axes.col(2);
  return axes;
}

/// Unit that a header states; empty if it states none.
std::string unit_of(const NiftiHeader& header) {
  switch (header.units() & 7) {
    case 1:
      return "m";
    case 2:
      return "mm";
    case 3:
      return "um";
    default:
      return "";
  }
}

void place_by_sform(const NiftiHeader& header, ImageHeader& image) {
  for (int row = 0; row < 3; ++row) {
    const auto r = static_cast<std::size_t>(row);
    for (int column = 0; column < 3; ++column)
      image.direction(row, column) = header.sform(r, static_cast<std::size_t>(column));
    image.origin_mm[row] = header.sform(r, 3);
  }
  const Vec3 lengths = image.direction.colwise().norm();
  image.spacing_mm = lengths;
  for (int i = 0; i < 3; ++i) image.direction.col(i) /= lengths[i];
}

void place_by_qform(const NiftiHeader& header, ImageHeader& image) {
  image.direction = quaternion_axes(header);
  image.origin_mm = Vec3(header.qform(3), header.qform(4), header.qform(5));
}

/// How far a corner of the image is from where another placement has it, in voxels.
double furthest_corner(const ImageHeader& a, const ImageHeader& b) {
  double furthest_mm = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vec3 index;
    for (unsigned i = 0; i < 3; ++i)
      index[i] = (corner >> i & 1U) != 0 ? static_cast<double>(a.size.at(i) - 1) : 0.0;
    const auto at = [&](const ImageHeader& h) {
      return h.origin_mm + h.direction * index.cwiseProduct(h.spacing_mm);
    };
    furthest_mm = std::max(furthest_mm, (at(a) - at(b)).norm());
  }
  return furthest_mm / a.spacing_mm.minCoeff();
}

std::string text_of(const Vec3& v) {
  return fmt::format("{:.4g} x {:.4g} x {:.4g}", v.x(), v.y(), v.z());
}

/// Programs differ in what they take.
/// @param by_qform  With the sizes of pixdim, and the qform's place if there is one.
void warn_of_conflict(const fs::path& path, const ImageHeader& by_sform, const ImageHeader& by_qform,
                      bool has_qform, Context& context) {
  constexpr double kSameSize = 0.01, kSamePlace = 0.5;  // Relative; voxels.
  const Vec3 ratio = by_sform.spacing_mm.cwiseQuotient(by_qform.spacing_mm);
  if (!((ratio - Vec3::Ones()).cwiseAbs().maxCoeff() <= kSameSize))
    return context.warn(
        fmt::format("{}: has voxels of {} by its sform and {} by its pixdim; the sform's are taken",
                    path.string(), text_of(by_sform.spacing_mm), text_of(by_qform.spacing_mm)));
  const double apart = has_qform ? furthest_corner(by_sform, by_qform) : 0;
  if (!(apart <= kSamePlace))
    context.warn(
        fmt::format("{}: its sform and qform place it differently, by {:.3g} voxels at a corner; the "
                    "sform is taken",
                    path.string(), apart));
}

/// Position and axes, from the sform if there is one, else from the qform, else axes along R, A, S.
ImageHeader place(const fs::path& path, const NiftiHeader& header, const FileChoice& choice,
                  Context& context) {
  ImageHeader image;
  image.size = volume_size(path, header);
  image.volumes = volume_count(path, header);
  image.unit_is_given = choice.unit_mm.has_value();
  image.type = voxel_type(path, header.data_type());
  for (int i = 0; i < 3; ++i) image.spacing_mm[i] = header.pixel_size(static_cast<std::size_t>(i) + 1);
  const bool spacing_good = image.spacing_mm.allFinite() && (image.spacing_mm.array() > 0).all();
  ImageHeader by_qform = image;
  place_by_qform(header, by_qform);
  if (header.sform_code() > 0) {
    const Vec3 pixel_sizes = image.spacing_mm;
    place_by_sform(header, image);
    if (!spacing_good) image.spacing_mm = pixel_sizes;  // These are refused below.
    if (spacing_good) warn_of_conflict(path, image, by_qform, header.qform_code() > 0, context);
  } else if (header.qform_code() > 0) {
    image = by_qform;
  }
  image.direction.topRows<2>() *= -1;  // RAS to LPS.
  image.origin_mm.head<2>() *= -1;
  image.stated_unit = unit_of(header);
  const double scale = choice.unit_or_stated_mm(image.stated_unit);
  image.spacing_mm *= scale;
  image.origin_mm *= scale;
  return image;
}

/// Values of a file that stores them scaled; rare for labels.
void apply_scale(RawImage& image, double slope, double intercept) {
  auto scaled = std::make_unique_for_overwrite<std::byte[]>(image.value_count() * sizeof(double));
  auto* const to = reinterpret_cast<double*>(scaled.get());
  visit_voxels(image, [&](auto voxels) {
    parallel::for_each_index(
        voxels.size(), [&](std::size_t i) { to[i] = static_cast<double>(voxels[i]) * slope + intercept; });
  });
  image.voxels = std::move(scaled);
  image.type = VoxelType::kDouble;
}

void skip(GzipInput& input, const fs::path& path, std::size_t bytes) {
  constexpr std::size_t kChunk = std::size_t{1} << 20;
  std::vector<std::byte> chunk(std::min(kChunk, bytes));
  for (std::size_t left = bytes; left > 0;) {
    const std::size_t next = std::min(left, chunk.size());
    if (input.read(chunk.data(), next) != next) fail(path, "is truncated; copy it again");
    left -= next;
  }
}

/// Skips to the voxels: headers may have extensions.
void skip_to(GzipInput& input, const fs::path& path, std::size_t from, double offset) {
  constexpr double kLargestOffset = 1e9;
  if (!(offset >= static_cast<double>(from)) || offset > kLargestOffset)
    fail(path, "has a damaged header (data offset); save it again");
  skip(input, path, static_cast<std::size_t>(offset) - from);
}

}  // namespace

bool is_nifti(const fs::path& path) {
  GzipInput input(path);
  const NiftiHeader header = read_nifti_header(input);
  return header.version() != 0 && (header.magic() == std::string_view("n+1") || header.magic() == "n+2" ||
                                   header.magic() == "ni1" || header.magic() == "ni2");
}

std::size_t volumes_of_nifti(const fs::path& path) {
  GzipInput input(path);
  const NiftiHeader header = read_nifti_header(input);
  static_cast<void>(volume_size(path, header));
  return volume_count(path, header);
}

RawImage read_nifti(const fs::path& path, const FileChoice& choice, Context& context) {
  NiftiHeader header = [&] {
    GzipInput input(path);
    return read_nifti_header(input);
  }();
  if (header.magic().substr(0, 2) == "ni")
    fail(path, "keeps its voxels in a second file; save it as one .nii file");
  const ImageHeader placed = place(path, header, choice, context);
  RawImage image;
  image.frame = checked_frame(path, placed, context);
  image.type = placed.type;
  const VolumeRange volumes = chosen_volumes(path, placed, choice);
  image.volumes = volumes.count;
  image.voxels = allocate_voxels(path, image.frame, image.type, fs::file_size(path), image.volumes);
  GzipInput input(path);
  skip_to(input, path, 0, header.data_offset());
  const std::size_t width = voxel_bytes(image.type), bytes = image.value_count() * width;
  skip(input, path, volumes.first * image.frame.voxel_count() * width);
  if (input.read(image.voxels.get(), bytes) != bytes) fail(path, kDamagedVoxels);
  require_sound_rest(input, path);
  if (header.swapped()) swap_bytes(image);
  const double slope = header.slope();
  const bool scaled = std::isfinite(slope) && slope != 0 && (slope != 1 || header.intercept() != 0);
  if (scaled) apply_scale(image, slope, header.intercept());
  return image;
}

}  // namespace lumesh::io
