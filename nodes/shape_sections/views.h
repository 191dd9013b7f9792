// Shapes as seen from three sides.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape_sections {

// A row of three orthographic views a shape, along its principal axes (the longest lies across the first two
// pictures), grey under one lamp on white, each in a cell of `cell` pixels; all at one scale.
Image views_of(const Shapes&, int cell, const Work& = {});

// Columns: principal axes of the enclosed volume by falling spread, a rotation.
Mat3 volume_axes(const Mesh&);

}  // namespace terrazzo::shape_sections
