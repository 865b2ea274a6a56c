#include "output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "file_fault.hpp"
#include "lumesh/io/link_target.hpp"

namespace lumesh::io {

namespace fs = std::filesystem;

namespace {

/// Creates a file of a name that is not taken yet.
int open_new(const fs::path& target, std::string& name) {
  constexpr int kAttempts = 100;
  constexpr mode_t kMode = 0666;  // Narrowed by the user's umask.
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    name = fmt::format("{}.part-{}-{}", target.string(), ::getpid(), attempt);
    const int descriptor = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kMode);
    if (descriptor >= 0 || errno != EEXIST) return descriptor;
  }
  return -1;
}

}  // namespace

fs::path link_target(fs::path path) {
  constexpr int kMaxLinks = 40;  // As the kernel follows.
  std::error_code ignored;
  for (int links = 0; fs::is_symlink(path, ignored); ++links) {
    if (links == kMaxLinks) fail(path, "is a link that leads round in a circle; remove it");
    path = path.parent_path() / fs::read_symlink(path, ignored);
  }
  return path;
}

OutputFile::OutputFile(const fs::path& target) : target_(link_target(target)) {
  std::error_code ignored;
  const fs::file_status status = fs::status(target_, ignored);
  if (fs::is_directory(status)) fail("is a folder", 0);
  const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ignored)) fail(kNoFolder, 0);
  // Renaming over /dev/null would replace the device.
  const bool direct = fs::exists(status) && !fs::is_regular_file(status);
  descriptor_ = direct ? ::open(target_.c_str(), O_WRONLY | O_CLOEXEC) : open_new(target_, temporary_);
  if (descriptor_ < 0) {
    const int reason = errno;
    temporary_.clear();
    fail("cannot be written", reason);
  }
  // A read-only target in a writable folder would be replaced by the rename; its owner did not want that.
  if (!direct && fs::exists(status) && ::access(target_.c_str(), W_OK) != 0) {
    const int reason = errno;
    ::close(descriptor_);
    ::unlink(temporary_.c_str());
    fail("cannot be replaced", reason);
  }
  // Who was kept from reading it is kept from what replaces it.
  struct stat before = {};
  if (!direct && ::stat(target_.c_str(), &before) == 0)
    static_cast<void>(::fchmod(descriptor_, before.st_mode & (S_IRWXU | S_IRWXG | S_IRWXO)));
}

OutputFile::~OutputFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void OutputFile::write(const void* data, std::size_t bytes) {
  if (buffer_.size() + bytes > kBufferBytes) flush();
  const char* begin = static_cast<const char*>(data);
  if (bytes >= kBufferBytes) {
    write_through(begin, bytes);
  } else {
    buffer_.append(begin, begin + bytes);
  }
}

void OutputFile::flush() {
  write_through(buffer_.data(), buffer_.size());
  buffer_.clear();
}

void OutputFile::write_through(const char* data, std::size_t bytes) {
  flushed_ += bytes;
  while (bytes > 0) {
    const ssize_t written = ::write(descriptor_, data, bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("cannot be written", errno);
    data += written;
    bytes -= static_cast<std::size_t>(written);
  }
}

void OutputFile::commit() {
  flush();
  const int closed = ::close(descriptor_);
  const int reason = errno;
  descriptor_ = -1;
  const bool renamed =
      closed == 0 && (temporary_.empty() || ::rename(temporary_.c_str(), target_.c_str()) == 0);
  if (renamed) return;
  const int final_reason = closed == 0 ? errno : reason;
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  fail("cannot be written", final_reason);
}

void OutputFile::fail(std::string_view action, int error_number) const {
  std::string message(action);
  if (error_number != 0) message += fmt::format(" ({})", std::strerror(error_number));
  if (error_number == ENOSPC || error_number == EFBIG || error_number == EDQUOT)
    message += "; free some space";
  io::fail(target_, message);
}

}  // namespace lumesh::io
