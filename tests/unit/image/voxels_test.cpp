// Topology, selection and distance transform of voxels, against values known by hand and by brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lumesh/core/error.hpp"
#include "lumesh/image/distance.hpp"
#include "lumesh/image/selection.hpp"
#include "lumesh/image/topology.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh {
namespace {

LabelImage make_image(const Index3& size, std::vector<Label> values, const auto& index_of) {
  ImageFrame frame;
  frame.size = size;
  LabelImage image(frame, std::move(values));
  for (int k = 0; k < size.z(); ++k)
    for (int j = 0; j < size.y(); ++j)
      for (int i = 0; i < size.x(); ++i)
        image.at({i, j, k}) = static_cast<LabelImage::Index>(index_of(Vec3(i, j, k)));
  return image;
}

const Vec3 kCentre(15.2, 14.7, 15.1);

/// Kong and Rosenfeld 1989, doi:10.1016/0734-189X(89)90147-3: components - tunnels + cavities.
TEST(Topology, BallTorusAndHollowBallHaveTheirTextbookEulerNumbers) {
  const LabelImage ball =
      make_image({31, 31, 31}, {0, 7}, [](const Vec3& p) { return (p - kCentre).norm() < 10; });
  const LabelImage hollow = make_image({31, 31, 31}, {0, 7}, [](const Vec3& p) {
    return (p - kCentre).norm() < 12 && (p - kCentre).norm() > 7;
  });
  const LabelImage torus = make_image({31, 31, 31}, {0, 7}, [](const Vec3& p) {
    const Vec3 d = p - kCentre;
    return std::hypot(std::hypot(d.x(), d.y()) - 9, d.z()) < 4;
  });
  EXPECT_EQ(label_topology(ball).at(0).euler_number, 1);
  EXPECT_EQ(label_topology(hollow).at(0).euler_number, 2);
  EXPECT_EQ(label_topology(torus).at(0).euler_number, 0);
  EXPECT_EQ(label_topology(ball).at(0).cavity_count, 0U);
  EXPECT_EQ(label_topology(hollow).at(0).cavity_count, 1U);
  EXPECT_EQ(label_topology(torus).at(0).cavity_count, 0U);
  EXPECT_EQ(label_topology(ball).at(0).handle_count(), 0);
  EXPECT_EQ(label_topology(hollow).at(0).handle_count(), 0);
  EXPECT_EQ(label_topology(torus).at(0).handle_count(), 1);
  for (const LabelImage* image : {&ball, &hollow, &torus}) {
    EXPECT_EQ(label_topology(*image).at(0).component_count, 1U);
    EXPECT_EQ(label_topology(*image).at(0).label, 7);
  }
}

TEST(Topology, VoxelsThatTouchAtAnEdgeOrCornerOnlyAreTwoComponents) {
  const LabelImage edge =
      make_image({4, 4, 4}, {0, 1}, [](const Vec3& p) { return p == Vec3(1, 1, 1) || p == Vec3(2, 2, 1); });
  const LabelImage corner =
      make_image({4, 4, 4}, {0, 1}, [](const Vec3& p) { return p == Vec3(1, 1, 1) || p == Vec3(2, 2, 2); });
  for (const LabelImage* image : {&edge, &corner}) {
    EXPECT_EQ(label_topology(*image).at(0).component_count, 2U);
    EXPECT_EQ(label_topology(*image).at(0).euler_number, 2);
  }
}

TEST(Topology, CountsVolumesAndBoxesArePerLabel) {
  LabelImage image = make_image({8, 6, 5}, {0, 3, 9}, [](const Vec3& p) {
    if (p.x() >= 1 && p.x() < 4 && p.y() == 2 && p.z() >= 1 && p.z() < 3) return 2;
    return p == Vec3(6, 5, 4) ? 1 : 0;
  });
  image.frame().spacing_mm = {0.5, 2, 3};
  const std::vector<LabelTopology> found = label_topology(image);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].label, 3);
  EXPECT_EQ(found[0].voxel_count, 1U);
  EXPECT_EQ(found[0].box.low, Index3(6, 5, 4));
  EXPECT_EQ(found[1].voxel_count, 6U);
  EXPECT_DOUBLE_EQ(found[1].volume_mm3, 18.0);
  EXPECT_EQ(found[1].box.low, Index3(1, 2, 1));
  EXPECT_EQ(found[1].box.high, Index3(4, 3, 3));
  EXPECT_EQ(union_topology(image).component_count, 2U);
  EXPECT_EQ(union_topology(image).voxel_count, 7U);
}

