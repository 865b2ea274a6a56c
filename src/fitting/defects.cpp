#include "defects.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <utility>

#include "crossings.hpp"
#include "fitter.hpp"
#include "folds.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/parallel/loops.hpp"
#include "narrow_gaps.hpp"
#include "part_crossings.hpp"
#include "protrusions.hpp"

namespace lumesh::fitting {

namespace {

// In voxels.
constexpr double kMaxDeviation = 0.5;  // larger distances are deviations; smooth vessels come closer
constexpr double kDefect = 4.5;        // deviations this close to the centre of a defect belong to it
constexpr double kAnew = 4;            // vertices this close to the centre go back to the lattice
constexpr double kShell = 6.5;         // deviations that arise up to here count too
constexpr double kPart = 7;  // vertices this close to it may move; more if edges are longer than that
constexpr double kPerturbation = 0.6;  // vertices are moved by half of it, or twice or three times that
constexpr double kSame = 2.5;          // a deviation this close to a defect beyond repair is given up too

// Vertices with a better angle quality stay.
constexpr double kGoodAsItIs = 0.25;
constexpr std::size_t kAtOnce = 6;  // deviations that tetrahedra are added for in one turn

constexpr double kSteps = 20;  // of the largest deviation in a voxel; smaller ones are no improvement

/// Badness of a defect: its largest deviation in steps and the number of deviations.
std::pair<double, std::size_t> badness(const std::vector<Deviation>& deviations, double voxel_mm) {
  double worst_mm = 0;
  for (const Deviation& m : deviations) worst_mm = std::max(worst_mm, m.off_mm);
  return {std::ceil(kSteps * worst_mm / voxel_mm), deviations.size()};
}

/// Places moved by up to half an amplitude along each axis, otherwise for another seed.
std::vector<Vec3> perturbed(std::vector<Vec3> places, unsigned seed, double amplitude) {
  std::mt19937_64 random(seed);
  for (Vec3& p : places) {
    for (int axis = 0; axis < 3; ++axis)
      p[axis] += amplitude * (std::ldexp(static_cast<double>(random()), -64) - 0.5);
  }
  return places;
}

struct RepairResult {
  bool better = false;
  bool promising = false;      ///< No deviation is left, or the largest is smaller: another time may help.
  bool stopped_early = false;  ///< Fewer tries were made than allowed: more would not help.
  std::size_t tries = 0;       ///< Number of tries made.
};

/// One defect in a part of its own.
class Defect {
 public:
  Defect(MeshPart part, SurroundingSurface surroundings, const Vec3& centre_mm, const FitSetting& setting)
      : part_(std::move(part)),
        surroundings_(std::move(surroundings)),
        centre_mm_(centre_mm),
        setting_(setting),
        voxel_mm_(setting.domain.voxel_size_mm()),
        probes_(probes_near(setting.image, setting.domain, centre_mm, kShell * voxel_mm_)),
        finder_(setting.domain, probes_) {}

  /// Cost of one attempt: the tetrahedra that it works on, and a constant.
  [[nodiscard]] std::size_t cost() const { return part_.mesh.tets.size() + 1500; }

  /// First as it is, then anew from the lattice, at most until `max_tries` tries have been made.
  /// @param made  Tries made before; what follows is different.
  /// @param seed  Another one for each call at the same place.
  RepairResult repair(std::size_t made, std::size_t max_tries, unsigned seed) {
    constexpr int kMaxFailures = 3;  // tries in a row that leave too many deviations to improve on
    std::vector<Deviation> deviations = keep_if_best();
    const auto at_start = best_badness_;
    const bool is_beside = is_at_opening();
    min_cosine_ = is_beside ? 0.5 : 0;
    // Beside single voxels that stand out exactly, which boundary a triangle faces is not clear.
    constexpr double kGross = 1.25, kGrossOfExact = 0.75;  // voxels
    const bool is_exact = setting_.domain.field().fidelity() == BoundaryFidelity::kExact;
    may_steepen_ = at_start.first > kSteps * (is_exact && !is_beside ? kGrossOfExact : kGross);
    max_steep_ = count_steep();
    const MeshPart first = part_;
    take_turns(std::move(deviations), false);
    // After fitting anew; where there were many deviations at the start, about as many can still be repaired.
    const std::size_t too_many = std::max<std::size_t>(20, at_start.second + at_start.second / 4);
    std::size_t n = made;
    int failures = 0;
    for (; n < max_tries && failures < kMaxFailures && is_worth_try(n); ++n) {
      part_ = first;
      deviations = fit_anew(static_cast<unsigned>(n), seed);
      failures = deviations.size() > too_many ? failures + 1 : 0;
      if (failures == 0) take_turns(std::move(deviations), true);
    }
    const bool better = best_badness_ < at_start;
    const bool well = better && best_badness_.second == 0;
    return {better, well || best_badness_.first < at_start.first, n < max_tries || failures == kMaxFailures,
            n - made};
  }

