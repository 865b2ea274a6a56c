// A sizing plugin: elements grow with their distance to landmarks, such as the points of a centerline.
//
//   --sizing landmark_sizing.so:landmarks.txt,adapt_const=2,floor=0.5
//
//   landmarks.txt   one landmark a line, x y z in mm (LPS); lines that begin with # are skipped
//   adapt_const     an edge may be so many times as long as its ends are far from landmarks; default 2
//   floor           mm; edges need not be shorter; default none, which ends only with an adapt_const of 2 or
//   more
//
// should_be_adapted() below is algorithm 3, "PODM's Function Approximation for an Aneurysm", of the paper
// that lumesh follows, as --size-points landmarks.txt --adapt-const 2 has it built in. For the author of
// another plugin: change Sizes, and read_sizes(), which makes it from the options; what stands below them is
// the same for all plugins.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "lumesh/sizing.h"

namespace {

using Point = std::array<double, 3>;

double squared_distance(const Point& a, const Point& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

/// A k-d tree: the middle of a range splits it by x, y or z in turn. Sorted once and then only read, so that
/// any number of threads may search.
class Landmarks {
 public:
  explicit Landmarks(std::vector<Point> points) : points_(std::move(points)) { sort(0, points_.size(), 0); }

  [[nodiscard]] double distance(const Point& x) const {
    double least2 = std::numeric_limits<double>::infinity();
    search(x, 0, points_.size(), 0, least2);
    return std::sqrt(least2);
  }

 private:
  void sort(std::size_t begin, std::size_t end, std::size_t axis) {
    if (end - begin < 2) return;
    const std::size_t middle = (begin + end) / 2;
    const auto first = points_.begin();
    std::nth_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(middle),
                     first + static_cast<std::ptrdiff_t>(end),
                     [axis](const Point& a, const Point& b) { return a[axis] < b[axis]; });
    sort(begin, middle, (axis + 1) % 3);
    sort(middle + 1, end, (axis + 1) % 3);
  }

  void search(const Point& x, std::size_t begin, std::size_t end, std::size_t axis, double& least2) const {
    if (begin == end) return;
    const std::size_t middle = (begin + end) / 2;
    const Point& split = points_[middle];
    least2 = std::min(least2, squared_distance(x, split));
    const double beyond = x[axis] - split[axis];
    const std::size_t next = (axis + 1) % 3;
    // First the side that x is on: the other one is often too far then.
    if (beyond < 0)
      search(x, begin, middle, next, least2);
    else
      search(x, middle + 1, end, next, least2);
    if (beyond * beyond >= least2) return;
    if (beyond < 0)
      search(x, middle + 1, end, next, least2);
    else
      search(x, begin, middle, next, least2);
  }

  std::vector<Point> points_;
};

/// Distances of the places that a thread has asked for last. A vertex is a corner of some twenty tetrahedra,
/// and those near by are asked about one after another: most questions have been answered before.
class Memory {
 public:
  template <class Measure>
  double get(std::uint64_t of, const Point& x, const Measure& measure) {
    Entry& entry = entries_[slot_of(x)];
    if (entry.of != of || entry.x != x) entry = {of, x, measure()};
    return entry.distance;
  }

 private:
  struct Entry {
    std::uint64_t of = 0;
    Point x{};
    double distance = 0;
  };
  static std::size_t slot_of(const Point& x) {
    std::uint64_t hash = 0;
    for (const double c : x) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &c, sizeof bits);
      hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 32;
    }
    return hash % kEntries;
  }

  static constexpr std::size_t kEntries = 8192;
  std::array<Entry, kEntries> entries_{};
};

/// What the plugin knows: made once, then only read.
struct Sizes {
  Landmarks landmarks;
  double adapt_const = 2;
  double floor_mm = 0;
  std::uint64_t number = 0;  // Unlike an address, of these sizes alone.

  /// Distance to the closest landmark; near one, that which gives the floor.
  [[nodiscard]] double distance(const Point& x) const {
    thread_local Memory memory;
    return memory.get(number, x, [&] { return std::max(landmarks.distance(x), floor_mm / adapt_const); });
  }

