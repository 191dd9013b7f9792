// Values in the forms that the page draws.
#pragma once

#include <cstdint>
#include <string>

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
// Pictures of more than `most` pixels on their longer edge are reduced by a whole factor. Throws Error
// "bad-request" if the type has no such view, "too-large" if JSON would be.
ValueView view_of(const Value&, const std::string& as, int section = 0, int most = 2048);

}  // namespace terrazzo::studio
