// An image file to paint on.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/common/io/image_file.h"
#include "tests/support/run_node.h"

namespace terrazzo::test {

// 96 × 80 pixels of fat with a red disc of radius 12 at (60, 40), as a PNG.
inline std::filesystem::path paint_picture() {
  Image image =
      run_node("Pattern", {},
               {{"kind", "fat"}, {"axis", "z"}, {"scale", "0.8"}, {"width", "96"}, {"height", "80"}})
          .output<Image>("image");
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 96; ++x)
      if (Vec2(x + 0.5 - 60, y + 0.5 - 40).norm() < 12) image.at(x, y) = Vec3f(0.7f, 0.02f, 0.02f);
  const auto file = temporary_folder() / "fat \"quoted\" ü.png";
  write_image(file, image);
  return file;
}

}  // namespace terrazzo::test
