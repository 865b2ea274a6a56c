#include "spots.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <utility>

#include "crossings.hpp"
#include "lumesh/parallel/loops.hpp"
#include "missed_tips.hpp"
#include "slits.hpp"

namespace lumesh {

namespace {

// In voxels.
constexpr double kMissed = 0.5;  // what is further from the surface is missed; smooth vessels come closer
constexpr double kSpot = 4.5;    // misses this close to the centre of a spot belong to it
constexpr double kAnew = 4;      // vertices this close to the centre go back to the lattice
constexpr double kShell = 6.5;   // misses that arise up to here count too
constexpr double kPart = 7;      // vertices this close to it may move; more if edges are longer than that
constexpr double kShake = 0.6;   // vertices are shaken by half of it, or twice or three times that
constexpr double kSame = 2.5;    // a miss this close to a spot that could not be mended is given up too

// Vertices with a better angle quality stay.
constexpr double kGoodAsItIs = 0.25;
constexpr double kGoodAnew = 0.3;
constexpr std::size_t kAtOnce = 6;  // misses that tetrahedra are added for in one turn

/// How bad a spot is: its worst miss, in twentieths of a voxel (what is less makes nothing better), and the
/// number of misses.
std::pair<double, std::size_t> badness(const std::vector<Miss>& missed, double voxel_mm) {
  double worst_mm = 0;
  for (const Miss& m : missed) worst_mm = std::max(worst_mm, m.off_mm);
  return {std::ceil(20 * worst_mm / voxel_mm), missed.size()};
}

/// Places moved by up to half an amplitude along each axis, otherwise for another seed.
std::vector<Vec3> shaken(std::vector<Vec3> places, unsigned seed, double amplitude) {
  std::mt19937_64 random(seed);
  for (Vec3& p : places) {
    for (int axis = 0; axis < 3; ++axis)
      p[axis] += amplitude * (std::ldexp(static_cast<double>(random()), -64) - 0.5);
  }
  return places;
}

struct SpotResult {
  bool better = false;
  bool promising = false;  ///< Nothing is missed any more, or the worst is less bad: another time may help.
  bool stopped_early = false;  ///< Before all tries allowed: more would not help.
  std::size_t tries = 0;       ///< That were made.
};

/// One spot in a part of its own.
class Spot {
 public:
  Spot(MeshPart part, OuterSurroundings surroundings, const Vec3& centre_mm, const FitSetting& setting)
      : part_(std::move(part)),
        surroundings_(std::move(surroundings)),
        centre_mm_(centre_mm),
        setting_(setting),
        voxel_mm_(setting.domain.voxel_size_mm()),
        probes_(probes_near(setting.image, setting.domain, centre_mm, kShell * voxel_mm_)),
        finder_(setting.domain, probes_) {}

  /// What a try costs: the tetrahedra that it works on, and something for what each try costs besides.
  [[nodiscard]] std::size_t cost() const { return part_.mesh.tets.size() + 1500; }

  /// First as it is, then anew from the lattice, at most until `most` tries have been made.
  /// @param made  Tries made before; what follows is different.
  /// @param seed  Another one for each call at the same place.
  SpotResult mend(std::size_t made, std::size_t most, unsigned seed) {
    constexpr int kInVain = 3;  // tries in a row that leave too many misses for anything good to come of them
    std::vector<Miss> missed = keep_if_best();
    const auto at_start = least_;
    const MeshPart first = part_;
    take_turns(std::move(missed), false);
    // After fitting anew; where much was missed at the start, about as much may be mended still.
    const std::size_t too_many = std::max<std::size_t>(20, at_start.second + at_start.second / 4);
    std::size_t n = made;
    int in_vain = 0;
    for (; n < most && in_vain < kInVain && is_worth_try(n); ++n) {
      part_ = first;
      missed = fit_anew(static_cast<unsigned>(n), seed);
      in_vain = missed.size() > too_many ? in_vain + 1 : 0;
      if (in_vain == 0) take_turns(std::move(missed), true);
    }
    const bool better = least_ < at_start;
    const bool well = better && least_.second == 0;
    return {better, well || least_.first < at_start.first, n < most || in_vain == kInVain, n - made};
  }

