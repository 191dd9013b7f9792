#include "tests/support/picture.h"

#include <fstream>

namespace terrazzo::test {

void write_picture(const std::filesystem::path& path, const PictureEncoding& encoding, const void* samples) {
  const std::string bytes = picture_codec().encode(path, encoding, samples);
  if (!bytes.empty()) std::ofstream(path, std::ios::binary) << bytes;
}

}  // namespace terrazzo::test
