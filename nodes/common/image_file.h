// Pictures from and to files: OpenImageIO for the formats, OpenColorIO for the colour spaces.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/common/reading.h"
#include "nodes/data/image.h"

namespace terrazzo {

// Reads one picture as scene-linear Rec. 709. `colorspace`: an OpenColorIO name, or "auto": sRGB for 8 and 16
// bit formats, scene-linear for float ones. Grey becomes three equal channels; alpha is composited over
// black. A file that was cut short is an error; what its decoder complains about is a warning. Throws Error
// "unreadable-image", "too-large", and "bad-pixels" if there is NaN or infinity.
Image read_image(const std::filesystem::path&, const std::string& colorspace = "auto", double pixel_size = 1,
                 const Reading& = {});

// Writes by extension: .exr and .hdr stay scene-linear, others become sRGB, dithered to 8 bit (16 bit for
// .tif). A stack is written as one file a section by the caller. `provenance` goes into the metadata where
// the format has room.
void write_image(const std::filesystem::path&, const Image&, int section = 0,
                 const std::string& provenance = {});

}  // namespace terrazzo
