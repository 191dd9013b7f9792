// The OpenColorIO configuration in force: the one that $OCIO names, else the small one built in. Looked up at
// every call, so that nothing here is global state.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "nodes/common/linear.h"

namespace terrazzo {

// "built-in", or what tells $OCIO's configuration from any other: its cache id, which covers the files it
// refers to. "unreadable: …" where $OCIO names none that can be read. A node that names colour spaces takes
// it as the default of a parameter, so that it enters the key like any other input.
std::string color_config_id();

// Converts in place from `colorspace` (a name, alias or role; looked up in $OCIO's configuration first, then
// in the built-in one) to scene-linear Rec. 709. Colour spaces marked as data are left as they are. Throws
// Error "unknown-colorspace", or "color-config" where $OCIO's configuration is broken or has no way there.
void to_linear_rec709(Vec3f* pixels, std::size_t width, std::size_t height, const std::string& colorspace);

// Shows scene-linear Rec. 709 through a view of $OCIO's configuration, in place: `view` is a view of its
// default display, "display/view", or empty for the default one. What comes out is scene-linear again, such
// that encoding it as sRGB gives the view's own values; within [0, 1]. Throws Error "no-color-config" where
// $OCIO is not set, "unknown-view", "color-config".
void show_through_view(Vec3f* pixels, std::size_t width, std::size_t height, const std::string& view);

// The names that to_linear_rec709 knows.
std::vector<std::string> colorspace_names();

}  // namespace terrazzo
