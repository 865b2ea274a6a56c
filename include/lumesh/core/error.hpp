#pragma once
/// @file The one exception type of the library, for faults of the user's input.

#include <stdexcept>
#include <string>

namespace lumesh {

/// Kind of a fault.
enum class ErrorKind {
  kUsage,       ///< Wrong option or value of one.
  kBadInput,    ///< A file or a data set is missing, broken or unsuitable, or output cannot be written.
  kNotReached,  ///< The request could not be met (quality floor, lost label).
  kTimeLimit,   ///< Told to stop, by a time limit or a signal. Programs throw it, the library Cancelled.
  kMemory,      ///< The request needs more memory than there is.
};

/// A fault the user can put right: the message is one line that says what, where, and what to do.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  [[nodiscard]] ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

/// Result of body(), whose errors name what it is about.
template <class Body>
auto naming(const std::string& name, const Body& body) {
  try {
    return body();
  } catch (const Error& error) {
    throw Error(error.kind(), name + ": " + error.what());
  }
}

}  // namespace lumesh
