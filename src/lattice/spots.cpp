#include "spots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "lumesh/parallel/loops.hpp"
#include "missed_tips.hpp"
#include "slits.hpp"

namespace lumesh {

namespace {

// In voxels.
constexpr double kSpot = 4.5;  // misses this close to the centre of a spot belong to it
constexpr double kPart = 7;    // vertices this close to it may move
constexpr double kFar = 1.2;   // what is further from the surface is worth a bold try
constexpr double kSame = 2.5;  // a miss this close to a spot that could not be mended is given up too

/// How bad a spot is: its worst miss, in twentieths of a voxel (what is less makes nothing better), and the
/// number of misses.
std::pair<double, std::size_t> badness(const std::vector<Miss>& missed, double voxel_mm) {
  double worst_mm = 0;
  for (const Miss& m : missed) worst_mm = std::max(worst_mm, m.off_mm);
  return {std::ceil(20 * worst_mm / voxel_mm), missed.size()};
}

/// One spot in a part of its own.
class Spot {
 public:
  Spot(MeshPart part, const Vec3& centre_mm, const FitSetting& setting)
      : part_(std::move(part)),
        centre_mm_(centre_mm),
        setting_(setting),
        voxel_mm_(setting.domain.voxel_size_mm()),
        probes_(probes_near(setting.image, setting.domain, centre_mm, kSpot * voxel_mm_)),
        finder_(setting.image, setting.domain, probes_) {}

  /// False if nothing helped.
  bool mend() {
    keep_if_best();
    const auto at_start = least_;
    const MeshPart first = part_;
    for (const Way& way : kWays) {
      if (least_.second == 0 || (way.bold && least_.first <= 20 * kFar)) break;
      part_ = way.from_start ? first : best_;
      take_turns(way);
    }
    part_ = std::move(best_);
    promising_ = least_.second == 0 || least_.first < at_start.first;
    return least_ < at_start;
  }

  /// Whether another try may help: all is well, or the worst is less bad than before.
  [[nodiscard]] bool is_promising() const { return promising_; }
  [[nodiscard]] MeshPart take() { return std::move(part_); }

 private:
  /// One way to go about it, for what one does not mend another may.
  struct Way {
    bool from_start;      ///< Or from the best state so far.
    bool bold;            ///< Begins with a turn in which things may get worse at first.
    bool close;           ///< Closes slits.
    std::size_t at_once;  ///< Misses that tetrahedra are added for in one turn.
  };
  static constexpr Way kWays[] = {
      {true, false, true, 6}, {false, true, true, 6}, {true, true, false, 6}, {true, true, true, 1}};

  void take_turns(const Way& way) {
    constexpr int kTurns = 10;
    constexpr int kPatience = 2;  // turns that may bring nothing
    finder_ = MissFinder(setting_.image, setting_.domain, probes_);
    std::vector<Miss> missed = misses();
    int best_turn = 0;
    for (int turn = 0; !missed.empty() && turn < kTurns && turn <= best_turn + kPatience; ++turn) {
      take_turn(missed, turn, way, way.bold && turn == best_turn);
      missed = keep_if_best();
      if (improved_) best_turn = turn + 1;
    }
  }

  std::vector<Miss> keep_if_best() {
    std::vector<Miss> missed = misses();
    const auto now = badness(missed, voxel_mm_);
    improved_ = now < least_;
    if (improved_) {
      least_ = now;
      best_ = part_;
    }
    return missed;
  }

  [[nodiscard]] std::vector<Miss> misses() {
    std::vector<Miss> found = finder_.find(part_.mesh, part_.boundary, kMissedVoxels * voxel_mm_);
    std::erase_if(found, [&](const Miss& m) { return (m.place_mm - centre_mm_).norm() > kSpot * voxel_mm_; });
    return found;
  }

