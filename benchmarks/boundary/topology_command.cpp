#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "commands.hpp"
#include "fine_grid.hpp"
#include "lumesh/core/error.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/quality/hausdorff.hpp"
#include "lumesh/quality/statistics.hpp"
#include "lumesh/quality/surface.hpp"
#include "meshers.hpp"
#include "random_labels.hpp"

namespace lumesh::boundary {

namespace {

constexpr double kSpacing = 1;
constexpr std::size_t kVoxelsForVolume = 100;
constexpr double kVolumeBar = 2;    // Per cent.
constexpr double kDistanceBar = 1;  // Voxels.

/// What is wrong with one image, by check.
class Faults {
 public:
  void add(const std::string& check, const std::string& reason) { by_check_[check].push_back(reason); }
  [[nodiscard]] const std::map<std::string, std::vector<std::string>>& by_check() const { return by_check_; }

 private:
  std::map<std::string, std::vector<std::string>> by_check_;
};

/// Pieces and Euler number.
using ShapeByLabel = std::map<Label, std::array<std::int64_t, 2>>;

ShapeByLabel shapes_of(const std::vector<LabelTopology>& topology) {
  ShapeByLabel shapes;
  for (const LabelTopology& t : topology)
    shapes[t.label] = {static_cast<std::int64_t>(t.component_count), t.euler_number};
  return shapes;
}

ShapeByLabel shapes_of(const MixedMesh& mesh) {
  ShapeByLabel shapes;
  for (const quality::SolidTopology& t : quality::analyse_solids(mesh.view()))
    if (t.label != quality::kOutside) shapes[t.label] = {static_cast<std::int64_t>(t.components), t.euler};
  return shapes;
}

/// Labels of which voxels meet others of the same label in an edge only, across two voxels of one other
/// label: both cannot stay apart, and either may join. The background always may.
std::set<Label> ambiguous_labels(const LabelImage& image) {
  std::set<Label> labels;
  const ImageFrame& f = image.frame();
  const auto look_at = [&](const Index3& v, int axis) {
    const Index3 right = Index3::Unit((axis + 1) % 3), up = Index3::Unit((axis + 2) % 3);
    if (!f.contains(v + right + up)) return;
    const Label a = image.label_at(v), b = image.label_at(v + right);
    if (a == b || a != image.label_at(v + right + up) || b != image.label_at(v + up)) return;
    if (a != kBackground && b != kBackground) labels.insert({a, b});
  };
  for (int k = 0; k < f.size.z(); ++k)
    for (int j = 0; j < f.size.y(); ++j)
      for (int i = 0; i < f.size.x(); ++i)
        for (int axis = 0; axis < 3; ++axis) look_at({i, j, k}, axis);
  return labels;
}

/// @param voxels  Of the labels that are compared.
/// @return        How many labels differ.
int compare_shapes(const std::string& check, const ShapeByLabel& voxels, const ShapeByLabel& found,
                   Faults& faults) {
  int different = 0;
  for (const auto& [label, shape] : voxels) {
    const auto at = found.find(label);
    const std::array<std::int64_t, 2> other =
        at == found.end() ? std::array<std::int64_t, 2>{0, 0} : at->second;
    if (other == shape) continue;
    ++different;
    faults.add(check, fmt::format("label {}: pieces {} -> {}, Euler {} -> {}", label, shape[0], other[0],
                                  shape[1], other[1]));
  }
  return different;
}

void check_box(const std::string& check, const ImageFrame& frame, const MixedMesh& mesh, Faults& faults) {
  constexpr double kRounding = 1e-6;
  double worst = 0;
  for (const Vec3& point : mesh.points) {
    const Vec3 index = frame.to_index(point);
    worst = std::max(
        worst,
        std::max((-index).maxCoeff(), (index - frame.size.cast<double>() + Vec3::Ones()).maxCoeff()) - 0.5);
  }
  if (worst > kRounding) faults.add(check, fmt::format("{:.3f} voxels out of the image", worst));
}

void check_volumes(const std::string& check, const std::vector<LabelTopology>& voxels, const MixedMesh& mesh,
                   Faults& faults) {
  std::map<Label, double> volumes;
  for (const quality::LabelVolume& v : quality::measure(mesh.view()).labels) volumes[v.label] = v.volume_mm3;
  for (const LabelTopology& t : voxels) {
    const double percent = 100 * (volumes[t.label] / t.volume_mm3 - 1);
    if (t.voxel_count >= kVoxelsForVolume && std::abs(percent) > kVolumeBar)
      faults.add(check,
                 fmt::format("label {} ({} voxels): volume {:+.1f} %", t.label, t.voxel_count, percent));
  }
}

void check_distances(const std::string& check, const LabelImage& image, const MixedMesh& mesh,
                     Faults& faults) {
  const MeshView view = mesh.view();
  const quality::ImageDistances all =
      quality::compare_with_image(view, quality::extract_surface(view), image, {});
  for (const quality::LabelDistances& label : all.labels) {
    if (!label.distances) continue;  // A lost label is a fault of topology.
    const double there = label.distances->mesh_to_image_mm.max / all.voxel_size_mm;
    const double back = label.distances->image_to_mesh_mm.max / all.voxel_size_mm;
    if (std::max(there, back) > kDistanceBar)
      faults.add(check, fmt::format("label {}: {:.2f} voxels from mesh to voxels, {:.2f} back", label.label,
                                    there, back));
  }
}

struct Totals {
  std::size_t images = 0, labels = 0, ambiguous = 0;
  std::map<std::string, int> images_with, labels_with;
  std::map<Mesher, double> seconds;
  std::map<std::string, int> images_of_kind;
  std::map<std::string, std::map<std::string, int>> kinds_with;  ///< Images by check, then kind.
};

/// What meshes are compared with.
struct Voxels {
  const LabelImage& image;
  std::vector<LabelTopology> labels;
  ShapeByLabel decided;  ///< Without the ambiguous labels.
};

void check_mesh(Mesher mesher, const Voxels& voxels, const ImageDomain& domain, Faults& faults,
                Totals& totals) {
  const std::string name = name_of(mesher);
  const auto start = std::chrono::steady_clock::now();
  try {
    const MixedMesh mesh = mesh_by(mesher, voxels.image, domain, kSpacing);
    totals.seconds[mesher] += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    totals.labels_with[name + " topology"] +=
        compare_shapes(name + " topology", voxels.decided, shapes_of(mesh), faults);
    check_box(name + " box", voxels.image.frame(), mesh, faults);
    check_volumes(name + " volume", voxels.labels, mesh, faults);
    check_distances(name + " distance", voxels.image, mesh, faults);
  } catch (const Error& error) {
    faults.add(name + " no mesh", error.what());
  }
}

void check_image(const RandomLabels& random, const RunOptions& options, Faults& faults, Totals& totals) {
  const LabelImage& image = random.image;
  const ImageDomain domain(image, ImageDomainOptions{});
  Voxels voxels{image, label_topology(image), {}};
  voxels.decided = shapes_of(voxels.labels);
  for (const Label label : ambiguous_labels(image)) voxels.decided.erase(label);
  constexpr int kRefinement = 3;
  const FineGrid grid(image, domain, kRefinement);
  const std::vector<LabelTopology> samples = label_topology(sampled_labels(image, domain, grid));
  totals.labels_with["field topology"] +=
      compare_shapes("field topology", voxels.decided, shapes_of(samples), faults);
  for (const Mesher mesher : kMeshers)
    if (matches(name_of(mesher), options)) check_mesh(mesher, voxels, domain, faults, totals);
  ++totals.images;
  totals.labels += voxels.labels.size();
  totals.ambiguous += voxels.labels.size() - voxels.decided.size();
}

void print_faults(std::uint64_t seed, const RandomLabels& random, const Faults& faults, Totals& totals) {
  constexpr std::size_t kMaxReasons = 3;
  const Index3& size = random.image.frame().size;
  ++totals.images_of_kind[random.kind];
  for (const auto& [check, reasons] : faults.by_check()) {
    ++totals.images_with[check];
    ++totals.kinds_with[check][random.kind];
    if (!check.ends_with("topology")) totals.labels_with[check] += static_cast<int>(reasons.size());
    std::string text;
    for (std::size_t r = 0; r < std::min(reasons.size(), kMaxReasons); ++r)
      text += (r > 0 ? "; " : "") + reasons[r];
    if (reasons.size() > kMaxReasons) text += fmt::format("; and {} more", reasons.size() - kMaxReasons);
    fmt::print("seed {} ({}, {} x {} x {}, {} labels) {}: {}\n", seed, random.kind, size.x(), size.y(),
               size.z(), random.image.values().size() - 1, check, text);
  }
  std::fflush(stdout);
}

nlohmann::ordered_json json_of(std::uint64_t seed, const RandomLabels& random, const Faults& faults) {
  nlohmann::ordered_json json = {
      {"seed", seed}, {"kind", random.kind}, {"labels", random.image.values().size() - 1}};
  json["faults"] = faults.by_check();
  return json;
}

void print_totals(Totals& totals) {
  fmt::print(
      "{} images, {} labels, of which {} meet themselves in an edge across one other label: their topology "
      "is\n"
      "not decided by the voxels and not compared. Images with a fault, labels with it, images by "
      "kind:\n{:<22} "
      "{:>7} {:>7}",
      totals.images, totals.labels, totals.ambiguous, "fault", "images", "labels");
  for (const auto& [kind, images] : totals.images_of_kind) fmt::print(" {:>12}", kind);
  fmt::print("\n{:<22} {:>7} {:>7}", "all", totals.images, totals.labels);
  for (const auto& [kind, images] : totals.images_of_kind) fmt::print(" {:>12}", images);
  for (const auto& [check, images] : totals.images_with) {
    fmt::print("\n{:<22} {:>7} {:>7}", check, images, totals.labels_with[check]);
    for (const auto& [kind, all] : totals.images_of_kind)
      fmt::print(" {:>12}", totals.kinds_with[check][kind]);
  }
  fmt::print("\n");
  for (const auto& [mesher, seconds] : totals.seconds)
    fmt::print("{}: {:.2f} s per image\n", name_of(mesher), seconds / static_cast<double>(totals.images));
}

}  // namespace

void run_topology(const RunOptions& options) {
  JsonLines lines(options.json_path);
  Totals totals;
  for (int seed = options.first_seed; seed < options.first_seed + options.seeds; ++seed) {
    const auto number_of_seed = static_cast<std::uint64_t>(seed);
    const RandomLabels random = random_labels(number_of_seed);
    Faults faults;
    check_image(random, options, faults, totals);
    print_faults(number_of_seed, random, faults, totals);
    lines.write(json_of(number_of_seed, random, faults));
  }
  print_totals(totals);
}

}  // namespace lumesh::boundary
