#include "refinement.hpp"

#include <Eigen/LU>
#include <cmath>

#include "lumesh/core/error.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/field/label_field.hpp"
#include "lumesh/parallel/key_set.hpp"
#include "lumesh/parallel/loops.hpp"
#include "split_marks.hpp"

namespace lumesh {

namespace {

using bcc::Corners;
using bcc::Key;

Key pack(const Index3& p) {
  return bcc::pack(static_cast<std::uint32_t>(p.x()), static_cast<std::uint32_t>(p.y()),
                   static_cast<std::uint32_t>(p.z()));
}

/// Findings for the last few lattice points: neighbouring tetrahedra share corners.
class PointMemo {
 public:
  PointMemo() { keys_.fill(parallel::KeySet::kEmpty); }
  template <class Find>
  bool get(Key key, const Find& find) {
    constexpr Key kSpread = 0x9e3779b97f4a7c15ULL;
    const std::size_t at = key * kSpread >> (64 - kBits);
    if (keys_[at] != key) {
      found_[at] = find(key);
      keys_[at] = key;
    }
    return found_[at];
  }

 private:
  static constexpr int kBits = 5;
  std::array<Key, std::size_t{1} << kBits> keys_;
  std::array<bool, std::size_t{1} << kBits> found_{};
};

/// Grows the set of leaves level by level, then closes it: see algorithms in bcc.hpp.
class Refiner {
 public:
  Refiner(const LatticeFrame& frame, const ImageDomain& domain, const SizeGrid& sizes)
      : frame_(frame),
        domain_(domain),
        sizes_(sizes),
        leaves_(static_cast<std::size_t>(frame.levels) + 1),
        masks_(leaves_.size()),
        cubes_(leaves_.size()),
        marks_(frame) {}

  bcc::Lattice run() {
    add_coarse_tetrahedra();
    for (int level = 0; level < frame_.levels; ++level) {
      const auto wanting =
          pick(leaves_[at(level)], [&](const Corners& t) { return wants_children(t, level); });
      split(level, wanting);
    }
    for (std::size_t l = 0; l < leaves_.size(); ++l) masks_[l].resize(leaves_[l].size(), 0);
    while (close_once()) {
    }
    return emit();
  }

 private:
  void add_coarse_tetrahedra() {
    parallel::collect_blocks_into<Corners>(
        leaves_[0], grid_count(frame_.cells), 512,
        [&](std::size_t begin, std::size_t end, std::vector<Corners>& out) {
          for (std::size_t c = begin; c < end; ++c) append_coarse_tetrahedra(c, out);
        });
  }

  /// Appends the tetrahedra at the upper faces of a cube.
  void append_coarse_tetrahedra(std::size_t cube, std::vector<Corners>& out) const {
    const auto nx = static_cast<std::size_t>(frame_.cells.x());
    const auto ny = static_cast<std::size_t>(frame_.cells.y());
    const Index3 cell(static_cast<int>(cube % nx), static_cast<int>(cube / nx % ny),
                      static_cast<int>(cube / (nx * ny)));
    const int s = frame_.step(0);
    const Index3 centre = 2 * s * cell + Index3::Constant(s);
    if (!near_object(centre, 3 * s) || far_in_background(centre)) return;
    PointMemo memo;
    for (int axis = 0; axis < 3; ++axis) {
      if (cell[axis] + 1 == frame_.cells[axis]) continue;
      append_face_tetrahedra(centre, axis, s, memo, out);
    }
  }