  [[nodiscard]] MeshPart take() { return std::move(best_); }

 private:
  /// False for small deviations after a few attempts.
  [[nodiscard]] bool is_worth_try(std::size_t n) const {
    constexpr double kLittle = 1.2;  // voxels
    constexpr std::size_t kFew = 3;
    return best_badness_.second > 0 && (n < kFew || best_badness_.first > kSteps * kLittle);
  }

  /// Takes the vertices near the centre back to their places in the lattice, where nothing is folded,
  /// perturbs them, and fits again; a little further around for each try.
  /// @return The deviations that are left.
  [[nodiscard]] std::vector<Deviation> fit_anew(unsigned n, unsigned seed) {
    constexpr int kSweeps = 5;  // there and back
    const double perturbation_mm = (1 + n % 3) * kPerturbation * voxel_mm_;
    const VertexBlocks blocks = part_.movable();
    const VertexBlocks near = pick_vertices(blocks, [&](std::uint32_t v) {
      return !is_on_cut(setting_.domain, part_.boundary.sets[v]) &&
             (part_.mesh.positions[v] - centre_mm_).norm() <= (kAnew + 0.5 * n) * voxel_mm_;
    });
    Fitter fitter(part_.mesh, part_.boundary, part_.targets, setting_, blocks);
    fitter.refit_from(perturbed(part_.lattice_mm, 100 * seed + n, perturbation_mm), near, kSweeps,
                      Fitter::kGood);
    finder_ = DeviationFinder(setting_.domain, probes_);
    return keep_if_best();
  }

  /// @param allows_temporary_deviation  Deviations may grow at first, in the first turn and in those after a
  /// success.
  void take_turns(std::vector<Deviation> deviations, bool allows_temporary_deviation) {
    constexpr int kTurns = 10;
    constexpr int kPatience = 2;  // turns after a first one that bring nothing
    int best_turn = 0;
    for (int turn = 0; !deviations.empty() && turn < kTurns && turn <= best_turn + kPatience; ++turn) {
      const auto before = best_badness_;
      take_turn(deviations, turn, allows_temporary_deviation && turn == best_turn,
                allows_temporary_deviation ? Fitter::kGood : kGoodAsItIs);
      deviations = keep_if_best();
      if (best_badness_ < before) best_turn = turn + 1;
    }
  }

  std::vector<Deviation> keep_if_best() {
    std::vector<Deviation> deviations = find_deviations();
    const auto now = badness(deviations, voxel_mm_);
    if (now < best_badness_ && steepens_no_more() && crosses_no_more()) {
      best_badness_ = now;
      best_ = part_;
    }
    return deviations;
  }

  /// The surface does not cross itself, or no more than it did in the best state.
  [[nodiscard]] bool crosses_no_more() {
    const std::size_t crossings = surroundings_.count_crossings(part_);
    if (crossings > max_crossings_) return false;
    max_crossings_ = crossings;
    return true;
  }

  [[nodiscard]] bool is_at_opening() const {
    return std::ranges::any_of(part_.boundary.triangles,
                               [&](const BoundaryTriangle& t) { return setting_.domain.is_cut(t.outside); });
  }

  /// No more triangles of the wall than in the best state are folded, or beside an opening stand at more than
  /// 60 degrees to the domain's boundary; but where the deviation was gross.
  [[nodiscard]] bool steepens_no_more() {
    if (may_steepen_) return true;
    const std::size_t steep = count_steep();
    if (steep > max_steep_) return false;
    max_steep_ = steep;
    return true;
  }

  [[nodiscard]] std::size_t count_steep() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(part_.boundary.triangles, [&](const BoundaryTriangle& t) {
          return is_steep_wall(part_.mesh, t, setting_.domain, min_cosine_);
        }));
  }

  [[nodiscard]] std::vector<Deviation> find_deviations() {
    std::vector<Deviation> found = finder_.find(part_.mesh, part_.boundary, kMaxDeviation * voxel_mm_);
    if (!known_mm_) {
      known_mm_.emplace();
      for (const Deviation& m : found) known_mm_->push_back(m.place_mm);
    }
    std::erase_if(found, [&](const Deviation& m) { return !counts(m); });
    return found;
  }