/// Euler number by counting every cell of the complex one by one, and components by flooding: slow, but
/// plain.
struct Plain {
  std::int64_t euler = 0;
  std::size_t components = 0;
};
Plain count_plainly(const LabelImage& image, const auto& same) {
  const ImageFrame& frame = image.frame();
  Plain result;
  std::vector<char> seen(frame.voxel_count(), 0);
  for (int k = 0; k < frame.size.z(); ++k)
    for (int j = 0; j < frame.size.y(); ++j)
      for (int i = 0; i < frame.size.x(); ++i) {
        const Index3 v(i, j, k);
        for (int dims = 0; dims < 8; ++dims) {  // cell spanned from v along the axes in `dims`
          bool full = true;
          for (int part = 0; part < 8; ++part) {
            if ((part & ~dims) != 0) continue;
            const Index3 w = v + Index3(part & 1, (part >> 1) & 1, part >> 2);
            full = full && frame.contains(w) && same(image.at(w));
          }
          if (full) result.euler += (dims == 0 || dims == 3 || dims == 5 || dims == 6) ? 1 : -1;
        }
        if (!same(image.at(v)) || seen[frame.offset(v)] != 0) continue;
        ++result.components;
        std::vector<Index3> stack = {v};
        seen[frame.offset(v)] = 1;
        while (!stack.empty()) {
          const Index3 at = stack.back();
          stack.pop_back();
          for (int side = 0; side < 6; ++side) {
            Index3 next = at;
            next[side / 2] += side % 2 == 0 ? 1 : -1;
            if (!frame.contains(next) || !same(image.at(next)) || seen[frame.offset(next)] != 0) continue;
            seen[frame.offset(next)] = 1;
            stack.push_back(next);
          }
        }
      }
  return result;
}

/// Pieces of what is not `same`, flooded through faces, edges and corners, that do not reach the margin of
/// one voxel around the image.
std::size_t count_cavities_plainly(const LabelImage& image, const auto& same) {
  const ImageFrame& frame = image.frame();
  ImageFrame padded;
  padded.size = frame.size + Index3::Constant(2);
  std::vector<char> seen(padded.voxel_count(), 0);
  const auto is_free = [&](const Index3& v) {
    const Index3 inner = v - Index3::Ones();
    return padded.contains(v) && seen[padded.offset(v)] == 0 &&
           !(frame.contains(inner) && same(image.at(inner)));
  };
  std::size_t pieces = 0;
  for (int k = 0; k < padded.size.z(); ++k)
    for (int j = 0; j < padded.size.y(); ++j)
      for (int i = 0; i < padded.size.x(); ++i) {
        if (!is_free({i, j, k})) continue;
        ++pieces;
        std::vector<Index3> stack = {{i, j, k}};
        seen[padded.offset(stack[0])] = 1;
        while (!stack.empty()) {
          const Index3 at = stack.back();
          stack.pop_back();
          for (int step = 0; step < 27; ++step) {
            const Index3 next = at + Index3(step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1);
            if (!is_free(next)) continue;
            seen[padded.offset(next)] = 1;
            stack.push_back(next);
          }
        }
      }
  return pieces - 1;  // The margin is one.
}

TEST(Topology, CavitiesAreClosedToCornersAndOpenAtTheBorderOfTheImage) {
  // A block of 5 x 5 x 5 with one voxel out of its middle, then with a way out through a corner.
  const auto with_holes = [](std::vector<Vec3> holes) {
    return make_image({7, 7, 7}, {0, 1}, [holes](const Vec3& p) {
      const bool block = (p.array() >= 1).all() && (p.array() <= 5).all();
      return block && std::find(holes.begin(), holes.end(), p) == holes.end();
    });
  };
  EXPECT_EQ(label_topology(with_holes({{3, 3, 3}})).at(0).cavity_count, 1U);
  EXPECT_EQ(label_topology(with_holes({{2, 2, 2}, {4, 4, 4}})).at(0).cavity_count, 2U);
  EXPECT_EQ(label_topology(with_holes({{2, 2, 2}, {3, 3, 3}})).at(0).cavity_count, 1U);
  EXPECT_EQ(label_topology(with_holes({{2, 2, 2}, {1, 1, 1}})).at(0).cavity_count, 0U);
  const LabelImage filled = make_image({3, 3, 3}, {0, 1, 2}, [](const Vec3& p) {
    return p == Vec3(1, 1, 1) ? 2 : p == Vec3(0, 0, 0) ? 0 : 1;
  });
  EXPECT_EQ(label_topology(filled).at(0).cavity_count, 0U);  // From corner to corner.
  EXPECT_EQ(union_topology(filled).cavity_count, 0U);
}

