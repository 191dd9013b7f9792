// Photographs of imaginary aggregates whose particles are known exactly.
#pragma once

#include <cstdint>
#include <optional>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::synthetic_photo {

enum class Scene {
  Any,      // each picture is one of the following
  Bank,     // stones in and on soil, from fine sand to boulders
  Heap,     // loose stones that lie on each other
  Section,  // a plane section: stones, chips, grains or bubbles in a binder
  Outcrop,  // a bank whose stones have about the colors of the soil; not among Any
  Alloy,    // a plane section of lobed grains that grew together, and fine ones; not among Any
};

struct PhotoOptions {
  Scene scene = Scene::Any;
  int pictures = 1;
  int width = 256, height = 256;  // pixels
  double pixel_size = 1;          // mm
  std::optional<double> fill;     // area fraction aimed at; none: 0.05 to 0.95
  bool objects = true;            // rulers, frames, captions and others in some pictures
  std::uint64_t seed = 1;
};

struct Photo {
  Image image;          // one section per picture
  Labels labels;        // the visible part of each particle that a person would outline
  Labels not_material;  // 1 where a ruler, frame, caption or the like covers the material
  Labels unclear;       // 1 on particles that are too small or too faint for a label
};

// Everything else about a picture (shapes, sizes, colors, textures, light, camera) is drawn from the seed and
// the picture's number. Particles with a visible area below 40 pixels (sections: 24), and those that hardly
// differ from what is around them, are not labeled.
Photo take_photo(const PhotoOptions&, const Work&);

}  // namespace terrazzo::synthetic_photo
