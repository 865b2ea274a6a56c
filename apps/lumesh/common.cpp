#include "common.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <set>

#include "lumesh/core/error.hpp"
#include "lumesh/core/version.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/io/image_file.hpp"
#include "lumesh/io/mesh_file.hpp"

namespace lumesh::cli {

namespace {

/// A line that must not throw, whatever has become of stderr.
void print_line(const std::string& line) {
  std::fputs(line.c_str(), stderr);
}

template <class Number>
std::optional<Number> parsed(std::string_view text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, fault] = std::from_chars(text.data(), end, number);
  if (fault != std::errc() || stop != end) return std::nullopt;
  return number;
}

/// Insertions, deletions and exchanges that lead from one word to the other (Levenshtein 1966).
std::size_t edit_distance(const std::string& from, const std::string& to) {
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::size_t exchanged = diagonal + (from[i] == to[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({exchanged, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

/// The options of the command line as they were given, but for those that do not change the mesh.
std::string given_options(const CLI::App& command) {
  std::string all;
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    constexpr std::string_view kElsewhere[] = {"--threads",  "--verbose", "--quiet",         "--output",
                                               "--surface",  "--json",    "--metric-output", "--balance",
                                               "--topology", "--pin"};
    if (std::find(std::begin(kElsewhere), std::end(kElsewhere), name) != std::end(kElsewhere)) continue;
    if (option->count() == 0 || option->get_positional()) continue;
    all += (all.empty() ? "" : " ") + name;
    if (option->get_items_expected_max() == 0) continue;
    for (const std::string& value : option->results()) all += " " + value;
  }
  return all;
}

}  // namespace

void add_threads_option(CLI::App& command, RunOptions& options) {
  command.add_option("--threads,--nthreads", options.threads, "Threads; 0 = all cores")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
}

void add_verbosity_options(CLI::App& command, RunOptions& options) {
  CLI::Option* const verbose =
      command.add_flag("-v,--verbose", options.verbose, "Say on stderr when each step ends, and its time");
  command.add_flag("-q,--quiet", options.quiet, "Print warnings and errors only")->excludes(verbose);
}

Context make_context(const RunOptions& options) {
  Context context({}, print_warning);
  if (options.verbose > 0)
    context.report_phases_to([](const PhaseTime& phase) {
      print_line(fmt::format("lumesh: {} took {:.2f} s\n", phase.name, phase.seconds));
    });
  return context;
}

void print_warning(std::string_view text) {
  print_line(fmt::format("lumesh: warning: {}\n", text));
}

void add_selection_options(CLI::App& command, ImageSelection& selection, const std::string& verb) {
  command.add_option("--labels", selection.labels, verb + " these labels only")->delimiter(',');
  command.add_option("--threshold", selection.threshold,
                     "Voxels at or above become label 1, the rest background");
  command.add_flag("--largest-component", selection.largest_component,
                   verb + " the largest connected piece of the image only");
}

LabelImage read_selected_image(const std::string& path, const ImageSelection& selection, Context& context) {
  LabelImage image = read_image(path, {selection.labels, selection.threshold}, context);
  if (selection.largest_component > 0) keep_largest_component(image, ComponentScope::kUnion);
  return image;
}

std::vector<CutPlane> planes_from(const PlaneNumbers& numbers) {
  std::vector<CutPlane> planes;
  for (const std::vector<double>& v : numbers) {
    const bool finite = std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
    if (!finite || (v[3] == 0 && v[4] == 0 && v[5] == 0))
      throw Error(ErrorKind::kUsage, "--cut-plane needs a finite point and a normal that is not zero");
    planes.push_back({Vec3(v[0], v[1], v[2]), Vec3(v[3], v[4], v[5])});
  }
  return planes;
}

void add_cut_plane_option(CLI::App& command, PlaneNumbers& planes, const std::string& meaning) {
  command
      .add_option("--cut-plane", planes,
                  "Point and normal in mm, x y z nx ny nz: " + meaning + "; may be repeated")
      ->type_size(6);
}

CLI::Validator positive_number() {
  return number_above(0, "a positive number", "POSITIVE");
}

CLI::Validator number_above(double least, const std::string& wanted, const std::string& name) {
  return {[least, wanted](const std::string& text) {
            const std::optional<double> number = number_from(text);
            const bool good = number && std::isfinite(*number) && *number > least;
            return good ? std::string() : fmt::format("\"{}\" is not {}", text, wanted);
          },
          name};
}

std::optional<double> number_from(std::string_view text) {
  return parsed<double>(text);
}

std::optional<int> integer_from(std::string_view text) {
  return parsed<int>(text);
}

void check_volume_output(const std::string& path) {
  if (is_volume_file(path)) return;
  throw Error(ErrorKind::kUsage, path + ": unknown mesh format; use .vtu, .vtk, .mesh, .meshb or .msh");
}

void check_surface_output(const std::string& path) {
  if (path.empty() || is_surface_file(path)) return;
  throw Error(ErrorKind::kUsage, path + ": unknown surface format; use .vtp or .stl");
}

void check_inputs_stay(std::initializer_list<std::string> outputs,
                       std::initializer_list<std::string> inputs) {
  std::error_code ignored;  // Of files that do not exist, which is told when they are read.
  for (const std::string& output : outputs)
    for (const std::string& input : inputs)
      if (!output.empty() && std::filesystem::is_regular_file(input, ignored) &&
          std::filesystem::equivalent(output, input, ignored))
        throw Error(ErrorKind::kUsage,
                    output + ": is read as input and would be replaced; name another output");
}

void check_output_folders(std::initializer_list<std::string> paths) {
  std::set<std::filesystem::path> named;
  for (const std::string& path : paths)
    if (!path.empty() && !named.insert(std::filesystem::absolute(path).lexically_normal()).second)
      throw Error(ErrorKind::kUsage, path + ": is named for two outputs; give each its own file");
  for (const std::filesystem::path path : paths) {
    if (path.empty()) continue;
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    std::error_code ignored;
    if (!std::filesystem::is_directory(folder, ignored))
      throw Error(ErrorKind::kBadInput, path.string() + ": its folder does not exist; create it first");
    const std::filesystem::file_status status = std::filesystem::status(path, ignored);
    if (std::filesystem::is_directory(status))
      throw Error(ErrorKind::kBadInput, path.string() + ": is a folder; give the name of a file");
    const bool device = std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
    if (!device && ::access(folder.c_str(), W_OK | X_OK) != 0)
      throw Error(ErrorKind::kBadInput, path.string() + ": cannot be written; its folder is read-only");
  }
}

std::map<std::string, std::string> provenance_of(const CLI::App& command, const std::string& input_path,
                                                 const std::map<std::string, std::string>& before) {
  const auto input = before.find("input"), hash = before.find("input_sha256");
  const bool known = input != before.end() && hash != before.end();
  return {{"program", std::string("lumesh ") + kVersion},
          {"command", command.get_name()},
          {"options", given_options(command)},
          {"input", known ? input->second : input_path},
          {"input_sha256", known ? hash->second : file_sha256(input_path)}};
}

std::vector<std::string> doubts_about_image(const std::string& image_path, const std::string& mesh_path,
                                            const MeshInfo& info, std::string_view consequence) {
  const auto made_from = info.provenance.find("input_sha256");
  if (made_from == info.provenance.end() || made_from->second.empty()) return {};
  const std::string found = file_sha256(image_path);
  if (found.empty() || found == made_from->second) return {};
  const auto input = info.provenance.find("input");
  return {fmt::format("{}: is not the file that {} was made from{} (SHA-256 {:.8}, not {:.8}); {}",
                      image_path, mesh_path, input == info.provenance.end() ? "" : ", " + input->second,
                      found, made_from->second, consequence)};
}

void bring_to_lps_mm(MixedMesh& mesh) {
  const bool ras = mesh.info.frame == "RAS";
  const double scale = mesh.info.unit == "m" ? 1000 : mesh.info.unit == "cm" ? 10 : 1;
  if (!ras && scale == 1) return;
  const Vec3 factors = ras ? Vec3(-scale, -scale, scale) : Vec3(scale, scale, scale);
  for (Vec3& p : mesh.points) p = p.cwiseProduct(factors);
  // Lengths in the metric stay as they are; it is per square of the coordinates' unit.
  for (SymTensor& m : mesh.metric) {
    const Vec3 f = factors.cwiseInverse();
    m = {m.xx * f[0] * f[0], m.xy * f[0] * f[1], m.xz * f[0] * f[2],
         m.yy * f[1] * f[1], m.yz * f[1] * f[2], m.zz * f[2] * f[2]};
  }
  mesh.info.frame = "LPS";
  mesh.info.unit = "mm";
}

std::string nearest_word(const std::string& wrong, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, wrong.size() / 2);  // More is another word.
  for (const std::string& word : known) {
    const bool begins = wrong.size() > 1 && word.starts_with(wrong);
    const std::size_t distance = begins ? 0 : edit_distance(wrong, word);
    if (distance > least || (distance == least && !nearest.empty())) continue;
    nearest = word;
    least = distance;
  }
  return nearest;
}

}  // namespace lumesh::cli