  void take_turn(std::vector<Miss> missed, int turn, const Way& way, bool bold) {
    constexpr double kGood = 0.5;
    if (way.close &&
        close_slits(part_.mesh, part_.boundary, setting_.domain, missed, part_.fixed, setting_.limits) > 0)
      missed = misses();
    if (missed.empty()) return;
    const SurfaceStars surface(part_.boundary, part_.mesh.positions.size());
    const std::vector<Miss> worst(
        missed.begin(), missed.begin() + static_cast<std::ptrdiff_t>(std::min(missed.size(), way.at_once)));
    const std::size_t added = reach_missed_tips(part_.mesh, part_.boundary, surface, setting_.domain, worst,
                                                {setting_.limits, part_.fixed, bold});
    const VertexBlocks blocks = part_.movable();
    Fitter fitter(part_.mesh, part_.boundary, part_.targets, setting_, blocks);
    fitter.keep_to_voxels();
    fitter.draw_to(added > 0 ? misses() : missed, std::min(4 + 2 * turn, 8), kGood);
  }

  MeshPart part_;
  Vec3 centre_mm_;
  const FitSetting& setting_;
  double voxel_mm_;
  std::vector<Probe> probes_;
  MissFinder finder_;
  MeshPart best_;
  std::pair<double, std::size_t> least_ = {std::numeric_limits<double>::infinity(), 0};
  bool improved_ = false;
  bool promising_ = false;
};

bool is_near_any(const Vec3& p, const std::vector<Vec3>& places, double reach_mm) {
  return std::any_of(places.begin(), places.end(), [&](const Vec3& q) { return (p - q).norm() < reach_mm; });
}

/// The worst misses that are far enough from each other and from what was given up.
std::vector<Vec3> choose_centres(const std::vector<Miss>& missed, const std::vector<Vec3>& given_up,
                                 double apart_mm, double same_mm) {
  constexpr std::size_t kMostCentres = 512;
  std::vector<Vec3> centres;
  for (const Miss& miss : missed) {
    const Vec3& place = miss.place_mm;
    if (is_near_any(place, given_up, same_mm)) continue;
    if (!is_near_any(place, centres, apart_mm)) centres.push_back(place);
    if (centres.size() == kMostCentres) break;
  }
  return centres;
}

/// Puts back what was mended, but no two parts with a common tetrahedron.
void put_back_all(WholeMesh& whole, const std::vector<std::optional<MeshPart>>& mended) {
  std::vector<std::uint8_t> taken(whole.mesh.tets.size(), 0);
  for (const std::optional<MeshPart>& part : mended) {
    if (!part) continue;
    const bool free =
        std::none_of(part->tets.begin(), part->tets.end(), [&](std::uint32_t t) { return taken[t] != 0; });
    if (!free) continue;  // its misses are found again
    for (const std::uint32_t t : part->tets) taken[t] = 1;
    put_back(whole, *part);
  }
  drop_gone_triangles(whole);
}

}  // namespace

void mend_spots(WholeMesh& whole, const FitSetting& setting, MissFinder& finder, std::size_t probes) {
  constexpr int kRounds = 8;
  const double voxel_mm = setting.domain.voxel_size_mm();
  const double apart_mm = 2 * kPart * voxel_mm + longest_edge_mm(whole.mesh);
  std::vector<Vec3> given_up;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Miss> missed = finder.find(whole.mesh, whole.boundary, kMissedVoxels * voxel_mm);
    if (missed.size() > probes / 100) break;
    const std::vector<Vec3> centres = choose_centres(missed, given_up, apart_mm, kSame * voxel_mm);
    if (centres.empty()) break;
    const SurfaceTree tree(whole.mesh, whole.boundary, centres, (kPart + 1) * voxel_mm);
    std::vector<std::optional<MeshPart>> mended(centres.size());
    std::vector<std::uint8_t> promising(centres.size(), 0);
    parallel::for_each_index(
        centres.size(),
        [&](std::size_t i) {
          Spot spot(cut_out(whole, tree, centres[i], kPart * voxel_mm), centres[i], setting);
          if (spot.mend()) mended[i] = spot.take();
          promising[i] = spot.is_promising() ? 1 : 0;
        },
        1);
    for (std::size_t i = 0; i < centres.size(); ++i) {
      if (promising[i] == 0) given_up.push_back(centres[i]);
    }
    put_back_all(whole, mended);
  }
  drop_gone(whole);
}

}  // namespace lumesh
