#include "lumesh/io/image_file.hpp"

#include <gtest/gtest.h>

namespace lumesh {
namespace {

TEST(ImageFile, Placeholder) {
  Context context;
  const LabelImage image =
      read_image(LUMESH_SHARED_DATA "/aneurism/aneurism_x2_crop_sac_label.nrrd", {}, context);
  EXPECT_EQ(image.frame().size, Index3(144, 144, 144));
}

}  // namespace
}  // namespace lumesh
