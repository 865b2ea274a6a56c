#pragma once
/// @file Commands for every frame of an image, one after the other.

#include <memory>
#include <string>
#include <vector>

#include "common.hpp"
#include "lumesh/io/mesh_file.hpp"
#include "lumesh/stages/input.hpp"

namespace lumesh::cli {

/// The name of an output of one frame: with the frame's number for "%d" or "%03d" in it, else behind the
/// name.
[[nodiscard]] std::string numbered(const std::string& path, std::size_t frame);

/// What differs between the frames of a command, and the image that has them.
struct FrameParts {
  ImageSelection* selection;
  std::string image;
  std::vector<std::string*> outputs;
};

/// Calls run(command) once, or, where all frames are wanted, for each frame of the image.
/// @param command  Has frames().
template <class Command>
void run_frames(Command command) {
  const FrameParts first = command.frames();
  if (!first.selection->all_frames || is_mesh_file(first.image)) return run(command);
  const std::size_t count = count_frames(first.image);
  JsonArray array;
  const auto openings = std::make_shared<std::vector<Opening>>();
  for (std::size_t frame = 0; frame < count; ++frame) {
    Command one = command;
    one.run.json_array = &array;
    const FrameParts parts = one.frames();
    parts.selection->all_frames = false;
    parts.selection->frame = static_cast<double>(frame);
    parts.selection->openings_of_frames = openings;
    for (std::string* output : parts.outputs) *output = numbered(*output, frame);
    run(one);
  }
}

}  // namespace lumesh::cli
