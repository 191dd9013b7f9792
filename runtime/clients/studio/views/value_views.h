// Values in the forms that the page draws.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/clients/studio/views/geometry_views.h"
#include "runtime/value.h"

namespace terrazzo::studio {

struct ValueView {
  std::string type;  // media type
  std::string body;
};

// `as`: "summary": JSON, with lists cut to their first entries. "json": all of it.
// "pixels": of an Image, or of Labels in colors: five 32-bit little-endian integers (width, height, sections,
// full width, full height), then sRGB as RGBA. "ids": of Labels: the same head, then 32-bit profile numbers.
// "outlines": of Profiles: JSON with the outlines of a section in mm.
// "picture": of Particles, Shapes and Volumes, as pixels: see solid_picture.h.
// "particles", "meshes", "head", "slice", "voxels": see geometry_views.h.
// Throws Error "bad-request" if the type has no such view, "too-large" if it would be.
struct ViewOptions {
  // Pixels, or voxels, on the longest edge, beyond which they are reduced by a whole factor. Of meshes,
  // triangles.
  int most = 2048;
  Slice slice = {};    // its index is also the section of a stack
  Value shapes = {};   // of particles, for "picture"
  double azimuth = 0;  // degrees
};
ValueView view_of(const Value&, const std::string& as, const ViewOptions& = {});

}  // namespace terrazzo::studio