  /// The four tetrahedra that straddle the face between a cube and the next one along an axis.
  void append_face_tetrahedra(const Index3& centre, int axis, int s, PointMemo& memo,
                              std::vector<Corners>& out) const {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    Index3 next = centre;
    next[axis] += 2 * s;
    // Face corners anticlockwise seen from the next cube.
    std::array<Index3, 4> ring;
    constexpr int kTurn[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (std::size_t i = 0; i < 4; ++i) {
      ring[i] = centre;
      ring[i][axis] += s;
      ring[i][u] += kTurn[i][0] * s;
      ring[i][v] += kTurn[i][1] * s;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      const Corners t = {pack(centre), pack(next), pack(ring[i]), pack(ring[(i + 1) % 4])};
      if (!far_outside(t, 0, memo)) out.push_back(t);
    }
  }

  /// Whether the box within `half_size` of a lattice point, and a margin for one more ring of tetrahedra,
  /// which the choice of the boundary looks at, may hold a part of the object.
  bool near_object(const Index3& centre, int half_size) const {
    const ImageFrame& image = domain_.frame();
    const Vec3 at = image.to_index(frame_.position_mm(pack(centre)));
    // The lattice lies along the image's axes.
    const Vec3 reach = Vec3::Ones() + (frame_.unit_mm * half_size + 0.75 * frame_.spacing_mm(0)) *
                                          image.spacing_mm.cwiseInverse();
    return domain_.field().may_hold_object(at - reach, at + reach);
  }

  /// Whether far_outside() holds for all tetrahedra at the faces of a cube, which is quicker to say.
  bool far_in_background(const Index3& centre) const {
    constexpr double kReach =
        1.71;  // spacings: the way from here to the centre of one of them, and from there
    const Vec3 at = frame_.position_mm(pack(centre));
    return domain_.material_at(at) == 0 && !sizes_.boundary_within(at, kReach * frame_.spacing_mm(0));
  }

  bool wants_children(const Corners& t, int level) const {
    Vec3 centre = Vec3::Zero();
    for (const Key key : t) centre += 0.25 * frame_.position_mm(key);
    return sizes_.level_wanted(centre, kRefinementReach * frame_.spacing_mm(level)) > level;
  }

  /// Leaves that were split stay in their list, without a first corner.
  static bool is_gone(const Corners& leaf) { return leaf[0] == parallel::KeySet::kEmpty; }

  static std::size_t at(int level) { return static_cast<std::size_t>(level); }

  template <class Chosen>
  static std::vector<std::uint32_t> pick(const bcc::Lattice& leaves, const Chosen& chosen) {
    return parallel::collect<std::uint32_t>(leaves.size(), 512, [&](std::size_t i, auto& out) {
      if (chosen(leaves[i])) out.push_back(static_cast<std::uint32_t>(i));
    });
  }

  /// Replaces the picked leaves of a level (ascending) by their children, but for those far outside the
  /// object.
  void split(int level, const std::vector<std::uint32_t>& picked) {
    if (picked.empty()) return;
    bcc::Lattice& from = leaves_[at(level)];
    split_.insert_all(picked.size(), 2 * picked.size(), [&](std::size_t i, auto& put) {
      const Corners& t = from[picked[i]];
      for (const auto& [a, b] : kTetEdges) put(bcc::midpoint(t[a], t[b]));
    });
    parallel::collect_blocks_into<Corners>(
        leaves_[at(level) + 1], picked.size(), 256,
        [&](std::size_t begin, std::size_t end, std::vector<Corners>& out) {
          for (std::size_t i = begin; i < end; ++i) append_children(from[picked[i]], level, out);
        });
    for (const std::uint32_t i : picked) {
      marks_.note(middle_of(from[i]), level);
      from[i][0] = parallel::KeySet::kEmpty;
    }
  }

  void append_children(const Corners& t, int level, std::vector<Corners>& out) const {
    PointMemo memo;
    for (const Corners& child : bcc::red_children(t)) {
      if (!far_outside(child, level + 1, memo)) out.push_back(child);
    }
  }

  /// Tetrahedra that neither belong to the object nor touch one that does are never looked at again.
  bool far_outside(const Corners& t, int level, PointMemo& memo) const {
    Vec3 centre = Vec3::Zero();
    for (const Key key : t) centre += 0.25 * frame_.position_mm(key);
    constexpr double kReach =
        1.15;  // spacings: two circumradii, the way to the centre of a tetrahedron that shares a corner
    const double reach_mm = kReach * frame_.spacing_mm(level);
    const ImageDomain::Surroundings here = domain_.surroundings(centre);
    if (domain_.is_meshed(here.material)) return false;
    // Cut planes are boundaries too, but not of the voxels; beyond one the clearance is the distance to it.
    if (domain_.is_cut(here.material) && here.clearance_mm < reach_mm) return false;
    if (!sizes_.boundary_within(centre, reach_mm)) return true;
    const auto near = [&](Key corner) {
      return memo.get(corner, [&](Key key) { return near_inside(key, level); });
    };
    return std::ranges::none_of(t, near);
  }

  /// Whether a corner may belong to a tetrahedron of the object: the nearest of the places that decide on its
  /// label (labelled_lattice.cpp) is hardly ever further away than this.
  bool near_inside(Key corner, int level) const {
    constexpr double kReach = 0.6;  // spacings
    const ImageDomain::Surroundings here = domain_.surroundings(frame_.position_mm(corner));
    return domain_.is_meshed(here.material) || here.clearance_mm < kReach * frame_.spacing_mm(level);
  }

  static Key middle_of(const Corners& leaf) { return bcc::midpoint(leaf[0], leaf[1]); }

  static unsigned split_edges(const Corners& t, parallel::KeySet::Lookup& split) {
    std::array<Key, 6> middle;
    for (std::size_t e = 0; e < 6; ++e) {
      middle[e] = bcc::midpoint(t[kTetEdges[e][0]], t[kTetEdges[e][1]]);
      split.prefetch(middle[e]);
    }
    unsigned mask = 0;
    for (std::size_t e = 0; e < 6; ++e) mask |= (split.contains(middle[e]) ? 1U : 0U) << e;
    return mask;
  }

  /// A green element must not touch anything two levels finer: no half of a split edge, and no edge between
  /// the midpoints on one face, may be split again.
  bool split_twice(const Corners& t, unsigned mask) const {
    std::array<Key, 6> middle;
    for (std::size_t e = 0; e < 6; ++e) {
      if ((mask >> e & 1U) == 0) continue;
      const auto [a, b] = kTetEdges[e];
      middle[e] = bcc::midpoint(t[a], t[b]);
      if (is_split(t[a], middle[e]) || is_split(middle[e], t[b])) return true;
    }
    for (const auto& face : bcc::kFaceEdges) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t e = face[i];
        const std::size_t f = face[(i + 1) % 3];
        if ((mask >> e & 1U) != 0 && (mask >> f & 1U) != 0 && is_split(middle[e], middle[f])) return true;
      }
    }
    return false;
  }

