#include "lumesh/io/text_file.hpp"

#include "output_file.hpp"

namespace lumesh {

void write_text_file(const std::filesystem::path& path, std::string_view content) {
  io::OutputFile file(path);
  file.write(content);
  file.commit();
}

}  // namespace lumesh
