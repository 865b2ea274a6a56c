#include "lumesh/parallel/stable_array.hpp"

#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <limits>
#include <string>

#include "lumesh/core/error.hpp"

namespace lumesh::parallel {
namespace {

constexpr std::size_t kPage = 4096;
constexpr std::size_t kSmallestStep = std::size_t{1} << 18;
constexpr std::size_t kLargestStep = std::size_t{1} << 28;

std::size_t round_to_page(std::size_t bytes) {
  return (bytes + kPage - 1) / kPage * kPage;
}

[[noreturn]] void throw_out_of_memory(std::size_t bytes) {
  throw Error(ErrorKind::kMemory, "mesh storage: cannot get " + std::to_string(bytes >> 20) +
                                      " MiB; choose a coarser mesh or a machine with more memory");
}

/// Where the address space is limited (ulimit -v, batch systems), what one of some twenty arrays may take:
/// stacks of threads and all else need addresses, too.
std::size_t fair_share() {
  constexpr std::size_t kShares = 32;
  rlimit limit{};
  const bool is_limited = getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  return is_limited ? limit.rlim_cur / kShares : std::numeric_limits<std::size_t>::max();
}

}  // namespace

ReservedMemory::ReservedMemory(std::size_t wanted, std::size_t least) {
  wanted = std::min(wanted, fair_share());
  for (std::size_t bytes = round_to_page(std::max({wanted, least, kPage}));;
       bytes = round_to_page(bytes / 2)) {
    // No access and no reserve: the range costs address space only, whatever the overcommit policy.
    void* const range = mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (range != MAP_FAILED) {
      data_ = range;
      reserved_ = bytes;
      return;
    }
    if (bytes / 2 < least || bytes <= kPage) throw_out_of_memory(least);
  }
}

ReservedMemory::~ReservedMemory() {
  if (data_ != nullptr) munmap(data_, reserved_);
}

void ReservedMemory::grow(std::size_t bytes) {
  const std::lock_guard lock(growing_);
  // Relaxed: the mutex orders it after the last store.
  const std::size_t committed = committed_.load(std::memory_order_relaxed);
  if (bytes <= committed) return;
  if (bytes > reserved_) throw_out_of_memory(bytes);
  // Steps of an eighth keep the system calls few; untouched pages cost nothing.
  const std::size_t step = std::clamp(committed / 8, kSmallestStep, kLargestStep);
  const std::size_t target = std::min(reserved_, round_to_page(std::max(bytes, committed + step)));
  if (mprotect(static_cast<char*>(data_) + committed, target - committed, PROT_READ | PROT_WRITE) != 0)
    throw_out_of_memory(target);
  committed_.store(target, std::memory_order_release);  // Pairs with the acquire in commit().
}

void ReservedMemory::shrink(std::size_t bytes) {
  // Nobody else uses the array: any order would do, here and in swap().
  const std::size_t keep = round_to_page(bytes), committed = committed_.load(std::memory_order_relaxed);
  if (data_ == nullptr || keep >= committed) return;
  char* const tail = static_cast<char*>(data_) + keep;
  madvise(tail, committed - keep, MADV_DONTNEED);
  mprotect(tail, committed - keep, PROT_NONE);
  committed_.store(keep, std::memory_order_release);
}

void ReservedMemory::swap(ReservedMemory& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(reserved_, other.reserved_);
  const std::size_t mine = committed_.load(std::memory_order_relaxed);
  committed_.store(other.committed_.load(std::memory_order_relaxed), std::memory_order_relaxed);
  other.committed_.store(mine, std::memory_order_relaxed);
}

SlotPool::SlotPool(std::uint32_t used, int owners, std::uint32_t block)
    : block_(block),
      used_at_start_(used),
      shared_(std::make_unique<Shared>()),
      owners_(static_cast<std::size_t>(owners)) {
  shared_->end.store(used, std::memory_order_relaxed);  // Nobody else has it yet.
}

std::uint32_t SlotPool::live() const {
  std::int64_t live = used_at_start_;
  for (const Owner& owner : owners_) live += owner.taken;
  return static_cast<std::uint32_t>(live);
}

}  // namespace lumesh::parallel
