#include "lumesh/io/text_file.hpp"

#include "output_file.hpp"
#include "text_scanner.hpp"

namespace lumesh {

void write_text_file(const std::filesystem::path& path, std::string_view content) {
  io::OutputFile file(path);
  file.write(content);
  file.commit();
}

std::string read_text_file(const std::filesystem::path& path) {
  return io::read_whole_file(path);
}

}  // namespace lumesh
