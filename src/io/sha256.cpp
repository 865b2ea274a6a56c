#include "lumesh/io/sha256.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <cstddef>
#include <fstream>
#include <memory>

#include "file_fault.hpp"
#include "lumesh/core/assert.hpp"

namespace lumesh {

namespace {

/// The hash of bytes that come in parts.
class Hash {
 public:
  Hash() : state_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    const int begun = EVP_DigestInit_ex(state_.get(), EVP_sha256(), nullptr);
    LUMESH_ASSERT(begun == 1);
  }
  void add(std::string_view bytes) {
    const int added = EVP_DigestUpdate(state_.get(), bytes.data(), bytes.size());
    LUMESH_ASSERT(added == 1);
  }
  [[nodiscard]] std::string hexadecimal() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned bytes = 0;
    const int ended = EVP_DigestFinal_ex(state_.get(), digest.data(), &bytes);
    LUMESH_ASSERT(ended == 1);
    return fmt::format("{:02x}", fmt::join(digest.data(), digest.data() + bytes, ""));
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> state_;
};

}  // namespace

std::string file_sha256(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return "";  // a DICOM series has no single hash
  io::check_file(path);
  std::ifstream in(path, std::ios::binary);
  std::array<char, 1U << 16> buffer{};
  Hash hash;
  do {
    in.read(buffer.data(), buffer.size());
    hash.add({buffer.data(), static_cast<std::size_t>(in.gcount())});
  } while (in);
  return hash.hexadecimal();
}

std::string text_sha256(std::string_view text) {
  Hash hash;
  hash.add(text);
  return hash.hexadecimal();
}

}  // namespace lumesh
