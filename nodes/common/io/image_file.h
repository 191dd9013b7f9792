// Image files: OpenImageIO for the formats, OpenColorIO for the color spaces.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "nodes/common/io/picture_pages.h"
#include "nodes/common/io/pictures/pixel_scale.h"
#include "nodes/common/io/reading.h"
#include "nodes/data/image.h"

namespace terrazzo {

// Reads one picture of a file as scene-linear Rec. 709. `colorspace` is an OpenColorIO name, or "auto": what
// the file states (an ICC profile, PNG's chunks, EXIF, OpenEXR's chromaticities), else sRGB for 8 and 16 bit
// formats and scene-linear for float formats. Gray becomes three equal channels; alpha is composited over
// black. A truncated file is an error; other messages of the decoder become warnings. `sizes`, if not null,
// receives what the metadata state about the size of a pixel and the field of view. Throws Error
// "unreadable-image", "unsupported-image", "too-large", "several-pages" and "several-channels" if the choice
// is open, "bad-color-profile", and "bad-pixels" for NaN or infinity.
Image read_image(const std::filesystem::path&, const std::string& colorspace = "auto", double pixel_size = 1,
                 const Reading& = {}, StatedSizes* sizes = nullptr, const PageOptions& = {});

// Writes one section; the extension determines the format. .exr and .hdr are scene-linear floats; other
// formats are sRGB, dithered to 8 bits (.tif: 16 bits). `provenance` is stored in the metadata if the format
// supports it. Throws Error "empty-image", "bad-pixels" for NaN, "unwritable-image".
void write_image(const std::filesystem::path&, const Image&, int section = 0,
                 const std::string& provenance = {});

}  // namespace terrazzo
