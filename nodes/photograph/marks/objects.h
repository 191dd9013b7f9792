// What in a photograph is found to show no material: captions and rulers.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/photograph/marks/ignored.h"
#include "nodes/photograph/marks/ruler.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// Something that is not material, in pixels from the upper left corner of a section.
struct FoundObject {
  // Caption and Ruler: found by their marks. Other: by the network, a ruler, frame, chart or text.
  enum class Kind { Caption, Ruler, Other } kind = Kind::Other;
  int section = 0;
  int left = 0, top = 0, right = 0, bottom = 0;  // first and last column and row
  std::int64_t pixels = 0;
  std::optional<ScaleMark> scale = {};
};

// Finds captions (captions.h) and rulers (scales.h) in all sections and adds their pixels to `ignored`.
// Throws Error "empty-image" if no pixel is left.
std::vector<FoundObject> find_objects(const Image&, IgnoredPixels& ignored, const Work&);

// Adds the objects that the network recognizes in one section to `ignored` and to `objects`, unless they are
// so small or so doubtful that they may be a mistake: an overlooked ruler shows, but particles that are left
// out by mistake do not. `not_material`: how likely each pixel of the section shows one. The convex hull of
// an object belongs to it if it fills most of that, so the letters of a caption do; a frame fills little.
void add_objects_of_network(const std::vector<float>& not_material, int section, const Image&,
                            IgnoredPixels& ignored, std::vector<FoundObject>& objects);

}  // namespace terrazzo::segment
