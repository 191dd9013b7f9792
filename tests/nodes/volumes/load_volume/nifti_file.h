// Writes NIfTI files with any content for tests, as single files or as pairs of header and voxels.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace terrazzo::test {

// A NIfTI 1 header in the standard's layout, for one volume of 16-bit integers or floats.
struct NiftiFile {
  std::vector<std::int16_t> dim = {3, 3, 2, 2, 1, 1, 1, 1};
  std::int16_t datatype = 4, bits = 16, qform = 0, sform = 0;
  std::vector<float> pixdim = {1, 0.5f, 0.5f, 4, 0, 0, 0, 0};
  float slope = 1, intercept = 0;
  char units = 2;
  std::vector<float> srow = std::vector<float>(12);
  bool swapped = false;
  std::string data;
  float voxels_at = 352;
  std::string magic = std::string("n+1\0", 4);

  template <class T>
  void put(std::string& b, std::size_t at, T v) const {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &v, sizeof(T));
    if (swapped) std::reverse(bytes, bytes + sizeof(T));
    b.replace(at, sizeof(T), bytes, sizeof(T));
  }
  std::filesystem::path write(const std::filesystem::path& path) const {
    std::string b(352, '\0');
    put<std::int32_t>(b, 0, 348);
    for (int i = 0; i < 8; ++i) {
      put(b, 40 + 2 * i, dim[i]);
      put(b, 76 + 4 * i, pixdim[i]);
    }
    put(b, 70, datatype);
    put(b, 72, bits);
    put<float>(b, 108, voxels_at), put(b, 112, slope), put(b, 116, intercept);
    b[123] = units;
    put(b, 252, qform);
    put(b, 254, sform);
    for (int i = 0; i < 12; ++i) put(b, 280 + 4 * i, srow[i]);
    b.replace(344, 4, magic);
    std::ofstream(path, std::ios::binary) << b << data;
    return path;
  }
  // Writes the .hdr to `header` and the voxels to `voxels`.
  void write_pair(const std::filesystem::path& header, const std::filesystem::path& voxels) const {
    NiftiFile pair = *this;
    pair.voxels_at = 0;
    pair.data.clear();
    pair.magic = std::string("ni1\0", 4);
    pair.write(header);
    std::ofstream(voxels, std::ios::binary) << data;
  }
  template <class T>
  void fill(std::size_t n, T (*value)(std::size_t)) {
    for (std::size_t i = 0; i < n; ++i) {
      std::string b(sizeof(T), '\0');
      put(b, 0, value(i));
      data += b;
    }
  }
  // 3 × 2 × 2 voxels: 0, 10, 20 and so on.
  static NiftiFile counting() {
    NiftiFile n;
    n.fill<std::int16_t>(12, [](std::size_t i) { return static_cast<std::int16_t>(10 * i); });
    return n;
  }
};

}  // namespace terrazzo::test