  /// Algorithm 3. The metric tensor of a point is 1 / dist^2 times the identity, so that of its nine numbers
  /// one is enough; an edge has the mean of the tensors at its ends.
  [[nodiscard]] bool should_be_adapted(const double* points, int n) const {
    constexpr int kMost = 8;  // Tetrahedra have 4; no memory is asked for, so that nothing can be thrown.
    std::array<Point, kMost> corners;
    std::array<double, kMost> diagonal;
    if (n > kMost) return false;
    for (int p = 0; p < n; ++p) {
      corners[p] = {points[3 * p], points[3 * p + 1], points[3 * p + 2]};
      const double dist = distance(corners[p]);
      diagonal[p] = 1 / (dist * dist);
    }
    for (int a = 0; a < n; ++a) {
      for (int b = a + 1; b < n; ++b) {
        const double mean = (diagonal[a] + diagonal[b]) / 2;
        const double metric_length = std::sqrt(mean * squared_distance(corners[a], corners[b]));
        if (metric_length > adapt_const) return true;
      }
    }
    return false;
  }
};

std::vector<Point> read_landmarks(const std::string& name) {
  std::ifstream file(name);
  if (!file)
    throw std::runtime_error(name + ": cannot be read; name a text file with one landmark 'x y z' a line");
  std::vector<Point> points;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    std::istringstream words(line);
    std::string more;
    Point p{};
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    if (!(words >> p[0] >> p[1] >> p[2]) || words >> more || !std::isfinite(p[0] + p[1] + p[2]))
      throw std::runtime_error(name + ", line " + std::to_string(number) +
                               ": wants three numbers 'x y z', in mm");
    points.push_back(p);
  }
  if (points.empty()) throw std::runtime_error(name + ": has no landmarks; write one 'x y z' a line");
  return points;
}

double positive_number(const std::string& key, const std::string& text) {
  std::istringstream words(text);
  double value = 0;
  if (!(words >> value) || !words.eof() || !(value > 0) || !std::isfinite(value))
    throw std::runtime_error(key + " must be a number greater than 0, not '" + text + "'");
  return value;
}

/// Reads "landmarks.txt,adapt_const=2,floor=0.5".
std::unique_ptr<Sizes> read_sizes(const std::string& options) {
  std::istringstream words(options);
  std::string file, word;
  std::getline(words, file, ',');
  double adapt_const = 2, floor_mm = 0;
  while (std::getline(words, word, ',')) {
    const std::size_t equals = word.find('=');
    const std::string key = word.substr(0, equals),
                      value = equals == std::string::npos ? "" : word.substr(equals + 1);
    if (key == "adapt_const")
      adapt_const = positive_number(key, value);
    else if (key == "floor")
      floor_mm = positive_number(key, value);
    else
      throw std::runtime_error("no option '" + key + "'; options: adapt_const=NUMBER, floor=MM");
  }
  static std::atomic<std::uint64_t> count = 0;
  return std::make_unique<Sizes>(Sizes{Landmarks(read_landmarks(file)), adapt_const, floor_mm, ++count});
}

}  // namespace

LUMESH_SIZING_EXPORT int lumesh_sizing_abi_version() {
  return LUMESH_SIZING_ABI_VERSION;
}

LUMESH_SIZING_EXPORT int lumesh_sizing_create(const char* options, void** state, char* message,
                                              std::size_t message_size) {
  // No exception may leave a function of C.
  try {
    *state = read_sizes(options).release();
    return 0;
  } catch (const std::exception& e) {
    std::snprintf(message, message_size, "%s", e.what());
    return 1;
  }
}

LUMESH_SIZING_EXPORT void lumesh_sizing_destroy(void* state) {
  delete static_cast<Sizes*>(state);
}

LUMESH_SIZING_EXPORT int lumesh_should_be_adapted(void* state, const double* points, int n) {
  return static_cast<const Sizes*>(state)->should_be_adapted(points, n) ? 1 : 0;
}
