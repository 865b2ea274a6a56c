#include "lumesh/parallel/work_lists.hpp"

#include <iterator>

namespace lumesh::parallel {

WorkLists::WorkLists(const Team& team, int threads, std::uint32_t tasks)
    : team_(team),
      balance_(team.balance()),
      tasks_(tasks),
      members_(static_cast<std::size_t>(threads)),
      migrations_(static_cast<std::size_t>(threads)),
      idle_(team, threads),
      can_share_(static_cast<std::size_t>(team.topology().nodes()), 0),
      active_(threads),
      left_(tasks) {}

int WorkLists::home_of(std::uint32_t task) const {
  return static_cast<int>(std::uint64_t{task} * members_.size() / tasks_);
}

void WorkLists::put_first(RankedTask one) {
  add_task(home_of(one.task), one);
}

void WorkLists::put(RankedTask one, int by) {
  const std::lock_guard lock(mutex_);
  const int home = home_of(one.task);
  const int receiver = home == by || idle_.contains(home) ? home : receiver_instead_of(home, by);
  add_task(receiver, one);
  if (receiver != home) count_migration(home, receiver, 1);
  if (idle_.contains(receiver)) {
    wake_idle(receiver);
  } else if (balance_ == Balance::kStealing && !idle_.empty()) {
    wake_idle(idle_.first());
  }
}

/// Where home is busy: an idle thread, as which counts the one that calls if it has no other task.
int WorkLists::receiver_instead_of(int home, int by) const {
  const bool is_free = members_[static_cast<std::size_t>(by)].tasks.empty();
  if (balance_ == Balance::kFirstIdle) return !idle_.empty() ? idle_.first() : is_free ? by : home;
  if (!goes_by_distance(balance_)) return home;
  const int nearest = idle_.nearest(team_.node_of(home));
  if (!is_free) return nearest == IdleThreads::kNobody ? home : nearest;
  const auto distance = [&](int thread) {
    return team_.topology().distance(team_.node_of(home), team_.node_of(thread));
  };
  return nearest == IdleThreads::kNobody || distance(by) <= distance(nearest) ? by : nearest;
}

void WorkLists::put_back(std::uint32_t task, int thread) {
  const std::lock_guard lock(mutex_);
  add_task(thread, {++rounds_, task});
}

bool WorkLists::take(int thread, std::uint32_t& task) {
  std::unique_lock lock(mutex_);
  std::set<RankedTask>& mine = member(thread).tasks;
  for (;;) {
    if (is_over()) return false;
    if (mine.empty() && balance_ == Balance::kStealing) steal(thread);
    if (!mine.empty()) break;
    idle_.add(thread);
    --active_;
    wake_one_parked();
    sleep(thread, lock);
  }
  share(thread);
  task = mine.begin()->task;
  mine.erase(mine.begin());
  note_tasks(thread);
  return true;
}

void WorkLists::done() {
  const std::lock_guard lock(mutex_);
  if (--left_ == 0) {
    wake_all();
  } else {
    wake_one_parked();
  }
}

void WorkLists::park(int thread) {
  std::unique_lock lock(mutex_);
  if (is_over() || (active_ == 1 && parked_.empty())) return;
  if (active_ == 1) wake_one_parked();  // Somebody goes on: now it is the other's turn.
  parked_.push_back(thread);
  --active_;
  sleep(thread, lock);
}

void WorkLists::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  wake_all();
}

void WorkLists::add_task(int thread, RankedTask one) {
  member(thread).tasks.insert(one);
  note_tasks(thread);
}

void WorkLists::note_tasks(int thread) {
  Member& one = member(thread);
  const bool can_share = one.tasks.size() >= 2;
  can_share_[static_cast<std::size_t>(team_.node_of(thread))] += int{can_share} - int{one.can_share};
  one.can_share = can_share;
}

void WorkLists::share(int thread) {
  if (idle_.empty() || !member(thread).can_share) return;
  if (balance_ == Balance::kFirstIdle) migrate_half(thread, idle_.first());
  if (!goes_by_distance(balance_)) return;
  const int own = team_.node_of(thread);
  const int nearest = idle_.nearest(own, [&](int node) {
    return balance_ == Balance::kHierarchical || node == own ||
           can_share_[static_cast<std::size_t>(node)] == 0;
  });
  if (nearest != IdleThreads::kNobody) migrate_half(thread, nearest);
}

/// From the first thread with tasks, going round from one by chance.
void WorkLists::steal(int thread) {
  random_ = random_ * 6364136223846793005u + 1442695040888963407u;  // Knuth's MMIX.
  const std::size_t first = (random_ >> 33) % members_.size();
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const std::size_t from = (first + i) % members_.size();
    if (members_[from].tasks.empty()) continue;
    migrate_half(static_cast<int>(from), thread);
    return;
  }
}

void WorkLists::migrate_half(int from, int to) {
  std::set<RankedTask>&given = member(from).tasks, &taken = member(to).tasks;
  // A thief has no task, so it also takes a single one; who gives keeps one for itself.
  const std::size_t count = balance_ == Balance::kStealing ? (given.size() + 1) / 2 : given.size() / 2;
  for (std::size_t i = 0; i < count; ++i) taken.insert(given.extract(std::prev(given.end())));
  note_tasks(from);
  note_tasks(to);
  count_migration(from, to, count);
  if (idle_.contains(to)) wake_idle(to);
}

void WorkLists::count_migration(int from, int to, std::uint64_t tasks) {
  TaskMigrations& counts = migrations_[static_cast<std::size_t>(to)];
  (team_.node_of(from) == team_.node_of(to) ? counts.local : counts.remote) += tasks;
}

void WorkLists::wake_idle(int thread) {
  idle_.remove(thread);
  ++active_;
  member(thread).waits = false;
  member(thread).woken.notify_one();
}

void WorkLists::wake_one_parked() {
  if (parked_.empty()) return;
  const int thread = parked_.front();
  parked_.pop_front();
  ++active_;
  member(thread).waits = false;
  member(thread).woken.notify_one();
}

void WorkLists::wake_all() {
  while (!parked_.empty()) wake_one_parked();
  while (!idle_.empty()) wake_idle(idle_.first());
}

void WorkLists::sleep(int thread, std::unique_lock<std::mutex>& lock) {
  Member& me = member(thread);
  me.waits = true;
  me.woken.wait(lock, [&] { return !me.waits; });
}

}  // namespace lumesh::parallel