  /// Only edges whose ends have an even sum have a midpoint in whole numbers; finer ones are never split.
  bool is_split(Key a, Key b) const {
    constexpr Key kOdd = bcc::pack(1, 1, 1);
    return ((a ^ b) & kOdd) == 0 && split_.contains(bcc::midpoint(a, b));
  }

  /// A leaf that cannot stay as it is: its third edge must be split, or (no third edge) it becomes red.
  struct Finding {
    std::uint32_t leaf = 0;
    Key third = parallel::KeySet::kEmpty;
  };
  std::vector<Finding> find_open_leaves(int level) {
    const bcc::Lattice& leaves = leaves_[at(level)];
    std::vector<std::uint8_t>& masks = masks_[at(level)];
    std::vector<std::uint32_t>& cubes = cubes_[at(level)];
    const std::size_t seen = masks.size();  // what follows was born in the last sweep
    const std::size_t placed = cubes.size();
    masks.resize(leaves.size(), 0);
    cubes.resize(leaves.size());
    return parallel::collect_blocks<Finding>(
        leaves.size(), 512, [&](std::size_t begin, std::size_t end, std::vector<Finding>& out) {
          parallel::KeySet::Lookup split(split_);
          for (std::size_t i = begin; i < end; ++i) {
            const Corners& t = leaves[i];
            if (i >= placed && !is_gone(t)) cubes[i] = marks_.cube_of(middle_of(t), level);
            if ((i < seen && !marks_.is_marked(cubes[i], level)) || is_gone(t)) continue;
            const unsigned mask = split_edges(t, split);
            masks[i] = static_cast<std::uint8_t>(mask);
            const bool finer_near = marks_.ever_marked(cubes[i], level, level + 1);
            if (mask != 0) append_if_open(static_cast<std::uint32_t>(i), t, mask, finer_near, out);
          }
        });
  }

  /// @param finer_near  Whether split_twice() may hold.
  void append_if_open(std::uint32_t leaf, const Corners& t, unsigned mask, bool finer_near,
                      std::vector<Finding>& out) const {
    const bcc::Closure closure = bcc::closure_of(mask);
    if (closure == bcc::Closure::kRed || (finer_near && split_twice(t, mask))) {
      out.push_back({leaf, parallel::KeySet::kEmpty});
    } else if (closure == bcc::Closure::kSplitThird) {
      const auto [a, b] = kTetEdges[bcc::third_edge(mask)];
      out.push_back({leaf, bcc::midpoint(t[a], t[b])});
    }
  }

