// The OpenColorIO configuration in use: that of $OCIO if set, otherwise a small built-in one. It is looked up
// at every call, so there is no global state.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo {

// Identity of the configuration: "built-in", or the cache id of $OCIO's configuration, which covers the files
// it refers to. "unreadable: …" if $OCIO cannot be read. Nodes with color space parameters use it as the
// default of a parameter, so that it is part of the action key like any other input.
std::string color_config_id();

// Converts pixels in place from `colorspace` to scene-linear Rec. 709. `colorspace` is a name, alias or role,
// looked up in $OCIO's configuration first, then in the built-in one. Color spaces marked as data are not
// converted. Throws Error "unknown-colorspace", or "color-config" if $OCIO's configuration is invalid or has
// no such conversion.
void to_linear_rec709(Vec3f* pixels, std::size_t width, std::size_t height, const std::string& colorspace);

// Applies a view of $OCIO's configuration to scene-linear Rec. 709 in place. `view` is a view of its default
// display, "display/view", or empty for the default view. The result is scene-linear, within [0, 1], so that
// encoding it as sRGB yields the view's values. Throws Error "no-color-config" if $OCIO is not set,
// "unknown-view", "color-config".
void show_through_view(Vec3f* pixels, std::size_t width, std::size_t height, const std::string& view);

// The names accepted by to_linear_rec709.
std::vector<std::string> colorspace_names();

}  // namespace terrazzo
