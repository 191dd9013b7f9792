// Pictures side by side, each with a line of words below.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo {

// The colour of a profile's id in pictures of labels: the same for the same id, far apart for neighbouring
// ones. 0 is binder.
Vec3f label_color(std::int32_t id);
// One section of the labels, at their own size.
Image picture_of(const Labels&, int section = 0);

struct SheetChoice {
  std::vector<std::string> captions;  // of the first pictures; may be fewer
  int columns = 0;                    // 0: about as many as rows
  int cell = 480;                     // pixels that a picture's longer side takes
  bool dark = false;
};

// The pictures' first sections, fitted into cells; rows and columns shrink to what they hold. Not empty.
Image contact_sheet(const std::vector<Image>&, const SheetChoice&, const Work& = {});

}  // namespace terrazzo
