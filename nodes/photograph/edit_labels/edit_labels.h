// Corrections of labels, written as data.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/labels.h"
#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::edit_labels {

// One correction. It addresses particles by points in the picture, in pixels from the upper left corner, y
// down, and so survives a new segmentation.
struct Edit {
  enum class Kind {
    Merge,    // the particles at the points become one
    Split,    // the polyline cuts the particle that it crosses most
    Delete,   // the particles at the points become binder
    Outline,  // the polygon becomes a new particle
    Ignore,   // the rectangle (two points) or polygon shows no material
  } kind = Kind::Merge;
  int section = 0;
  std::vector<Vec2> points;
};

// Reads "KIND x y x y …", after "SECTION:" if the labels have several: "merge 10 12 30 14", "2: delete 5 5".
// Throws Error "bad-value" for the parameter `edits`.
Edit read_edit(const std::string& text);

struct Edited {
  Labels labels;        // numbered from 1 by their first pixel, section after section; classes are kept
  Labels not_material;  // 1 where an edit says so
  std::vector<std::string> warnings;  // edits that don't apply, by their number from 1
};

// Applies the edits in order. Throws Error "bad-labels" if a label is negative or has no class.
Edited apply_edits(const Labels&, const std::vector<Edit>&, const Work&);

}  // namespace terrazzo::edit_labels