LabelImage random_image(std::uint32_t seed, const Index3& size, int labels) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> pick(0, labels);
  std::vector<Label> values;
  for (int l = 0; l <= labels; ++l) values.push_back(l * 5);
  return make_image(size, values, [&](const Vec3&) { return pick(random); });
}

TEST(Topology, AgreesWithPlainCountingOnRandomImages) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const LabelImage image = random_image(seed, {13, 9, 11}, 3);
    const std::vector<LabelTopology> found = label_topology(image);
    ASSERT_EQ(found.size(), 3U);
    for (int l = 1; l <= 3; ++l) {
      const Plain plain = count_plainly(image, [l](int index) { return index == l; });
      EXPECT_EQ(found[static_cast<std::size_t>(l - 1)].euler_number, plain.euler);
      EXPECT_EQ(found[static_cast<std::size_t>(l - 1)].component_count, plain.components);
      EXPECT_EQ(found[static_cast<std::size_t>(l - 1)].cavity_count,
                count_cavities_plainly(image, [l](int index) { return index == l; }));
    }
    const Plain all = count_plainly(image, [](int index) { return index != 0; });
    EXPECT_EQ(union_topology(image).euler_number, all.euler);
    EXPECT_EQ(union_topology(image).cavity_count,
              count_cavities_plainly(image, [](int index) { return index != 0; }));
    EXPECT_EQ(union_topology(image).component_count, all.components);
  }
}

TEST(Components, OnlyTheLargestOfEachLabelOrOfTheUnionStays) {
  // Along i: label 1 with 2 and 3 voxels, label 2 with 4 voxels touching the first piece of label 1.
  const std::vector<int> row = {1, 1, 2, 2, 2, 2, 0, 1, 1, 1, 0};
  const auto make = [&] {
    return make_image({11, 1, 1}, {0, 4, 6},
                      [&](const Vec3& p) { return row[static_cast<std::size_t>(p.x())]; });
  };
  LabelImage each = make();
  EXPECT_EQ(voxel_components(each, ComponentScope::kEachLabel).size(), 3U);
  EXPECT_EQ(small_components(each, 3, ComponentScope::kEachLabel).size(), 1U);
  EXPECT_EQ(keep_largest_component(each, ComponentScope::kEachLabel), 2U);
  EXPECT_EQ(each.label_at({0, 0, 0}), 0);
  EXPECT_EQ(each.label_at({2, 0, 0}), 6);
  EXPECT_EQ(each.label_at({8, 0, 0}), 4);
  LabelImage whole = make();
  EXPECT_EQ(voxel_components(whole, ComponentScope::kUnion).at(0).voxel_count, 6U);
  EXPECT_EQ(keep_largest_component(whole, ComponentScope::kUnion), 3U);
  EXPECT_EQ(whole.label_at({0, 0, 0}), 4);
  EXPECT_EQ(whole.label_at({8, 0, 0}), 0);
  LabelImage smaller = make();
  EXPECT_EQ(keep_component_of(smaller, {8, 0, 0}, ComponentScope::kUnion), 6U);
  EXPECT_EQ(smaller.label_at({0, 0, 0}), 0);
  EXPECT_EQ(smaller.label_at({9, 0, 0}), 4);
}

TEST(Selection, KeepsTheNamedLabelsAndForgetsTheOthers) {
  LabelImage image = make_image({4, 1, 1}, {0, 5, 8, 11}, [](const Vec3& p) { return p.x(); });
  select_labels(image, std::vector<Label>{11, 5});
  EXPECT_EQ(image.values(), (std::vector<Label>{0, 5, 11}));
  EXPECT_EQ(image.label_at({1, 0, 0}), 5);
  EXPECT_EQ(image.label_at({2, 0, 0}), 0);
  EXPECT_EQ(image.label_at({3, 0, 0}), 11);
}

