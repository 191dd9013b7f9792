// Images side by side, each with a one-line caption below.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::contact_sheet {

// Color of a profile id in images of labels: always the same for one id, clearly different for neighboring
// ids. Id 0 is binder.
Vec3f label_color(std::int32_t id);
// One section of the labels, one pixel per label.
Image picture_of(const Labels&, int section = 0);

enum class Background { Light, Dark };

struct SheetOptions {
  std::vector<std::string> captions;  // of the first images; may be fewer
  int columns = 0;                    // 0: one row for up to three images, else about as many columns as rows
  int cell = 480;                     // length of each image's longer side, pixels
  Background background = Background::Light;
};

// Scales the first section of each image to the cell size. Rows and columns shrink to fit their images. The
// list must not be empty.
Image contact_sheet(const std::vector<Image>&, const SheetOptions&, const Work& = {});

}  // namespace terrazzo::contact_sheet
