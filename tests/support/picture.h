// Writes picture files with any number of channels and attributes, as other programs do.
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

#include "nodes/common/io/pictures/picture_codec.h"

namespace terrazzo::test {

// `samples` have the type of the encoding.
void write_picture(const std::filesystem::path&, const PictureEncoding&, const void* samples);

template <class T>
void write_picture(const std::filesystem::path& path, int width, int height, int channels, Sample type,
                   const std::vector<T>& samples, PictureAttributes attributes = {}) {
  write_picture(path, {width, height, channels, -1, type, std::move(attributes)}, samples.data());
}

}  // namespace terrazzo::test