  [[nodiscard]] MeshPart take() { return std::move(best_); }

 private:
  /// What is off by little is worth few tries only.
  [[nodiscard]] bool is_worth_try(std::size_t n) const {
    constexpr double kLittle = 1.2;  // voxels
    constexpr std::size_t kFew = 3;
    return least_.second > 0 && (n < kFew || least_.first > 20 * kLittle);
  }

  /// Takes what is near the centre back to its places in the lattice, where nothing is folded, shakes them,
  /// and fits again; a little further around for each try.
  /// @return What is missed then.
  [[nodiscard]] std::vector<Miss> fit_anew(unsigned n, unsigned seed) {
    constexpr int kSweeps = 5;  // there and back
    const double shake_mm = (1 + n % 3) * kShake * voxel_mm_;
    const VertexBlocks blocks = part_.movable();
    const VertexBlocks near = pick_vertices(blocks, [&](std::uint32_t v) {
      return !is_on_cut(setting_.domain, part_.boundary.sets[v]) &&
             (part_.mesh.positions[v] - centre_mm_).norm() <= (kAnew + 0.5 * n) * voxel_mm_;
    });
    Fitter fitter(part_.mesh, part_.boundary, part_.targets, setting_, blocks);
    fitter.refit_from(shaken(part_.lattice_mm, 100 * seed + n, shake_mm), near, kSweeps, kGoodAnew);
    finder_ = MissFinder(setting_.domain, probes_);
    return keep_if_best();
  }

  /// @param bold  Things may get worse at first, in the first turn and in those after a success.
  void take_turns(std::vector<Miss> missed, bool bold) {
    constexpr int kTurns = 10;
    constexpr int kPatience = 2;  // turns after a first one that bring nothing
    int best_turn = 0;
    for (int turn = 0; !missed.empty() && turn < kTurns && turn <= best_turn + kPatience; ++turn) {
      const auto before = least_;
      take_turn(missed, turn, bold && turn == best_turn, bold ? kGoodAnew : kGoodAsItIs);
      missed = keep_if_best();
      if (least_ < before) best_turn = turn + 1;
    }
  }

  std::vector<Miss> keep_if_best() {
    std::vector<Miss> missed = misses();
    const auto now = badness(missed, voxel_mm_);
    if (now < least_ && crosses_no_more()) {
      least_ = now;
      best_ = part_;
    }
    return missed;
  }

  /// The surface does not cross itself, or no more than it did in the best state.
  [[nodiscard]] bool crosses_no_more() {
    const std::size_t crossings = surroundings_.count_crossings(part_);
    if (crossings > most_crossings_) return false;
    most_crossings_ = crossings;
    return true;
  }

  [[nodiscard]] std::vector<Miss> misses() {
    std::vector<Miss> found = finder_.find(part_.mesh, part_.boundary, kMissed * voxel_mm_);
    if (!known_mm_) {
      known_mm_.emplace();
      for (const Miss& m : found) known_mm_->push_back(m.place_mm);
    }
    std::erase_if(found, [&](const Miss& m) { return !counts(m); });
    return found;
  }

  /// Around the core, only what has been missed since the start: the rest is another spot's, or belongs to
  /// triangles that the part does not have.
  [[nodiscard]] bool counts(const Miss& m) const {
    const double away_mm = (m.place_mm - centre_mm_).norm();
    if (away_mm <= kSpot * voxel_mm_) return true;
    if (!m.stray && away_mm > kShell * voxel_mm_) return false;
    const double same_mm = m.stray ? voxel_mm_ : 0;
    return std::none_of(known_mm_->begin(), known_mm_->end(),
                        [&](const Vec3& p) { return (p - m.place_mm).norm() <= same_mm; });
  }

