#pragma once
/// @file Image files that are written byte by byte and read, with the warnings.

#include <gtest/gtest.h>
#include <zlib.h>

#include <string>
#include <vector>

#include "image_bytes.hpp"
#include "io_fixtures.hpp"
#include "lumesh/io/image_file.hpp"

namespace lumesh::fixtures {

/// As MetaIO packs voxels.
inline std::string zlib_packed(const std::string& text) {
  std::string out(text.size() + 1024, '\0');
  uLongf bytes = out.size();
  EXPECT_EQ(compress(reinterpret_cast<Bytef*>(out.data()), &bytes,
                     reinterpret_cast<const Bytef*>(text.data()), text.size()),
            Z_OK);
  out.resize(bytes);
  return out;
}

inline std::string deflated(const std::string& text) {
  std::string out(text.size() + 1024, '\0');
  z_stream stream = {};
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string in = text;
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

class ImageReading : public testing::Test {
 protected:
  LabelImage read(const std::string& name, const std::string& content, const ImageReadOptions& options = {}) {
    return read_image(write_file(folder_ / name, content), options, context_);
  }
  TemporaryFolder folder_;
  std::vector<std::string> warnings_;
  Context context_{{}, [this](std::string_view text) { warnings_.emplace_back(text); }};
};

}  // namespace lumesh::fixtures