  /// Around the core, only deviations that arose since the start: the others are another defect's, or belong
  /// to triangles that the part does not have.
  [[nodiscard]] bool counts(const Deviation& m) const {
    const double away_mm = (m.place_mm - centre_mm_).norm();
    if (away_mm <= kDefect * voxel_mm_) return true;
    if (!m.is_outlier && away_mm > kShell * voxel_mm_) return false;
    const double same_mm = m.is_outlier ? voxel_mm_ : 0;
    return std::none_of(known_mm_->begin(), known_mm_->end(),
                        [&](const Vec3& p) { return (p - m.place_mm).norm() <= same_mm; });
  }

  void take_turn(std::vector<Deviation> deviations, int turn, bool allows_temporary_deviation,
                 double good_enough) {
    deviations = close_some_gaps(std::move(deviations));
    if (deviations.empty()) return;
    const BoundaryStars surface(part_.boundary, part_.mesh.positions.size());
    const std::vector<Deviation> worst(
        deviations.begin(),
        deviations.begin() + static_cast<std::ptrdiff_t>(std::min(deviations.size(), kAtOnce)));
    const std::size_t added = grow_protrusions(part_.mesh, part_.boundary, surface, setting_.domain, worst,
                                               {setting_.limits, part_.fixed, allows_temporary_deviation});
    const VertexBlocks blocks = part_.movable();
    Fitter fitter(part_.mesh, part_.boundary, part_.targets, setting_, blocks);
    fitter.attract_to(added > 0 ? find_deviations() : deviations, std::min(4 + 2 * turn, 8), good_enough);
  }

  /// @return The deviations that are left.
  [[nodiscard]] std::vector<Deviation> close_some_gaps(std::vector<Deviation> deviations) {
    constexpr int kMaxGaps = 6;
    for (int n = 0; n < kMaxGaps; ++n) {
      if (!close_gap(part_.mesh, part_.boundary, setting_.domain, deviations, part_.fixed, setting_.limits))
        break;
      deviations = find_deviations();
    }
    for (std::size_t v = 0; v < part_.boundary.sets.size(); ++v) {
      if (part_.boundary.sets[v].size() < 2) part_.targets.anchors_mm[v].reset();
    }
    return deviations;
  }

  MeshPart part_;
  SurroundingSurface surroundings_;
  bool may_steepen_ = true;
  double min_cosine_ = 0;
  std::size_t max_steep_ = 0;
  std::size_t max_crossings_ = std::numeric_limits<std::size_t>::max();
  Vec3 centre_mm_;
  const FitSetting& setting_;
  double voxel_mm_;
  std::vector<Probe> probes_;
  DeviationFinder finder_;
  MeshPart best_;
  std::pair<double, std::size_t> best_badness_ = {std::numeric_limits<double>::infinity(), 0};
  std::optional<std::vector<Vec3>> known_mm_;  // places of the deviations at the start, once these are known
};

/// Places where tries have failed.
class TriedPlaces {
 public:
  static constexpr std::size_t kMaxTries = 12;  // at one place

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

/// Places of the largest deviations, far enough from each other and from those given up.
std::vector<Vec3> choose_centres(const std::vector<Deviation>& deviations, const TriedPlaces& tried,
                                 double apart_mm) {
  constexpr std::size_t kMaxCentres = 512;
  std::vector<Vec3> centres;
  for (const Deviation& deviation : deviations) {
    const Vec3& place = deviation.place_mm;
    if (tried.tries_at(place) >= TriedPlaces::kMaxTries) continue;
    const bool free =
        std::ranges::none_of(centres, [&](const Vec3& c) { return (c - place).norm() < apart_mm; });
    if (free) centres.push_back(place);
    if (centres.size() == kMaxCentres) break;
  }
  return centres;
}

std::size_t count_probes(const std::vector<Deviation>& deviations) {
  return static_cast<std::size_t>(
      std::ranges::count_if(deviations, [](const Deviation& m) { return !m.is_outlier; }));
}

/// Repairs defects in rounds.
class DefectRepair {
 public:
  DefectRepair(WholeMesh& whole, const FitSetting& setting)
      : whole_(whole),
        setting_(setting),
        edge_mm_(longest_edge_mm(whole.mesh)),
        part_mm_(std::max(kPart * setting.domain.voxel_size_mm(), edge_mm_)),
        tried_(kSame * setting.domain.voxel_size_mm()),
        work_left_(3 * whole.mesh.tets.size() / 2) {}

