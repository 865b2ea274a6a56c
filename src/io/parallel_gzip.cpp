#include "parallel_gzip.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <vector>

#include "lumesh/core/assert.hpp"
#include "lumesh/parallel/loops.hpp"

namespace lumesh::io {

namespace {

constexpr std::size_t kGzipBlockBytes = std::size_t{1} << 20;
constexpr std::size_t kBlocksAtOnce = 64;
constexpr int kLevel = 3;

struct Packed {
  std::vector<unsigned char> bytes;
  uLong crc = 0;
};

/// Raw deflate of one block. All but the last end with an empty stored block, on a byte border, so that
/// blocks can be joined (as pigz does).
Packed pack(const std::vector<std::byte>& raw, int flush) {
  Packed packed;
  const auto* in = reinterpret_cast<const Bytef*>(raw.data());
  packed.crc = crc32_z(crc32_z(0, nullptr, 0), in, raw.size());
  z_stream stream = {};
  constexpr int kRawWindow = -15;
  constexpr int kMemory = 9;
  LUMESH_ASSERT(deflateInit2(&stream, kLevel, Z_DEFLATED, kRawWindow, kMemory, Z_DEFAULT_STRATEGY) == Z_OK);
  constexpr std::size_t kFlushBytes = 16;
  packed.bytes.resize(deflateBound(&stream, static_cast<uLong>(raw.size())) + kFlushBytes);
  stream.next_in = const_cast<Bytef*>(in);  // zlib's interface; it does not write there.
  stream.avail_in = static_cast<uInt>(raw.size());
  stream.next_out = packed.bytes.data();
  stream.avail_out = static_cast<uInt>(packed.bytes.size());
  const int code = deflate(&stream, flush);
  LUMESH_ASSERT(code == Z_OK || code == Z_STREAM_END);
  LUMESH_ASSERT(stream.avail_in == 0);
  packed.bytes.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

void write_little_endian(OutputFile& file, std::uint32_t value) {
  const std::array<unsigned char, 4> bytes = {
      static_cast<unsigned char>(value), static_cast<unsigned char>(value >> 8U),
      static_cast<unsigned char>(value >> 16U), static_cast<unsigned char>(value >> 24U)};
  file.write(bytes.data(), bytes.size());
}

}  // namespace

void write_gzip(OutputFile& file, std::size_t bytes,
                const std::function<void(std::size_t, std::size_t, std::byte*)>& fill) {
  constexpr std::array<unsigned char, 10> kHeader = {0x1f, 0x8b, Z_DEFLATED, 0, 0, 0, 0, 0, 0, 0xff};
  file.write(kHeader.data(), kHeader.size());
  const std::size_t blocks = std::max<std::size_t>(1, (bytes + kGzipBlockBytes - 1) / kGzipBlockBytes);
  uLong crc = crc32_z(0, nullptr, 0);
  for (std::size_t first = 0; first < blocks; first += kBlocksAtOnce) {
    std::vector<Packed> wave(std::min(kBlocksAtOnce, blocks - first));
    parallel::for_each_index(wave.size(), 1, [&](std::size_t i) {
      const std::size_t begin = (first + i) * kGzipBlockBytes;
      const std::size_t end = std::min(bytes, begin + kGzipBlockBytes);
      std::vector<std::byte> raw(end - begin);
      fill(begin, end, raw.data());
      wave[i] = pack(raw, first + i + 1 == blocks ? Z_FINISH : Z_SYNC_FLUSH);
    });
    for (std::size_t i = 0; i < wave.size(); ++i) {
      file.write(wave[i].bytes.data(), wave[i].bytes.size());
      const std::size_t begin = (first + i) * kGzipBlockBytes;
      crc = crc32_combine(crc, wave[i].crc,
                          static_cast<z_off_t>(std::min(bytes, begin + kGzipBlockBytes) - begin));
    }
  }
  write_little_endian(file, static_cast<std::uint32_t>(crc));
  write_little_endian(file, static_cast<std::uint32_t>(bytes));
}

}  // namespace lumesh::io
