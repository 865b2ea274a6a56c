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
constexpr double kSpot = 4.5;   // misses this close to the centre of a spot belong to it
constexpr double kShell = 6.5;  // misses that arise up to here count too
constexpr double kPart = 7;     // vertices this close to it may move; more if edges are longer than that
constexpr double kFar = 1.2;    // what is further from the surface is worth a bold try
constexpr double kSame = 2.5;   // a miss this close to a spot that could not be mended is given up too

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
        probes_(probes_near(setting.image, setting.domain, centre_mm, kShell * voxel_mm_)),
        finder_(setting.image, setting.domain, probes_) {}

  /// False if nothing helped.
  bool mend() {
    std::vector<Miss> missed = keep_if_best();
    const auto at_start = least_;
    const MeshPart first = part_;
    for (const Way& way : kWays) {
      if (least_.second == 0 || (way.bold && least_.first <= 20 * kFar)) break;
      if (&way != &kWays[0]) missed = go_back_to(way.from_start ? first : best_);
      take_turns(way, missed);
    }
    part_ = std::move(best_);
    promising_ = at_start.second > 0 && (least_.second == 0 || least_.first < at_start.first);
    return least_ < at_start;
  }

  /// Whether another try may help: all is well, or the worst is less bad than before.
  [[nodiscard]] bool is_promising() const { return promising_; }
  [[nodiscard]] MeshPart take() { return std::move(part_); }

 private:
  /// One way to go about it, for what one does not mend another may.
  struct Way {
    bool from_start;      ///< Or from the best state so far.
    bool bold;            ///< Things may get worse at first in the first turn and in those after a success.
    bool close;           ///< Closes slits.
    std::size_t at_once;  ///< Misses that tetrahedra are added for in one turn.
  };
  static constexpr Way kWays[] = {
      {true, false, true, 6}, {false, true, true, 6}, {true, true, false, 6}, {true, true, true, 1}};

  /// @return What is missed there.
  [[nodiscard]] std::vector<Miss> go_back_to(const MeshPart& state) {
    part_ = state;
    finder_ = MissFinder(setting_.image, setting_.domain, probes_);
    return misses();
  }

  void take_turns(const Way& way, std::vector<Miss> missed) {
    constexpr int kTurns = 10;
    constexpr int kPatience = 2;  // turns after a first one that bring nothing
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
    if (!knows_shell_) {
      for (const Miss& m : found) known_in_shell_.push_back(m.place_mm);
      knows_shell_ = true;
    }
    std::erase_if(found, [&](const Miss& m) { return !counts(m); });
    return found;
  }

  /// Around the core, only what has been missed since the start: the rest is another spot's, or belongs to
  /// triangles that the part does not have.
  [[nodiscard]] bool counts(const Miss& m) const {
    const double away_mm = (m.place_mm - centre_mm_).norm();
    if (away_mm <= kSpot * voxel_mm_) return true;
    return away_mm <= kShell * voxel_mm_ && !m.stray &&
           std::find(known_in_shell_.begin(), known_in_shell_.end(), m.place_mm) == known_in_shell_.end();
  }

  void take_turn(std::vector<Miss> missed, int turn, const Way& way, bool bold) {
    constexpr double kGood = 0.5;
    if (way.close) missed = close_some_slits(std::move(missed));
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

  /// @return What is missed then.
  [[nodiscard]] std::vector<Miss> close_some_slits(std::vector<Miss> missed) {
    constexpr int kMost = 6;
    for (int n = 0; n < kMost; ++n) {
      if (!close_slit(part_.mesh, part_.boundary, setting_.domain, missed, part_.fixed, setting_.limits))
        break;
      missed = misses();
    }
    for (std::size_t v = 0; v < part_.boundary.sets.size(); ++v) {
      if (part_.boundary.sets[v].size() < 2) part_.targets.anchors_mm[v].reset();
    }
    return missed;
  }

  MeshPart part_;
  Vec3 centre_mm_;
  const FitSetting& setting_;
  double voxel_mm_;
  std::vector<Probe> probes_;
  MissFinder finder_;
  MeshPart best_;
  std::pair<double, std::size_t> least_ = {std::numeric_limits<double>::infinity(), 0};
  std::vector<Vec3> known_in_shell_;  // misses at the start
  bool knows_shell_ = false;
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

std::size_t count_missed_probes(const std::vector<Miss>& missed) {
  return static_cast<std::size_t>(
      std::count_if(missed.begin(), missed.end(), [](const Miss& m) { return !m.stray; }));
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
  const double edge_mm = longest_edge_mm(whole.mesh);
  const double part_mm = std::max(kPart * voxel_mm, edge_mm);
  std::vector<Vec3> given_up;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Miss> missed = finder.find(whole.mesh, whole.boundary, kMissedVoxels * voxel_mm);
    if (count_missed_probes(missed) > std::max<std::size_t>(100, probes / 100)) break;
    const std::vector<Vec3> centres =
        choose_centres(missed, given_up, 2 * part_mm + edge_mm, kSame * voxel_mm);
    if (centres.empty()) break;
    const SurfaceTree tree(whole.mesh, whole.boundary, centres, part_mm + edge_mm);
    std::vector<std::optional<MeshPart>> mended(centres.size());
    std::vector<std::uint8_t> promising(centres.size(), 0);
    parallel::for_each_index(
        centres.size(),
        [&](std::size_t i) {
          Spot spot(cut_out(whole, tree, centres[i], part_mm), centres[i], setting);
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