  /// One sweep of the closure rules from fine to coarse, where something changed; false when nothing changed.
  bool close_once() {
    marks_.renew();
    bool changed = false;
    for (int level = frame_.levels - 1; level >= 0; --level) {
      const auto findings = find_open_leaves(level);
      std::vector<std::uint32_t> red;
      for (const Finding& f : findings) {
        if (f.third == parallel::KeySet::kEmpty) {
          red.push_back(f.leaf);
        } else if (split_.insert(f.third)) {
          marks_.note(f.third, level);
        }
      }
      split(level, red);
      changed |= !findings.empty();
    }
    return changed;
  }

  bcc::Lattice emit() {
    bcc::Lattice all;
    std::size_t count = 0;
    for (const bcc::Lattice& leaves : leaves_) count += leaves.size();
    all.reserve(count + count / 4);  // green children
    for (std::size_t level = 0; level < leaves_.size(); ++level) {
      masks_[level].resize(leaves_[level].size(), 0);
      parallel::collect_blocks_into<Corners>(
          all, leaves_[level].size(), 4096,
          [&](std::size_t begin, std::size_t end, std::vector<Corners>& out) {
            for (std::size_t i = begin; i < end; ++i) emit_leaf(leaves_[level][i], masks_[level][i], out);
          });
      leaves_[level] = bcc::Lattice();  // = {} would keep the memory
    }
    return all;
  }

  static void emit_leaf(const Corners& leaf, unsigned mask, std::vector<Corners>& out) {
    if (is_gone(leaf)) return;
    if (mask == 0) {
      out.push_back(leaf);
      return;
    }
    const bcc::GreenChildren children = bcc::green_children(leaf, mask);
    out.insert(out.end(), children.items.begin(),
               children.items.begin() + static_cast<std::ptrdiff_t>(children.count));
  }

  const LatticeFrame& frame_;
  const ImageDomain& domain_;
  const SizeGrid& sizes_;
  std::vector<bcc::Lattice> leaves_;  // per level
  std::vector<std::vector<std::uint8_t>>
      masks_;               // per level and leaf: edges that were split when last looked at
  parallel::KeySet split_;  // midpoints of split edges
  std::vector<std::vector<std::uint32_t>> cubes_;  // per level and leaf: where its marks are
  SplitMarks marks_;
};

}  // namespace

LatticeFrame make_lattice_frame(const ImageDomain& domain, double coarsest_mm, int levels) {
  const ImageFrame& image = domain.frame();
  LatticeFrame frame;
  frame.levels = levels;
  frame.unit_mm = coarsest_mm / (2 * frame.step(0));
  frame.axes = image.direction;
  const auto& [low, end] = domain.object_box();
  // The box of the voxels in mm along the image's axes, and one cube more on each side.
  const Vec3 extent = (end - low).cast<double>().cwiseProduct(image.spacing_mm);
  Vec3 corner = low.cast<double>() - Vec3::Constant(0.5);
  if (frame.axes.determinant() < 0) {  // mirror the third axis to get a proper rotation
    frame.axes.col(2) = -frame.axes.col(2);
    corner.z() = end.z() - 0.5;
  }
  for (int axis = 0; axis < 3; ++axis) {
    frame.cells[axis] = static_cast<int>(std::min(1e8, std::ceil(extent[axis] / coarsest_mm))) + 3;
  }
  if ((frame.cells.cast<double>() * (2.0 * frame.step(0))).maxCoeff() >= 1 << (bcc::kBits - 1))
    throw Error(ErrorKind::kMemory,
                "the lattice spacing is too small for the size of the object; choose a larger `edge_length`");
  const Vec3 spare = frame.cells.cast<double>() * coarsest_mm - extent;
  frame.origin_mm = image.to_physical(corner) - frame.axes * (0.5 * spare);
  return frame;
}

bcc::Lattice refined_lattice(const LatticeFrame& frame, const ImageDomain& domain, const SizeGrid& sizes) {
  return Refiner(frame, domain, sizes).run();
}

}  // namespace lumesh