  /// One round. An easy repair may repair its neighbours too, so that the first round makes few tries.
  /// @return False if nothing was done, because nothing is left to do or more rounds would hardly help.
  bool repair(const std::vector<Deviation>& deviations) {
    if (work_left_ == 0 && dull_rounds_ >= 3) return false;
    const std::vector<Vec3> centres = choose_centres(deviations, tried_, 2 * part_mm_ + edge_mm_);
    if (centres.empty()) return false;
    const BoundaryTree tree(whole_.mesh, whole_.boundary, centres, part_mm_ + edge_mm_);
    const std::size_t share = work_left_ / centres.size();
    std::vector<Repaired> repaired(centres.size());
    parallel::for_each_index(centres.size(), 1,
                             [&](std::size_t i) { repaired[i] = repair_defect(tree, centres[i], share); });
    if (round_ > 0) note_tries(centres, repaired);
    ++round_;
    put_back_all(repaired);
    const bool promising =
        std::ranges::any_of(repaired, [](const Repaired& m) { return m.result.promising; });
    dull_rounds_ = promising ? 0 : dull_rounds_ + 1;
    return true;
  }

 private:
  struct Repaired {
    RepairResult result;
    std::optional<MeshPart> part;  // if it is better than what was there
    std::size_t work = 0;
  };

  [[nodiscard]] Repaired repair_defect(const BoundaryTree& tree, const Vec3& centre_mm,
                                       std::size_t share) const {
    const std::size_t made = tried_.tries_at(centre_mm);
    MeshPart part = cut_out(whole_, tree, centre_mm, part_mm_);
    SurroundingSurface surroundings(whole_, tree, part, setting_.domain);
    Defect defect(std::move(part), std::move(surroundings), centre_mm, setting_);
    const std::size_t cost = defect.cost();
    std::size_t max_tries = 1;
    if (round_ > 0) {
      const std::size_t affordable = std::max<std::size_t>(share / cost, work_left_ > 0 ? 1 : 0);
      max_tries = std::min(made + affordable, TriedPlaces::kMaxTries);
    }
    Repaired repaired;
    repaired.result = defect.repair(made, max_tries, round_);
    repaired.work = repaired.result.tries * cost;
    if (repaired.result.better) repaired.part = defect.take();
    return repaired;
  }

  void note_tries(const std::vector<Vec3>& centres, const std::vector<Repaired>& repaired) {
    for (std::size_t i = 0; i < centres.size(); ++i) {
      const RepairResult& result = repaired[i].result;
      work_left_ -= std::min(work_left_, repaired[i].work);
      const bool gives_up = result.stopped_early || work_left_ == 0;
      const std::size_t made = tried_.tries_at(centres[i]) + result.tries;
      tried_.set(centres[i], result.promising ? 0 : gives_up ? TriedPlaces::kMaxTries : made);
    }
  }

  /// No two parts with a common tetrahedron.
  void put_back_all(const std::vector<Repaired>& repaired) {
    std::vector<std::uint8_t> taken(whole_.mesh.tets.size(), 0);
    for (const Repaired& m : repaired) {
      if (!m.part) continue;
      const std::vector<std::uint32_t>& tets = m.part->tets;
      if (std::ranges::any_of(tets, [&](std::uint32_t t) { return taken[t] != 0; }))
        continue;  // its deviations are found again
      for (const std::uint32_t t : tets) taken[t] = 1;
      put_back(whole_, *m.part);
    }
    drop_gone_triangles(whole_);
    renew_stars(whole_);
  }

  WholeMesh& whole_;
  const FitSetting& setting_;
  double edge_mm_;
  double part_mm_;  // how far parts reach around their centres
  TriedPlaces tried_;
  // For tries after the first round; may be passed by one try for each defect of a round. Follows the size of
  // the mesh, so that time does too.
  std::size_t work_left_;
  unsigned round_ = 0;
  int dull_rounds_ = 0;  // in a row, that brought nothing
};

}  // namespace

std::vector<Deviation> repair_defects(WholeMesh& whole, const FitSetting& setting, DeviationFinder& finder,
                                      std::size_t probes) {
  constexpr int kRounds = 16;
  const double limit_mm = kMaxDeviation * setting.domain.voxel_size_mm();
  const std::size_t too_many = std::max<std::size_t>(100, probes / 100);
  DefectRepair repair(whole, setting);
  std::vector<Deviation> deviations = finder.find(whole.mesh, whole.boundary, limit_mm, too_many);
  for (int round = 0; round < kRounds; ++round) {
    if (count_probes(deviations) > too_many) break;  // the lattice is too coarse to come close everywhere
    if (!repair.repair(deviations)) break;
    deviations = finder.find(whole.mesh, whole.boundary, limit_mm, too_many);
  }
  drop_gone(whole);
  return deviations;
}

}  // namespace lumesh::fitting
