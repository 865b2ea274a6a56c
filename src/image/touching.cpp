#include "lumesh/image/touching.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <unordered_map>

#include "lumesh/core/disjoint_sets.hpp"
#include "lumesh/core/grid.hpp"
#include "lumesh/parallel/key_table.hpp"
#include "lumesh/parallel/loops.hpp"
#include "vessel_chunks.hpp"
#include "voxel_edits.hpp"

namespace lumesh {

namespace {

using image::ChunkFace;
using image::kNoChunk;
using image::VesselChunks;

constexpr float kThinHalfWidth = 1.42F;  // Of one or two voxels, also along diagonals.
constexpr float kThicker = 2;

/// A face, or a voxel between, at which vessels touch or nearly do.
struct ContactElement {
  std::uint32_t voxel = 0, other = 0;  ///< The same for a voxel between.
  std::uint32_t first = 0, second = 0;
  bool is_neck = false;  ///< Its chunks meet at a neck, and not only chunks around them.

  [[nodiscard]] bool is_face() const { return voxel != other; }
};

/// Calls use(place) for the voxels around one, and itself.
template <class Use>
void for_each_around(const Index3& place, int reach, const Use& use) {
  for_each_place(place - Index3::Constant(reach), place + Index3::Constant(reach), use);
}

using Pair = std::pair<std::uint32_t, std::uint32_t>;

/// Answers for pairs of chunks between which there is background, each of which is asked for many times.
class PairsApart {
 public:
  explicit PairsApart(const VesselChunks& chunks) : chunks_(chunks) {}
  bool pass(const Pair& pair, const Index3& place) {
    const auto [at, is_new] = known_.emplace(pair, false);
    if (is_new)
      at->second = chunks_.are_apart(pair.first, pair.second) &&
                   chunks_.narrows_between(pair.first, pair.second) &&
                   chunks_.passing_sides(pair.first, pair.second, place.cast<double>()).has_value();
    return at->second;
  }

