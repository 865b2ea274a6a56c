#include "lumesh/parallel/topology.hpp"

#include <hwloc.h>

#include <algorithm>

#include "lumesh/core/error.hpp"

namespace lumesh::parallel {
namespace {

constexpr double kLocalDistance = 10;

hwloc_topology_t machine_of(const std::shared_ptr<void>& handle) {
  return static_cast<hwloc_topology_t>(handle.get());
}

/// @param description  Null for this machine.
std::shared_ptr<void> load_machine(const char* description) {
  hwloc_topology_t raw = nullptr;
  if (hwloc_topology_init(&raw) != 0) throw Error(ErrorKind::kMemory, "hwloc cannot be started");
  std::shared_ptr<void> handle(raw,
                               [](void* p) { hwloc_topology_destroy(static_cast<hwloc_topology_t>(p)); });
  if (description == nullptr) {
    hwloc_topology_set_flags(raw, HWLOC_TOPOLOGY_FLAG_RESTRICT_TO_CPUBINDING);
  } else if (hwloc_topology_set_synthetic(raw, description) != 0) {
    throw Error(ErrorKind::kUsage, std::string("topology \"") + description +
                                       "\": hwloc does not know it; one it knows is \"numa:8 core:16 pu:1\"");
  }
  if (hwloc_topology_load(raw) != 0) return nullptr;
  return handle;
}

/// The NUMA nodes that have processors, and the index among them of each processor's.
struct Nodes {
  std::vector<hwloc_obj_t> nodes;
  std::vector<int> of_processor;
};

Nodes nodes_with_processors(hwloc_topology_t machine) {
  Nodes found;
  const int processors = hwloc_get_nbobjs_by_type(machine, HWLOC_OBJ_PU);
  for (int i = 0; i < processors; ++i) {
    const hwloc_obj_t processor = hwloc_get_obj_by_type(machine, HWLOC_OBJ_PU, static_cast<unsigned>(i));
    const int number = processor->nodeset != nullptr ? hwloc_bitmap_first(processor->nodeset) : -1;
    const hwloc_obj_t node =
        number < 0 ? nullptr : hwloc_get_numanode_obj_by_os_index(machine, static_cast<unsigned>(number));
    const auto place = std::ranges::find(found.nodes, node);
    found.of_processor.push_back(static_cast<int>(place - found.nodes.begin()));
    if (place == found.nodes.end()) found.nodes.push_back(node);
  }
  return found;
}

double tree_distance(hwloc_topology_t machine, hwloc_obj_t a, hwloc_obj_t b) {
  if (a == b || a == nullptr || b == nullptr) return kLocalDistance;
  // Memory hangs beside the tree of processors: its parent is in it.
  const hwloc_obj_t common = hwloc_get_common_ancestor_obj(machine, a->parent, b->parent);
  return kLocalDistance * (1 + std::max(1, a->parent->depth - common->depth));
}

std::vector<double> distances_between(hwloc_topology_t machine, const std::vector<hwloc_obj_t>& nodes) {
  std::vector<double> distances;
  for (const hwloc_obj_t a : nodes)
    for (const hwloc_obj_t b : nodes) distances.push_back(tree_distance(machine, a, b));
  unsigned count = 1;
  hwloc_distances_s* told = nullptr;
  hwloc_distances_get_by_type(machine, HWLOC_OBJ_NUMANODE, &count, &told, HWLOC_DISTANCES_KIND_MEANS_LATENCY,
                              0);
  if (count == 0 || told == nullptr) return distances;
  const auto place_of = [&](hwloc_obj_t node) {
    return static_cast<std::size_t>(std::find(told->objs, told->objs + told->nbobjs, node) - told->objs);
  };
  for (std::size_t a = 0; a < nodes.size(); ++a)
    for (std::size_t b = 0; b < nodes.size(); ++b)
      if (const std::size_t i = place_of(nodes[a]), j = place_of(nodes[b]); std::max(i, j) < told->nbobjs)
        distances[a * nodes.size() + b] = static_cast<double>(told->values[i * told->nbobjs + j]);
  hwloc_distances_release(machine, told);
  return distances;
}

}  // namespace

Topology::Topology(std::shared_ptr<void> handle, bool is_this_machine)
    : handle_(std::move(handle)), is_this_machine_(is_this_machine) {
  if (handle_ != nullptr) {
    const Nodes found = nodes_with_processors(machine_of(handle_));
    nodes_ = static_cast<int>(found.nodes.size());
    node_of_processor_ = found.of_processor;
    distances_ = distances_between(machine_of(handle_), found.nodes);
  }
  if (nodes_ > 0) return;
  nodes_ = 1;  // Where hwloc finds nothing, all threads are alike.
  node_of_processor_ = {0};
  distances_ = {kLocalDistance};
  is_this_machine_ = false;
}

Topology Topology::of_machine() {
  return Topology(load_machine(nullptr), true);
}

Topology Topology::synthetic(const std::string& description) {
  return Topology(load_machine(description.c_str()), false);
}

std::size_t Topology::processor_of(int thread, int threads) const {
  return static_cast<std::size_t>(thread) * node_of_processor_.size() / static_cast<std::size_t>(threads);
}

Topology::Pin::Pin(const Topology& topology, int thread, int threads) {
  if (!topology.is_this_machine_) return;
  const hwloc_topology_t machine = machine_of(topology.handle_);
  const hwloc_obj_t processor = hwloc_get_obj_by_type(
      machine, HWLOC_OBJ_PU, static_cast<unsigned>(topology.processor_of(thread, threads)));
  std::shared_ptr<void> before(hwloc_bitmap_alloc(),
                               [](void* p) { hwloc_bitmap_free(static_cast<hwloc_bitmap_t>(p)); });
  if (hwloc_get_cpubind(machine, static_cast<hwloc_bitmap_t>(before.get()), HWLOC_CPUBIND_THREAD) != 0 ||
      hwloc_set_cpubind(machine, processor->cpuset, HWLOC_CPUBIND_THREAD) != 0)
    return;
  topology_ = topology.handle_;
  before_ = std::move(before);
}

Topology::Pin::~Pin() {
  if (before_ != nullptr)
    hwloc_set_cpubind(machine_of(topology_), static_cast<hwloc_bitmap_t>(before_.get()),
                      HWLOC_CPUBIND_THREAD);
}

}  // namespace lumesh::parallel
