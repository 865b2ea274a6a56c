// The only file that includes ITK.
#include <fmt/format.h>
#include <itkGDCMImageIO.h>
#include <itkGiplImageIO.h>
#include <itkImage.h>
#include <itkImageSeriesReader.h>
#include <itkMetaDataObject.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <iostream>
#include <map>
#include <optional>

#include "dicom_series.hpp"
#include "dicom_slices.hpp"
#include "file_fault.hpp"
#include "lumesh/core/option.hpp"
#include "lumesh/io/file_formats.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/io/unit_doubt.hpp"
#include "lumesh/mesh/length_unit.hpp"
#include "raw_image.hpp"
#include "segment_layers.hpp"
#include "unpacked_file.hpp"
#include "utf8.hpp"

namespace lumesh::io {

namespace {

namespace fs = std::filesystem;

/// Teem and GDCM print what they find wrong, and then it comes as an exception, or as voxels that are
/// missing.
class QuietStreams {
 public:
  QuietStreams() : cout_(std::cout.rdbuf(nullptr)), cerr_(std::cerr.rdbuf(nullptr)) {}
  ~QuietStreams() {
    std::cout.rdbuf(cout_);
    std::cerr.rdbuf(cerr_);
  }
  QuietStreams(const QuietStreams&) = delete;
  QuietStreams& operator=(const QuietStreams&) = delete;