  void take_turn(std::vector<Miss> missed, int turn, bool bold, double good_enough) {
    missed = close_some_slits(std::move(missed));
    if (missed.empty()) return;
    const SurfaceStars surface(part_.boundary, part_.mesh.positions.size());
    const std::vector<Miss> worst(
        missed.begin(), missed.begin() + static_cast<std::ptrdiff_t>(std::min(missed.size(), kAtOnce)));
    const std::size_t added = reach_missed_tips(part_.mesh, part_.boundary, surface, setting_.domain, worst,
                                                {setting_.limits, part_.fixed, bold});
    const VertexBlocks blocks = part_.movable();
    Fitter fitter(part_.mesh, part_.boundary, part_.targets, setting_, blocks);
    fitter.draw_to(added > 0 ? misses() : missed, std::min(4 + 2 * turn, 8), good_enough);
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
  OuterSurroundings surroundings_;
  std::size_t most_crossings_ = std::numeric_limits<std::size_t>::max();
  Vec3 centre_mm_;
  const FitSetting& setting_;
  double voxel_mm_;
  std::vector<Probe> probes_;
  MissFinder finder_;
  MeshPart best_;
  std::pair<double, std::size_t> least_ = {std::numeric_limits<double>::infinity(), 0};
  std::optional<std::vector<Vec3>> known_mm_;  // the misses at the start, once they are known
};

/// Where tries have been made in vain.
class TriedPlaces {
 public:
  static constexpr std::size_t kMost = 12;  // at one place

  explicit TriedPlaces(double same_mm) : same_mm_(same_mm) {}

  [[nodiscard]] std::size_t tries_at(const Vec3& p) const {
    std::size_t tries = 0;
    for (const Place& t : places_) {
      if ((t.place_mm - p).norm() < same_mm_) tries = std::max(tries, t.tries);
    }
    return tries;
  }
  void set(const Vec3& p, std::size_t tries) {
    std::erase_if(places_, [&](const Place& t) { return (t.place_mm - p).norm() < same_mm_; });
    if (tries > 0) places_.push_back({p, tries});
  }

 private:
  struct Place {
    Vec3 place_mm;
    std::size_t tries;
  };
  double same_mm_;
  std::vector<Place> places_;
};

/// The worst misses that are far enough from each other and from what was given up.
std::vector<Vec3> choose_centres(const std::vector<Miss>& missed, const TriedPlaces& tried, double apart_mm) {
  constexpr std::size_t kMostCentres = 512;
  std::vector<Vec3> centres;
  for (const Miss& miss : missed) {
    const Vec3& place = miss.place_mm;
    if (tried.tries_at(place) >= TriedPlaces::kMost) continue;
    const bool free = std::none_of(centres.begin(), centres.end(),
                                   [&](const Vec3& c) { return (c - place).norm() < apart_mm; });
    if (free) centres.push_back(place);
    if (centres.size() == kMostCentres) break;
  }
  return centres;
}

std::size_t count_probes(const std::vector<Miss>& missed) {
  return static_cast<std::size_t>(
      std::count_if(missed.begin(), missed.end(), [](const Miss& m) { return !m.stray; }));
}

/// Mends spots in rounds.
class SpotMender {
 public:
  SpotMender(WholeMesh& whole, const FitSetting& setting)
      : whole_(whole),
        setting_(setting),
        edge_mm_(longest_edge_mm(whole.mesh)),
        part_mm_(std::max(kPart * setting.domain.voxel_size_mm(), edge_mm_)),
        tried_(kSame * setting.domain.voxel_size_mm()),
        work_left_(3 * whole.mesh.tets.size() / 2) {}

  /// One round. What is mended easily may mend its neighbours too, so that the first one makes few tries.
  /// @return False if nothing was done, because nothing is left to do or more rounds would hardly help.
  bool mend(const std::vector<Miss>& missed) {
    if (work_left_ == 0 && dull_rounds_ >= 3) return false;
    const std::vector<Vec3> centres = choose_centres(missed, tried_, 2 * part_mm_ + edge_mm_);
    if (centres.empty()) return false;
    const SurfaceTree tree(whole_.mesh, whole_.boundary, centres, part_mm_ + edge_mm_);
    const std::size_t share = work_left_ / centres.size();
    std::vector<Mended> mended(centres.size());
    parallel::for_each_index(
        centres.size(), [&](std::size_t i) { mended[i] = mend_spot(tree, centres[i], share); }, 1);
    if (round_ > 0) note_tries(centres, mended);
    ++round_;
    put_back_all(mended);
    const bool promising =
        std::any_of(mended.begin(), mended.end(), [](const Mended& m) { return m.result.promising; });
    dull_rounds_ = promising ? 0 : dull_rounds_ + 1;
    return true;
  }

