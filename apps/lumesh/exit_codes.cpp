#include "exit_codes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>

namespace lumesh::cli {

namespace {

struct ExitCode {
  ErrorKind kind;
  int code;
  const char* meaning;
};

constexpr ExitCode kExitCodes[] = {
    {ErrorKind::kUsage, 1, "wrong command line or option value"},
    {ErrorKind::kBadInput, 2, "input missing, broken or unsuitable, or output that cannot be written"},
    {ErrorKind::kNotReached, 3, "request not reached, or the mesh is invalid"},
    {ErrorKind::kTimeLimit, 4, "time limit or interrupted"},
    {ErrorKind::kMemory, 5, "too little memory"},
};

}  // namespace

int exit_code_of(ErrorKind kind) {
  return std::find_if(std::begin(kExitCodes), std::end(kExitCodes),
                      [&](const ExitCode& one) { return one.kind == kind; })
      ->code;
}

std::string exit_codes_text() {
  std::string text = "Exit codes: 0 good";
  for (const ExitCode& one : kExitCodes) text += fmt::format(", {} {}", one.code, one.meaning);
  return text + fmt::format(", {} a fault of lumesh.", kInternalError);
}

}  // namespace lumesh::cli
