#include "lumesh/delaunay/sizing_plugin.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cfenv>
#include <chrono>
#include <exception>

#include "lumesh/core/error.hpp"
#include "lumesh/sizing.h"

namespace lumesh {
namespace {

constexpr double kSlowNanoseconds = 5000;
constexpr std::uint64_t kTimedOf =
    1024;  // One call of so many has its time taken, in each copy of the counts:
constexpr std::uint64_t kFirstTimed = 16;  // not the first, which may still have pages to fetch.

[[noreturn]] void throw_plugin_error(const std::filesystem::path& path, const std::string& fault) {
  throw Error(ErrorKind::kBadInput, fmt::format("{}: {}", path.string(), fault));
}

/// Brings back the rounding mode and the treatment of subnormals: libraries linked with -ffast-math switch
/// subnormals off where they are loaded, which the exact predicates would not survive.
class KeptFloatingPoint {
 public:
  KeptFloatingPoint() { std::fegetenv(&environment_); }
  ~KeptFloatingPoint() { std::fesetenv(&environment_); }
  KeptFloatingPoint(const KeptFloatingPoint&) = delete;
  KeptFloatingPoint& operator=(const KeptFloatingPoint&) = delete;

 private:
  std::fenv_t environment_ = {};
};

/// The function of that name, or null.
template <class Function>
Function* find_function(void* handle, const char* name) {
  return reinterpret_cast<Function*>(dlsym(handle, name));
}

/// What the library's loader said, without the file's name, which we say ourselves.
std::string loader_message(const std::filesystem::path& path) {
  const char* text = dlerror();
  std::string message = text == nullptr ? "unknown fault" : text;
  const std::string prefix = path.string() + ": ";
  if (message.starts_with(prefix)) message.erase(0, prefix.size());
  return message;
}

void* open_library(const std::filesystem::path& path) {
  std::error_code fault;
  if (!std::filesystem::is_regular_file(path, fault))
    throw_plugin_error(
        path, "there is no such file; `sizing` takes the path of a shared library, then :options if any");
  // RTLD_NODELETE: threads and destructors that the plugin left behind would otherwise run code that is gone.
  const std::filesystem::path whole = std::filesystem::absolute(path);
  void* handle = dlopen(whole.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (handle == nullptr)
    throw_plugin_error(
        path, fmt::format("cannot be loaded as a sizing plugin ({}); build it as a shared library for this "
                          "machine, linked with all it needs (see docs/sizing.md)",
                          loader_message(whole)));
  return handle;
}

/// One line of what a plugin wrote.
std::string first_line(const char* text, std::size_t room) {
  std::string line(text, std::find(text, text + room, '\0'));
  return line.substr(0, line.find_first_of("\r\n"));
}

std::string point_text(const Vec3& point) {
  return fmt::format("({:g}, {:g}, {:g})", point.x(), point.y(), point.z());
}

std::string text_of(const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "not a std::exception";
  }
}

}  // namespace

PluginName split_plugin_name(std::string_view text) {
  for (std::size_t colon = text.find(':');; colon = text.find(':', colon + 1)) {
    const std::string_view path = text.substr(0, colon);
    std::error_code fault;
    if (std::filesystem::is_regular_file(path, fault))
      return {path, std::string(colon == std::string_view::npos ? "" : text.substr(colon + 1))};
    if (colon == std::string_view::npos) break;
  }
  const std::size_t colon = text.find(':');
  return {text.substr(0, colon), std::string(colon == std::string_view::npos ? "" : text.substr(colon + 1))};
}

struct PluginSizing::Library {
  explicit Library(PluginName name);
  ~Library() {
    if (destroy == nullptr) return;
    try {
      destroy(state);
    } catch (...) {  // The run is over, and nothing is left to save.
    }
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  void create(const std::string& options);

  std::filesystem::path path;
  void* handle = nullptr;
  void* state = nullptr;
  decltype(lumesh_size_at)* size_at = nullptr;
  decltype(lumesh_should_be_adapted)* should_be_adapted = nullptr;
  decltype(lumesh_sizing_destroy)* destroy = nullptr;
};

PluginSizing::Library::Library(PluginName name) : path(std::move(name.path)) {
  const KeptFloatingPoint kept;
  handle = open_library(path);
  auto* const version =
      find_function<decltype(lumesh_sizing_abi_version)>(handle, "lumesh_sizing_abi_version");
  if (version == nullptr)
    throw_plugin_error(
        path,
        "does not define lumesh_sizing_abi_version(); a sizing plugin defines it, with C linkage, as "
        "lumesh/sizing.h says");
  if (const int found = version(); found != LUMESH_SIZING_ABI_VERSION)
    throw_plugin_error(
        path,
        fmt::format("is made for version {} of lumesh/sizing.h, and this lumesh has version {}; compile it "
                    "again with the header of this lumesh",
                    found, LUMESH_SIZING_ABI_VERSION));
  size_at = find_function<decltype(lumesh_size_at)>(handle, "lumesh_size_at");
  should_be_adapted = find_function<decltype(lumesh_should_be_adapted)>(handle, "lumesh_should_be_adapted");
  if (size_at == nullptr && should_be_adapted == nullptr)
    throw_plugin_error(
        path,
        "defines neither lumesh_size_at() nor lumesh_should_be_adapted(); a sizing plugin defines at "
        "least one of them, with C linkage");
  create(name.options);
}

void PluginSizing::Library::create(const std::string& options) {
  auto* const make = find_function<decltype(lumesh_sizing_create)>(handle, "lumesh_sizing_create");
  if (make == nullptr && !options.empty())
    throw_plugin_error(
        path, fmt::format("takes no options (it has no lumesh_sizing_create()); leave out ':{}'", options));
  if (make != nullptr) {
    std::array<char, 1024> message = {};
    int result = 0;
    try {
      result = make(options.c_str(), &state, message.data(), message.size());
    } catch (...) {
      throw_plugin_error(
          path,
          fmt::format("lumesh_sizing_create() threw an exception ({}); repair the plugin or its options '{}'",
                      text_of(std::current_exception()), options));
    }
    if (result != 0) {
      std::string said = first_line(message.data(), message.size());
      if (said.empty()) said = fmt::format("lumesh_sizing_create() returned {} without a message", result);
      throw_plugin_error(path, fmt::format("refused its options '{}': {}", options, said));
    }
  }
  // Found only now: nothing is destroyed that was not created.
  if (make != nullptr)
    destroy = find_function<decltype(lumesh_sizing_destroy)>(handle, "lumesh_sizing_destroy");
}

PluginSizing::PluginSizing(std::string_view text)
    : library_(std::make_unique<Library>(split_plugin_name(text))) {}
PluginSizing::~PluginSizing() = default;

/// Counts a call, takes its time now and then, and stops exceptions.
template <class Call, class Answer>
Answer PluginSizing::ask(const Vec3& where, Answer no_answer, const Call& call) const {
  using Clock = std::chrono::steady_clock;
  const bool is_timed = counts_.add(kCalls, 1) % kTimedOf == kFirstTimed;
  const Clock::time_point start = is_timed ? Clock::now() : Clock::time_point();
  Answer answer = no_answer;
  try {
    answer = call();
  } catch (...) {
    counts_.add(kExceptions, 1);
    Thrown thrown{where};
    const std::string text = text_of(std::current_exception());
    std::copy_n(text.begin(), std::min(text.size(), thrown.text.size() - 1), thrown.text.begin());
    first_thrown_.offer(thrown);
  }
  if (is_timed) {
    counts_.add(kTimedCalls, 1);
    counts_.add(kNanoseconds,
                static_cast<std::uint64_t>(std::chrono::nanoseconds(Clock::now() - start).count()));
  }
  return answer;
}

double PluginSizing::size_at(const Vec3& point_mm, Label /*label*/) const {
  if (library_->size_at == nullptr) return kAnySize;
  const double size = ask(point_mm, kAnySize, [&] {
    return library_->size_at(library_->state, point_mm.x(), point_mm.y(), point_mm.z());
  });
  if (size > 0) return size;  // not NaN either
  counts_.add(kBadAnswers, 1);
  first_bad_.offer(point_mm);
  return kAnySize;
}

bool PluginSizing::wants_finer(const std::array<Vec3, 4>& corners_mm) const {
  if (library_->should_be_adapted == nullptr) return false;
  std::array<double, 12> points;
  for (std::size_t i = 0; i < 4; ++i)
    std::copy_n(corners_mm[i].data(), 3, points.begin() + 3 * static_cast<std::ptrdiff_t>(i));
  return ask(corners_mm[0], 0,
             [&] { return library_->should_be_adapted(library_->state, points.data(), 4); }) != 0;
}

bool PluginSizing::has_criterion() const {
  return library_->should_be_adapted != nullptr;
}

std::vector<std::string> PluginSizing::warnings() const {
  std::vector<std::string> lines;
  const std::string name = "plugin " + library_->path.filename().string();
  const std::uint64_t calls = counts_.total(kCalls);
  if (const auto point = first_bad_.get())
    lines.push_back(fmt::format("{}: {} of {} answers were NaN or not positive and were ignored; first at {}",
                                name, counts_.total(kBadAnswers), calls, point_text(*point)));
  if (const auto thrown = first_thrown_.get())
    lines.push_back(fmt::format("{}: {} of {} calls threw exceptions and were ignored; first at {}: {}", name,
                                counts_.total(kExceptions), calls, point_text(thrown->point),
                                first_line(thrown->text.data(), thrown->text.size())));
  const std::uint64_t timed = counts_.total(kTimedCalls);
  const double mean =
      timed == 0 ? 0 : static_cast<double>(counts_.total(kNanoseconds)) / static_cast<double>(timed);
  if (mean > kSlowNanoseconds)
    lines.push_back(
        fmt::format("{}: a call takes {:.1f} us (mean of {}), {} calls about {:.1f} s of all threads' time; "
                    "precompute what it needs in lumesh_sizing_create()",
                    name, mean * 1e-3, timed, calls, mean * 1e-9 * static_cast<double>(calls)));
  return lines;
}

}  // namespace lumesh