 private:
  struct Mended {
    SpotResult result;
    std::optional<MeshPart> part;  // if it is better than what was there
    std::size_t work = 0;
  };

  [[nodiscard]] Mended mend_spot(const SurfaceTree& tree, const Vec3& centre_mm, std::size_t share) const {
    const std::size_t made = tried_.tries_at(centre_mm);
    MeshPart part = cut_out(whole_, tree, centre_mm, part_mm_);
    OuterSurroundings surroundings(whole_, tree, part, setting_.domain);
    Spot spot(std::move(part), std::move(surroundings), centre_mm, setting_);
    const std::size_t cost = spot.cost();
    std::size_t most = 1;
    if (round_ > 0) {
      const std::size_t affordable = std::max<std::size_t>(share / cost, work_left_ > 0 ? 1 : 0);
      most = std::min(made + affordable, TriedPlaces::kMost);
    }
    Mended mended;
    mended.result = spot.mend(made, most, round_);
    mended.work = mended.result.tries * cost;
    if (mended.result.better) mended.part = spot.take();
    return mended;
  }

  void note_tries(const std::vector<Vec3>& centres, const std::vector<Mended>& mended) {
    for (std::size_t i = 0; i < centres.size(); ++i) {
      const SpotResult& result = mended[i].result;
      work_left_ -= std::min(work_left_, mended[i].work);
      const bool gives_up = result.stopped_early || work_left_ == 0;
      const std::size_t made = tried_.tries_at(centres[i]) + result.tries;
      tried_.set(centres[i], result.promising ? 0 : gives_up ? TriedPlaces::kMost : made);
    }
  }

  /// No two parts with a common tetrahedron.
  void put_back_all(const std::vector<Mended>& mended) {
    std::vector<std::uint8_t> taken(whole_.mesh.tets.size(), 0);
    for (const Mended& m : mended) {
      if (!m.part) continue;
      const std::vector<std::uint32_t>& tets = m.part->tets;
      if (std::any_of(tets.begin(), tets.end(), [&](std::uint32_t t) { return taken[t] != 0; }))
        continue;  // its misses are found again
      for (const std::uint32_t t : tets) taken[t] = 1;
      put_back(whole_, *m.part);
    }
    drop_gone_triangles(whole_);
  }

  WholeMesh& whole_;
  const FitSetting& setting_;
  double edge_mm_;
  double part_mm_;  // how far parts reach around their centres
  TriedPlaces tried_;
  // For tries after the first round; may be passed by one try for each spot of a round. Follows the size of
  // the mesh, so that time does too.
  std::size_t work_left_;
  unsigned round_ = 0;
  int dull_rounds_ = 0;  // in a row, that brought nothing
};

}  // namespace

std::vector<Miss> mend_spots(WholeMesh& whole, const FitSetting& setting, MissFinder& finder,
                             std::size_t probes) {
  constexpr int kRounds = 16;
  const double limit_mm = kMissed * setting.domain.voxel_size_mm();
  const std::size_t too_many = std::max<std::size_t>(100, probes / 100);
  SpotMender mender(whole, setting);
  std::vector<Miss> missed = finder.find(whole.mesh, whole.boundary, limit_mm, too_many);
  for (int round = 0; round < kRounds; ++round) {
    if (count_probes(missed) > too_many) break;  // the lattice is too coarse to come close everywhere
    if (!mender.mend(missed)) break;
    missed = finder.find(whole.mesh, whole.boundary, limit_mm, too_many);
  }
  drop_gone(whole);
  return missed;
}

}  // namespace lumesh
