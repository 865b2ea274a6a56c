#include "../src/operators/tried_edges.hpp"

#include <gtest/gtest.h>

#include <array>

namespace lumesh::operators {
namespace {

using Vertices = std::array<std::uint32_t, 4>;

TEST(TriedEdges, FailAgainUntilBothEndsSawAChange) {
  TriedEdges tried;
  const VertexId a(3), b(7);
  EXPECT_FALSE(tried.would_fail(a, b));
  tried.note_change(Vertices{3, 7, 1, 2});  // Before the failure: says nothing.
  tried.note_failure(a, b);
  EXPECT_TRUE(tried.would_fail(a, b));
  EXPECT_TRUE(tried.would_fail(b, a));
  EXPECT_FALSE(tried.would_fail(a, VertexId(1)));
  tried.note_change(Vertices{3, 4, 5, 6});
  EXPECT_TRUE(tried.would_fail(a, b));
  tried.note_change(Vertices{7, 4, 5, 6});
  EXPECT_FALSE(tried.would_fail(a, b));
  tried.note_failure(b, a);
  EXPECT_TRUE(tried.would_fail(a, b));
  tried.note_change(Vertices{7, 3, 5, 6});
  EXPECT_FALSE(tried.would_fail(a, b));
}

TEST(TriedEdges, AreForgottenByClear) {
  TriedEdges tried;
  tried.note_failure(VertexId(1), VertexId(2));
  tried.clear();
  EXPECT_FALSE(tried.would_fail(VertexId(1), VertexId(2)));
}

}  // namespace
}  // namespace lumesh::operators