 private:
  const VesselChunks& chunks_;
  std::map<Pair, bool> known_;
};

bool is_of_pair(const ChunkFace& a, const ChunkFace& b) {
  return a.first == b.first && a.second == b.second;
}

/// Pairs of chunks of vessels that touch: those at a neck, and all others of the same two vessels around it.
std::set<Pair> touching_pairs(const VesselChunks& chunks) {
  std::set<Pair> pairs;
  parallel::for_each_run(chunks.faces(), is_of_pair, [&](std::span<const ChunkFace> faces) {
    const ChunkFace& middle = faces[faces.size() / 2];
    const bool is_neck = chunks.is_neck(middle.first, middle.second);
    if (!is_neck && !chunks.hang_by_thread(middle.first, middle.second)) return;
    if (!chunks.narrows_between(middle.first, middle.second)) return;
    const auto sides =
        chunks.passing_sides(middle.first, middle.second, chunks.place_of(middle.voxel).cast<double>());
    if (!sides) return;
    pairs.emplace(middle.first, middle.second);
    if (!is_neck) return;
    for (const std::uint32_t a : (*sides)[0])
      for (const std::uint32_t b : (*sides)[1]) pairs.emplace(std::min(a, b), std::max(a, b));
  });
  return pairs;
}

/// The first chunk that a place has beside it, through faces or also edges, and that is_wanted(chunk).
template <class IsWanted>
std::uint32_t chunk_beside(const VesselChunks& chunks, const Index3& place, int max_squared,
                           const IsWanted& is_wanted) {
  std::uint32_t found = kNoChunk;
  for_each_around(place, 1, [&](const Index3& near) {
    if (found != kNoChunk || (near - place).squaredNorm() > max_squared || !chunks.contains(near)) return;
    const std::uint32_t chunk = chunks.chunk_of(chunks.offset(near));
    if (chunk != kNoChunk && is_wanted(chunk)) found = chunk;
  });
  return found;
}

/// Background with a chunk beside a face, and another one beside a face or an edge.
std::vector<std::uint32_t> voxels_between(const VesselChunks& chunks) {
  return parallel::collect_blocks<std::uint32_t>(
      chunks.voxel_count(), std::size_t{1} << 16,
      [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& out) {
        for (std::size_t v = begin; v < end; ++v) {
          if (chunks.chunk_of(v) != kNoChunk || !chunks.is_beside(v)) continue;
          const Index3 place = chunks.place_of(v);
          const std::uint32_t first = chunk_beside(chunks, place, 1, [](std::uint32_t) { return true; });
          if (chunk_beside(chunks, place, 2, [&](std::uint32_t b) { return b != first; }) != kNoChunk)
            out.push_back(static_cast<std::uint32_t>(v));
        }
      });
}

/// Background between two chunks: beside a face of the one and an edge of the other.
void add_voxels_between(const VesselChunks& chunks, std::vector<ContactElement>& elements) {
  PairsApart pairs(chunks);
  for (const std::uint32_t v : voxels_between(chunks)) {
    const Index3 place = chunks.place_of(v);
    std::uint32_t second = kNoChunk;
    const std::uint32_t first = chunk_beside(chunks, place, 1, [&](std::uint32_t a) {
      second = chunk_beside(chunks, place, 2, [&](std::uint32_t b) {
        return a != b && pairs.pass({std::min(a, b), std::max(a, b)}, place);
      });
      return second != kNoChunk;
    });
    if (first != kNoChunk) elements.push_back({v, v, first, second, false});
  }
}

/// @param pairs  touching_pairs().
std::vector<ContactElement> contacts_of(const VesselChunks& chunks, const std::set<Pair>& pairs) {
  std::vector<ContactElement> elements;
  for (const ChunkFace& face : chunks.faces())
    if (pairs.contains({face.first, face.second}))
      elements.push_back(
          {face.voxel, face.other, face.first, face.second, chunks.is_neck(face.first, face.second)});
  add_voxels_between(chunks, elements);
  return elements;
}

/// Elements within two voxels of each other are one place.
std::vector<std::vector<std::size_t>> grouped(const VesselChunks& chunks,
                                              const std::vector<ContactElement>& elements) {
  std::unordered_map<std::size_t, std::size_t> element_at;
  DisjointSets sets(elements.size());
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const auto [at, is_new] = element_at.emplace(elements[e].voxel, e);
    if (!is_new) sets.merge(static_cast<std::uint32_t>(at->second), static_cast<std::uint32_t>(e));
  }
  for (std::size_t e = 0; e < elements.size(); ++e)
    for_each_around(chunks.place_of(elements[e].voxel), 2, [&](const Index3& near) {
      if (!chunks.contains(near)) return;
      if (const auto found = element_at.find(chunks.offset(near)); found != element_at.end())
        sets.merge(static_cast<std::uint32_t>(found->second), static_cast<std::uint32_t>(e));
    });
  std::map<std::uint32_t, std::vector<std::size_t>> by_root;
  for (std::size_t e = 0; e < elements.size(); ++e)
    by_root[sets.find(static_cast<std::uint32_t>(e))].push_back(e);
  std::vector<std::vector<std::size_t>> groups;
  for (auto& [root, members] : by_root) groups.push_back(std::move(members));
  return groups;
}

ThinPlace place_of_group(const VesselChunks& chunks, const std::vector<ContactElement>& elements,
                         const std::vector<std::size_t>& group) {
  ThinPlace place{ThinPlace::Kind::kNear};
  for (const std::size_t e : group)
    if (elements[e].is_face()) {
      place.kind = ThinPlace::Kind::kTouching;
      ++place.size;
    }
  if (place.size == 0) place.size = group.size();
  // In the middle of the necks: faces of other chunks of the two vessels may lie within one of them.
  const auto rank = [&](std::size_t e) {
    return (elements[e].is_face() ? 1 : 0) + (elements[e].is_neck ? 1 : 0);
  };
  int most = 0;
  for (const std::size_t e : group) most = std::max(most, rank(e));
  std::vector<std::size_t> best;
  std::copy_if(group.begin(), group.end(), std::back_inserter(best),
               [&](std::size_t e) { return rank(e) == most; });
  const auto at = [&](std::size_t e) { return Vec3(chunks.place_of(elements[e].voxel).cast<double>()); };
  Vec3 middle = Vec3::Zero();
  for (const std::size_t e : best) middle += at(e) / static_cast<double>(best.size());
  const auto nearest = std::ranges::min_element(
      best, [&](std::size_t a, std::size_t b) { return (at(a) - middle).norm() < (at(b) - middle).norm(); });
  place.voxel = chunks.low() + chunks.place_of(elements[*nearest].voxel);
  return place;
}

/// Necks, and chunks, of one or two voxels between thicker parts that do not pass each other.
std::vector<ThinPlace> bridges_of(const VesselChunks& chunks, const std::set<Pair>& touching) {
  std::vector<ThinPlace> places;
  const auto is_thicker = [&](std::uint32_t chunk, float than) {
    return chunks.chunks()[chunk].half_width >= kThicker * than;
  };
  const auto& all = chunks.faces();
  parallel::for_each_run(all, is_of_pair, [&](std::span<const ChunkFace> faces) {
    const ChunkFace& middle = faces[faces.size() / 2];
    const float width = chunks.saddle(middle.first, middle.second);
    if (width <= kThinHalfWidth && is_thicker(middle.first, width) && is_thicker(middle.second, width) &&
        chunks.is_neck(middle.first, middle.second) && !touching.contains({middle.first, middle.second}))
      places.push_back(
          {ThinPlace::Kind::kBridge, chunks.low() + chunks.place_of(middle.voxel), faces.size()});
  });
  const auto is_thin = [&](std::uint32_t c) { return chunks.chunks()[c].half_width <= kThinHalfWidth; };
  DisjointSets strands(chunks.chunks().size());
  for (const auto& face : all)
    if (is_thin(face.first) && is_thin(face.second)) strands.merge(face.first, face.second);
  std::map<std::uint32_t, std::set<std::uint32_t>> thick_beside;
  for (const auto& face : all) {
    if (is_thin(face.first) && is_thicker(face.second, chunks.chunks()[face.first].half_width))
      thick_beside[strands.find(face.first)].insert(face.second);
    if (is_thin(face.second) && is_thicker(face.first, chunks.chunks()[face.second].half_width))
      thick_beside[strands.find(face.second)].insert(face.first);
  }
  const auto joins_any = [&](const std::set<std::uint32_t>& thick) {
    return std::ranges::any_of(thick, [&](std::uint32_t a) {
      return std::ranges::any_of(thick, [&](std::uint32_t b) { return a < b && chunks.saddle(a, b) == 0; });
    });
  };
  for (const auto& [strand, thick] : thick_beside) {
    if (joins_any(thick))
      places.push_back({ThinPlace::Kind::kBridge, chunks.low() + chunks.chunks()[strand].seed, 1});
  }
  return places;
}

/// Removes what the vessels still have in common around the faces, edges and corners: the boundary between
/// them would be joined there again. The thicker one gives way.
void separate_at_edges(const VesselChunks& chunks, const std::vector<ContactElement>& elements,
                       std::set<std::size_t>& gone) {
  const auto is_of = [&](const Index3& place, std::uint32_t chunk) {
    return chunks.contains(place) && chunks.chunk_of(chunks.offset(place)) == chunk &&
           !chunks.is_filled(chunks.offset(place)) && !gone.contains(chunks.offset(place));
  };
  for (const ContactElement& e : elements) {
    if (!e.is_face() || chunks.is_filled(e.voxel) || chunks.is_filled(e.other)) continue;
    const bool is_first = chunks.chunks()[e.first].half_width >= chunks.chunks()[e.second].half_width;
    const std::uint32_t thicker = is_first ? e.first : e.second, thinner = is_first ? e.second : e.first;
    for_each_around(chunks.place_of(e.voxel), 1, [&](const Index3& place) {
      if (!is_of(place, thicker)) return;
      bool touches = false;
      for_each_around(place, 1, [&](const Index3& near) { touches |= is_of(near, thinner); });
      if (touches) gone.insert(chunks.offset(place));
    });
  }
}

/// Removes one voxel at each face, the one nearer to the background, unless the other is gone already. Where
/// vessels share a broad area their smooth walls would meet again between layers one voxel apart: there both
/// voxels go; in vessels that are too thin for it, that of the thicker one.
void separate(const VesselChunks& chunks, const std::vector<ContactElement>& elements,
              std::set<std::size_t>& gone) {
  constexpr int kBroad = 7, kAround = 27;  // Faces within a voxel; a strip two faces broad has six.
  constexpr float kTooThin = 2.6F;         // Half widths of vessels that would be cut through.
  std::unordered_map<std::uint32_t, int> faces_of;
  for (const ContactElement& e : elements)
    if (e.is_face()) ++faces_of[e.voxel], ++faces_of[e.other];
  const auto half_width = [&](std::size_t voxel) {
    return chunks.chunks()[chunks.chunk_of(voxel)].half_width;
  };
  const auto is_broad = [&](const ContactElement& e) {
    int count = 0, places = 0;
    for_each_around(chunks.place_of(e.voxel), 1, [&](const Index3& near) {
      if (!chunks.contains(near)) return;
      ++places;
      const auto found = faces_of.find(static_cast<std::uint32_t>(chunks.offset(near)));
      if (found != faces_of.end() && chunks.chunk_of(chunks.offset(near)) == e.first) count += found->second;
    });
    return kAround * count >= kBroad * places;
  };
  for (const ContactElement& e : elements) {
    if (chunks.is_filled(e.voxel) || chunks.is_filled(e.other) || !e.is_face()) continue;
    const bool is_apart = gone.contains(e.voxel) || gone.contains(e.other);
    if (!is_broad(e)) {
      if (!is_apart) gone.insert(faces_of[e.other] > faces_of[e.voxel] ? e.other : e.voxel);
    } else if (std::min(half_width(e.voxel), half_width(e.other)) > kTooThin) {
      gone.insert({e.voxel, e.other});
    } else if (!is_apart) {
      gone.insert(half_width(e.voxel) > half_width(e.other) ? e.voxel : e.other);
    }
  }
}

/// Background around contacts that has both vessels within two voxels.
void join(const VesselChunks& chunks, const std::vector<ContactElement>& elements,
          std::set<std::size_t>& filled) {
  for (const ContactElement& e : elements)
    for_each_around(chunks.place_of(e.voxel), 1, [&](const Index3& place) {
      if (!chunks.contains(place) || chunks.chunk_of(chunks.offset(place)) != kNoChunk) return;
      bool has_first = false, has_second = false;
      for_each_around(place, 2, [&](const Index3& near) {
        constexpr int kMaxSquared = 5;
        if (!chunks.contains(near) || (near - place).squaredNorm() > kMaxSquared) return;
        has_first |= chunks.chunk_of(chunks.offset(near)) == e.first;
        has_second |= chunks.chunk_of(chunks.offset(near)) == e.second;
      });
      if (has_first && has_second) filled.insert(chunks.offset(place));
    });
}

/// Removes specks that a cut leaves alone between the vessels.
void drop_specks(const std::set<std::size_t>& cut, LabelImage& image, VoxelsChanged& changed) {
  constexpr std::size_t kSpeck = 27;
  for (const VoxelComponent& piece : small_components(image, kSpeck, ComponentScope::kUnion)) {
    bool is_cut_off = false;
    for_each_around(piece.first, 1, [&](const Index3& near) {
      is_cut_off |= image.frame().contains(near) && cut.contains(image.frame().offset(near));
    });
    if (is_cut_off) image::drop_component(piece.first, image, changed);
  }
}

/// Separates or joins what touches, in rounds.
VoxelsChanged change_contacts(bool separates, LabelImage& image) {
  constexpr int kMaxRounds = 4;  // The second one finds what bumps hid in the first.
  VoxelsChanged changed;
  std::set<std::size_t> cut;
  for (int round = 0; round < kMaxRounds; ++round) {
    const VesselChunks chunks(image);
    const std::vector<ContactElement> elements = contacts_of(chunks, touching_pairs(chunks));
    std::set<std::size_t> found;
    if (separates) {
      separate(chunks, elements, found);
      if (round == 0) separate_at_edges(chunks, elements, found);
    } else {
      join(chunks, elements, found);
    }
    if (found.empty()) break;
    if (round == 0) changed.places = grouped(chunks, elements).size();
    const std::vector<LabelImage::Index> before = image.voxels();
    for (const std::size_t in_box : found) {
      const Index3 place = chunks.low() + chunks.place_of(in_box);
      image.at(place) = separates ? LabelImage::Index{0} : image::label_around(image, before, place);
      image::note_change(image, place, changed);
      cut.insert(image.frame().offset(place));
    }
    if (!separates && round > 0) break;
  }
  if (separates) drop_specks(cut, image, changed);
  return changed;
}

}  // namespace

VoxelsChanged separate_touching(LabelImage& image) {
  return change_contacts(true, image);
}

VoxelsChanged join_touching(LabelImage& image) {
  return change_contacts(false, image);
}

std::vector<ThinPlace> find_thin_places(const LabelImage& image) {
  const VesselChunks chunks(image);
  const std::set<Pair> touching = touching_pairs(chunks);
  const std::vector<ContactElement> elements = contacts_of(chunks, touching);
  std::vector<ThinPlace> places;
  for (const std::vector<std::size_t>& group : grouped(chunks, elements))
    places.push_back(place_of_group(chunks, elements, group));
  for (const ThinPlace& bridge : bridges_of(chunks, touching)) places.push_back(bridge);
  std::ranges::stable_sort(places, [](const ThinPlace& a, const ThinPlace& b) {
    return a.kind != b.kind ? a.kind < b.kind : a.size > b.size;
  });
  return places;
}

}  // namespace lumesh
