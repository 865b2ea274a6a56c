#include "lumesh/parallel/stable_array.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <set>
#include <vector>

#include "lumesh/core/error.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::parallel {
namespace {

TEST(StableArray, KeepsAddressesAndContentsWhileItGrows) {
  StableArray<std::uint64_t> array(std::size_t{1} << 30);  // 8 GiB of addresses.
  array.commit(10);
  array[9] = 77;
  const std::uint64_t* const before = &array[9];
  array.commit(3'000'000);
  EXPECT_EQ(&array[9], before);
  EXPECT_EQ(array[9], 77u);
  EXPECT_EQ(array[2'999'999], 0u);  // New entries are zero.
  EXPECT_EQ(array.first(3'000'000).size(), 3'000'000u);
}

TEST(StableArray, GivesZeroesAgainAfterShrinking) {
  StableArray<int> array(1'000'000);
  array.commit(1'000'000);
  std::fill_n(array.data(), 1'000'000, 5);
  array.shrink(4096);
  array.commit(1'000'000);
  EXPECT_EQ(array[4095], 5);
  EXPECT_EQ(array[999'999], 0);
}

TEST(StableArray, MovesWithItsContents) {
  StableArray<int> array(1000);
  array.commit(5);
  array[4] = 3;
  StableArray<int> other = std::move(array);
  EXPECT_EQ(other[4], 3);
  other.commit(900);
  EXPECT_EQ(other[4], 3);
}

TEST(StableArray, ReportsMemoryWhenTheReserveIsExceeded) {
  StableArray<int> array(1000);
  try {
    array.commit(5000);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kMemory);
  }
}

#if !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)  // Their shadow memory breaks any address limit.
TEST(StableArray, WorksUnderALimitOnTheAddressSpace) {
  rlimit old{};
  getrlimit(RLIMIT_AS, &old);
  rlimit tight = old;
  tight.rlim_cur = std::size_t{8} << 30;
  setrlimit(RLIMIT_AS, &tight);
  {
    StableArray<std::uint64_t> array(std::size_t{1} << 32, 1000);  // Asks for 32 GiB.
    array.commit(1000);
    array[999] = 1;
    EXPECT_EQ(array[999], 1u);
    // Twenty of them leave a quarter at least for stacks and all else.
    std::vector<StableArray<std::uint64_t>> many;
    for (int i = 0; i < 20; ++i) many.emplace_back(std::size_t{1} << 32, 1000);
    void* const rest = mmap(nullptr, std::size_t{2} << 30, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    EXPECT_NE(rest, MAP_FAILED);
    if (rest != MAP_FAILED) munmap(rest, std::size_t{2} << 30);
    EXPECT_THROW(StableArray<std::uint64_t>(std::size_t{1} << 32, std::size_t{1} << 32), Error);
  }
  setrlimit(RLIMIT_AS, &old);
}
#endif

TEST(SlotPool, HandsEverySlotToOneOwnerOnlyWhenManyRunAtOnce) {
  constexpr int kOwners = 16;
  constexpr std::uint32_t kPerOwner = 5000;
  SlotPool pool(100, kOwners, 64);
  StableArray<std::uint32_t> owner_of(1 << 24);
  std::vector<std::vector<std::uint32_t>> taken(kOwners);
  for_each_block(kOwners, 1, [&](std::size_t owner, std::size_t, std::size_t) {
    for (std::uint32_t i = 0; i < kPerOwner; ++i) {
      const auto slot =
          pool.take(static_cast<int>(owner), [&](std::uint32_t, std::uint32_t end) { owner_of.commit(end); });
      owner_of[slot] = static_cast<std::uint32_t>(owner);
      taken[owner].push_back(slot);
    }
  });
  std::set<std::uint32_t> all;
  for (int owner = 0; owner < kOwners; ++owner)
    for (const std::uint32_t slot : taken[owner]) {
      EXPECT_GE(slot, 100u);
      EXPECT_EQ(owner_of[slot], static_cast<std::uint32_t>(owner));
      all.insert(slot);
    }
  EXPECT_EQ(all.size(), kOwners * kPerOwner);
  EXPECT_EQ(pool.live(), 100 + kOwners * kPerOwner);
  EXPECT_GE(pool.end(), pool.live());
}

TEST(SlotPool, ReturnsFreedSlotsToTheOwnerThatFreedThem) {
  SlotPool pool(0, 2, 4);
  const auto nothing = [](std::uint32_t, std::uint32_t) {};
  const std::uint32_t slot = pool.take(0, nothing);
  pool.give(1, slot);  // Owner 1 frees what owner 0 took.
  EXPECT_EQ(pool.live(), 0u);
  EXPECT_NE(pool.take(0, nothing), slot);
  EXPECT_EQ(pool.take(1, nothing), slot);
}

}  // namespace
}  // namespace lumesh::parallel
