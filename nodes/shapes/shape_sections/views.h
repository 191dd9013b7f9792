// Images of shapes from three sides.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape_sections {

// One row of three orthographic views per shape, along its principal axes (the longest is horizontal in the
// first two), shaded gray with one lamp on white, each in a cell of `cell` pixels; all at one scale.
Image views_of(const Shapes&, int cell, const Work& = {});

// Columns: principal axes of the enclosed volume by decreasing spread, a rotation.
Mat3 volume_axes(const Mesh&);

}  // namespace terrazzo::shape_sections
