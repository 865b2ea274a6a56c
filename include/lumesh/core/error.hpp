#pragma once
/// @file The one exception type of the library, for faults of the user's input, and the program's exit codes.

#include <stdexcept>
#include <string>

namespace lumesh {

/// What went wrong; the values are the exit codes of the program.
enum class ErrorKind : int {
  kUsage = 1,       ///< Wrong command line or option value.
  kBadInput = 2,    ///< A file or a data set is missing, broken or unsuitable, or output cannot be written.
  kNotReached = 3,  ///< The request could not be met (quality floor, lost label).
  kTimeLimit = 4,   ///< Time limit reached or interrupted; the best valid mesh was written.
  kMemory = 5,      ///< The request needs more memory than there is.
};

/// A fault the user can mend: the message is one line that says what, where, and what to do.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  [[nodiscard]] ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

/// What body() returns; its errors name what it is about.
template <class Body>
auto naming(const std::string& name, const Body& body) {
  try {
    return body();
  } catch (const Error& error) {
    throw Error(error.kind(), name + ": " + error.what());
  }
}

}  // namespace lumesh