TEST(Selection, AnAbsentLabelIsRefusedWithTheLabelsThatAreThere) {
  LabelImage image =
      make_image({4, 1, 1}, {0, 5, 8, 11}, [](const Vec3& p) { return p.x() == 3 ? 1 : p.x(); });
  for (const Label absent : {11, 6, 0, 400}) {
    try {
      select_labels(image, std::vector<Label>{5, absent});
      FAIL() << "label " << absent << " was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
      EXPECT_NE(std::string(error.what()).find("5, 8"), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(select_labels(image, {}), Error);
}

double plain_distance(const LabelImage& image, const Index3& v, const Index3& low, const Index3& high,
                      double limit) {
  double best = limit;
  for (int k = low.z(); k < high.z(); ++k)
    for (int j = low.y(); j < high.y(); ++j)
      for (int i = low.x(); i < high.x(); ++i) {
        const Index3 w(i, j, k);
        if (image.at(w) == image.at(v)) continue;
        best = std::min(best, (w - v).cast<double>().cwiseProduct(image.frame().spacing_mm).norm());
      }
  return best;
}

void expect_plain_distances(const LabelImage& image, const Index3& low, const Index3& high, double limit) {
  const DistanceField field = distance_to_label_change(image, low, high, limit);
  for (int k = low.z(); k < high.z(); ++k)
    for (int j = low.y(); j < high.y(); ++j)
      for (int i = low.x(); i < high.x(); ++i) {
        const Index3 v(i, j, k);
        ASSERT_NEAR(field.at(v), plain_distance(image, v, low, high, limit), 2e-6 * limit) << v.transpose();
      }
}

TEST(Distance, AgreesWithBruteForceForManyLabelsAndAnisotropicVoxels) {
  for (std::uint32_t seed = 11; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<Vec3> seeds;  // cells of a Voronoi diagram: large regions and meeting labels
    for (int s = 0; s < 9; ++s) seeds.push_back({70 * unit(random), 11 * unit(random), 9 * unit(random)});
    LabelImage image = make_image({70, 11, 9}, {0, 1, 2, 3}, [&](const Vec3& p) {
      const auto nearest = std::min_element(seeds.begin(), seeds.end(), [&](const Vec3& a, const Vec3& b) {
        return (a - p).squaredNorm() < (b - p).squaredNorm();
      });
      return (nearest - seeds.begin()) % 4;
    });
    image.frame().spacing_mm = {0.7 + unit(random), 0.4 + unit(random), 1.3 + unit(random)};
    expect_plain_distances(image, {0, 0, 0}, {70, 11, 9}, 6.3);
    expect_plain_distances(image, {3, 2, 4}, {69, 10, 8}, 40.0);
  }
}

TEST(Distance, FlatInterfacesAcrossEachAxisAreSeen) {
  for (int axis = 0; axis < 3; ++axis) {
    LabelImage image = make_image({20, 20, 20}, {0, 1}, [axis](const Vec3& p) { return p[axis] >= 10; });
    image.frame().spacing_mm = {0.5, 0.75, 2};
    expect_plain_distances(image, {0, 0, 0}, {20, 20, 20}, 5.0);
  }
}

TEST(Distance, IsTheSameForEveryNumberOfThreadsAndRefusesBadBoxes) {
  const LabelImage image = random_image(5, {70, 20, 20}, 2);
  const auto with_threads = [&](int threads) {
    const parallel::ThreadLimit limit(threads);
    return distance_to_label_change(image, {0, 0, 0}, {70, 20, 20}, 4).distance_mm;
  };
  EXPECT_EQ(with_threads(1), with_threads(4));
  EXPECT_THROW((void)distance_to_label_change(image, {0, 0, 0}, {71, 20, 20}, 4), Error);
  EXPECT_THROW((void)distance_to_label_change(image, {5, 0, 0}, {5, 20, 20}, 4), Error);
  EXPECT_THROW((void)distance_to_label_change(image, {0, 0, 0}, {70, 20, 20}, std::nan("")), Error);
}

}  // namespace
}  // namespace lumesh