 private:
  std::streambuf* cout_;
  std::streambuf* cerr_;
};

/// Teem's traces have a line "[nrrd] FUNCTION: MESSAGE" per function, the innermost one last, whose message
/// says what is wrong; what stands in brackets behind it is for programmers.
std::string without_trace(const std::string& text) {
  constexpr std::string_view kLine = "[nrrd] ";
  const std::size_t last = text.rfind(kLine);
  if (last == std::string::npos) return text;
  const std::size_t name_end = text.find(": ", last);
  const std::size_t begin = name_end == std::string::npos ? last + kLine.size() : name_end + 2;
  const std::string message = text.substr(begin, text.find(" (", begin) - begin);
  return message.starts_with("fread got only") ? "its voxels end too early" : message;
}

/// ITK's descriptions run over several lines and begin with the address of an object.
std::string one_line(const itk::ExceptionObject& fault) {
  std::string text = without_trace(fault.GetDescription());
  constexpr std::string_view kPrefix = "ITK ERROR: ";
  if (const auto at = text.find(kPrefix); at != std::string::npos) text.erase(0, at + kPrefix.size());
  if (const auto at = text.find("): "); at != std::string::npos && at < 60) text.erase(0, at + 3);
  std::string line;
  for (const char c : text) {
    const bool blank = static_cast<unsigned char>(c) <= ' ';
    if (!blank)
      line += c;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  }
  constexpr std::size_t kMaximumLength = 200;
  if (line.size() > kMaximumLength) line.resize(kMaximumLength);
  if (line.ends_with(' ')) line.pop_back();
  return line;
}

VoxelType voxel_type(const fs::path& path, const itk::ImageIOBase& io) {
  using Component = itk::IOComponentEnum;
  switch (io.GetComponentType()) {
    case Component::UCHAR:
      return VoxelType::kUInt8;
    case Component::CHAR:
      return VoxelType::kInt8;
    case Component::USHORT:
      return VoxelType::kUInt16;
    case Component::SHORT:
      return VoxelType::kInt16;
    case Component::UINT:
      return VoxelType::kUInt32;
    case Component::INT:
      return VoxelType::kInt32;
    case Component::ULONG:
    case Component::ULONGLONG:
      return VoxelType::kUInt64;
    case Component::LONG:
    case Component::LONGLONG:
      return VoxelType::kInt64;
    case Component::FLOAT:
      return VoxelType::kFloat;
    case Component::DOUBLE:
      return VoxelType::kDouble;
    default:
      fail(path, "voxels of this type are not supported; save it with integer voxels");
  }
}

/// Frames times values of a voxel.
std::size_t volume_count(const fs::path& path, const itk::ImageIOBase& io) {
  std::vector<std::int64_t> frames;
  for (unsigned i = 3; i < io.GetNumberOfDimensions(); ++i)
    frames.push_back(static_cast<std::int64_t>(io.GetDimensions(i)));
  if (io.GetNumberOfComponents() > 1 && product_of_sizes(path, frames) > 1)
    fail(path, fmt::format(kVolumesOfVectors, io.GetNumberOfComponents()));
  frames.push_back(io.GetNumberOfComponents());
  return product_of_sizes(path, frames);
}

ImageHeader read_header(const fs::path& path, itk::ImageIOBase& io) {
  const QuietStreams quiet;
  io.SetFileName(path.string());
  io.ReadImageInformation();
  const unsigned dimensions = io.GetNumberOfDimensions();
  if (dimensions < 3) fail(path, fmt::format(kFlatImage, dimensions));
  ImageHeader header;
  header.volumes = volume_count(path, io);
  header.type = voxel_type(path, io);
  for (unsigned i = 0; i < 3; ++i) {
    header.size.at(i) = static_cast<std::int64_t>(io.GetDimensions(i));
    header.spacing_mm[i] = io.GetSpacing(i);
    header.origin_mm[i] = io.GetOrigin(i);
    const std::vector<double> axis = io.GetDirection(i);
    for (unsigned row = 0; row < 3; ++row) header.direction(row, i) = axis.at(row);
  }
  return header;
}

/// A whole number that is all of a text.
std::optional<Label> number_in(const std::string& text) {
  Label number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// 3D Slicer's segments (.seg.nrrd): Segment0_Name:=…, Segment0_LabelValue:=…, Segment0_Layer:=….
std::vector<Segment> segments_of(const itk::ImageIOBase& io) {
  constexpr std::string_view kName = "_Name";
  const itk::MetaDataDictionary& fields = io.GetMetaDataDictionary();
  std::vector<Segment> segments;
  for (const std::string& key : fields.GetKeys()) {
    if (!key.starts_with("Segment") || !key.ends_with(kName)) continue;
    std::string name, value, layer;
    const std::string segment = key.substr(0, key.size() - kName.size());
    if (!itk::ExposeMetaData(fields, key, name) ||
        !itk::ExposeMetaData(fields, segment + "_LabelValue", value))
      continue;
    itk::ExposeMetaData(fields, segment + "_Layer", layer);
    const Label label = number_in(value).value_or(kBackground);
    if (label > 0)
      segments.push_back(
          {as_utf8(name), label, static_cast<std::size_t>(std::max(0, number_in(layer).value_or(0)))});
  }
  return segments;
}

/// Null if it is of no such format. Looks at the checksum of what is gzipped as a whole, which ITK does not.
itk::ImageIOBase::Pointer make_reader(const fs::path& path) {
  if (path.extension() == ".gz") {
    GzipInput input(path);
    require_sound_rest(input, path);
  }
  const QuietStreams quiet;
  const std::string name = path.string();
  const itk::ImageIOBase::Pointer candidates[] = {itk::NrrdImageIO::New().GetPointer(),
                                                  itk::GiplImageIO::New().GetPointer()};
  for (const auto& candidate : candidates)
    if (candidate->CanReadFile(name.c_str())) return candidate;
  return nullptr;
}

/// Some readers leave the rest of the buffer as it is when the file ends early, and return as if all were
/// well: the last byte tells, whatever it should be, when two reads from different bytes leave both.
void read_to_the_end(const fs::path& path, itk::ImageIOBase& io, std::byte* voxels, std::size_t bytes) {
  const QuietStreams quiet;
  for (const std::byte mark : {std::byte{0x5a}, std::byte{0xa5}}) {
    voxels[bytes - 1] = mark;
    io.Read(voxels);
    if (voxels[bytes - 1] != mark) return;
  }
  fail(path, kTruncated);
}

/// Coordinates in LPS. ITK before the mend of its issue 5207 (2025) turns the wrong axis of the space
/// left-anterior-superior, and none of spaces with time.
void turn_to_lps(const NrrdNotes& notes, ImageHeader& header) {
  for (Eigen::Index row = 0; row < 3; ++row) {
    double along = 0;  // Positive where ITK left the coordinate as it is.
    for (std::size_t i = 0; i < std::min<std::size_t>(3, notes.axes.size()); ++i)
      along += header.direction(row, static_cast<Eigen::Index>(i)) * notes.axes[i][row];
    if (!(along * notes.to_lps[row] < 0)) continue;
    header.direction.row(row) *= -1;
    header.origin_mm[row] *= -1;
  }
}

/// Warns of words in a header that say nothing about places.
void warn_of_unknown_words(const fs::path& path, const NrrdNotes& notes, const FileChoice& choice,
                           const Context& context) {
  if (!choice.unit_mm && !notes.unit.empty() && unit_in_mm(notes.unit) == 0)
    context.warn(path.string() + ": " + unknown_unit_text(notes.unit, option_name("unit")));
  if (!notes.space_without_sides.empty())
    context.warn(
        fmt::format("{}: its space, {}, does not say which side is left: its coordinates are taken as LPS",
                    path.string(), notes.space_without_sides));
}

RawImage read_single(const fs::path& path, itk::ImageIOBase& io, const FileChoice& choice, Context& context) {
  const bool is_nrrd = dynamic_cast<const itk::NrrdImageIO*>(&io) != nullptr;
  const NrrdNotes notes = is_nrrd ? nrrd_notes(path) : NrrdNotes{kAllAxes};  // Before ITK reads it.
  ImageHeader header = read_header(path, io);
  header.has_spacing = notes.has_spacing;
  warn_of_unknown_words(path, notes, choice, context);
  turn_to_lps(notes, header);
  const double unit_mm = choice.unit_or_stated_mm(notes.unit);
  header.spacing_mm *= unit_mm;
  header.origin_mm *= unit_mm;
  header.unit_is_given = choice.unit_mm.has_value();
  if (unit_in_mm(notes.unit) > 0) header.stated_unit = notes.unit;
  RawImage image;
  image.frame = checked_frame(path, header, context);
  image.type = header.type;
  const std::vector<Segment> segments = segments_of(io);
  image.label_names = names_of(segments, choice.frame);
  const bool joins_layers = header.volumes > 1 && !choice.frame && have_layers(segments);
  const VolumeRange volumes =
      joins_layers ? VolumeRange{0, header.volumes} : chosen_volumes(path, header, choice);
  image.volumes = header.volumes;
  // Detached data files are not looked at here.
  const std::string extension = path.extension().string();
  const bool detached = extension == ".nhdr";
  image.voxels =
      allocate_voxels(path, image.frame, image.type, detached ? 0 : fs::file_size(path), image.volumes);
  const std::size_t bytes = image.value_count() * voxel_bytes(image.type);
  const bool is_sorted = io.GetNumberOfComponents() == 1;  // Else axes may have to change places.
  if (extension == ".nrrd" && is_sorted &&
      unpack_nrrd(path, voxel_bytes(image.type), {image.voxels.get(), bytes})) {
    keep_volumes(volumes, image);
    if (joins_layers) join_layers(path, segments, context, image);
    return image;
  }
  if (is_nrrd) require_sound_nrrd(path);
  itk::ImageIORegion region(io.GetNumberOfDimensions());
  for (unsigned i = 0; i < io.GetNumberOfDimensions(); ++i) region.SetSize(i, io.GetDimensions(i));
  io.SetIORegion(region);
  read_to_the_end(path, io, image.voxels.get(), bytes);
  if (is_sorted)
    keep_volumes(volumes, image);
  else
    sort_into_volumes(volumes, image);
  if (joins_layers) join_layers(path, segments, context, image);
  return image;
}

struct SeriesFiles {
  std::vector<std::string> files;
  bool have_pixel_sizes = true, have_places = true;
};

/// The files of a series whose slices make a grid.
SeriesFiles series_files(const fs::path& path) {
  SeriesFiles series;
  std::vector<DicomSlice> slices;
  for (const DicomFile& file : dicom_series(path)) {
    series.files.push_back(file.path.string());
    if (file.slice) slices.push_back(*file.slice);
    series.have_pixel_sizes = series.have_pixel_sizes && (file.has_pixel_size || !file.is_single);
    series.have_places = series.have_places && (file.slice || !file.is_single);
  }
  check_slices(path, std::move(slices));
  return series;
}

/// Voxels as float, which holds every 16-bit value with its rescale slope.
RawImage read_dicom_series(const fs::path& path, const FileChoice& choice, Context& context) {
  using Image = itk::Image<float, 3>;
  const SeriesFiles series = series_files(path);
  const auto reader = itk::ImageSeriesReader<Image>::New();
  reader->SetImageIO(itk::GDCMImageIO::New());
  reader->SetFileNames(series.files);
  {
    const QuietStreams quiet;
    reader->UpdateOutputInformation();
  }
  ImageHeader header;
  const Image* const output = reader->GetOutput();
  const auto size = output->GetLargestPossibleRegion().GetSize();
  for (unsigned i = 0; i < 3; ++i) {
    header.size.at(i) = static_cast<std::int64_t>(size[i]);
    header.spacing_mm[i] = output->GetSpacing()[i] * choice.unit_mm.value_or(1);
    header.origin_mm[i] = output->GetOrigin()[i] * choice.unit_mm.value_or(1);
    for (unsigned row = 0; row < 3; ++row) header.direction(row, i) = output->GetDirection()(row, i);
  }
  header.has_spacing = series.have_pixel_sizes ? kAllAxes : kNoAxis;
  header.unit_is_given = choice.unit_mm.has_value();
  static_cast<void>(chosen_volumes(path, header, choice));
  if (series.have_pixel_sizes && !series.have_places)
    context.warn(path.string() + ": slices do not say where they lie; their order and distance are guesses");
  RawImage image;
  image.type = VoxelType::kFloat;
  image.frame = checked_frame(path, header, context);
  image.voxels = allocate_voxels(path, image.frame, image.type, 0);
  const QuietStreams quiet;
  reader->Update();
  std::memcpy(image.voxels.get(), reader->GetOutput()->GetBufferPointer(),
              image.frame.voxel_count() * voxel_bytes(image.type));
  return image;
}

/// Calls use(reader), or otherwise(), with faults of ITK as ours.
template <class Use, class Otherwise>
auto with_reader(const fs::path& path, const Use& use, const Otherwise& otherwise) {
  itk::Object::SetGlobalWarningDisplay(false);  // ITK prints to stderr; faults reach us as exceptions anyway.
  try {
    if (fs::is_directory(path)) return otherwise();
    if (const itk::ImageIOBase::Pointer io = make_reader(path)) return use(*io);
    if (read_dicom_file(path)) return otherwise();
    fail(path, "is not an image lumesh can read; it takes " + formats_for(FileUse::kReadImage, " or ") +
                   "; surfaces and meshes are " + formats_for(FileUse::kRead, " or ") +
                   ", to which meshio and ParaView convert others");
  } catch (const itk::ExceptionObject& fault) {
    const std::string what = one_line(fault);
    if (what.find("Pixel Type Unknown") != std::string::npos)
      fail(path,
           "has voxels of a type that its format does not know; save them as 16-bit integers or floats");
    fail(path, fmt::format("is damaged or incomplete ({}); save it again", what));
  }
}

}  // namespace

RawImage read_with_itk(const fs::path& path, const FileChoice& choice, Context& context) {
  return with_reader(
      path, [&](itk::ImageIOBase& io) { return read_single(path, io, choice, context); },
      [&] { return read_dicom_series(path, choice, context); });
}

std::size_t volumes_by_itk(const fs::path& path) {
  return with_reader(
      path,
      [&](itk::ImageIOBase& io) {
        if (dynamic_cast<const itk::NrrdImageIO*>(&io) != nullptr) static_cast<void>(nrrd_notes(path));
        return read_header(path, io).volumes;
      },
      [] { return std::size_t{1}; });
}

}  // namespace lumesh::io
