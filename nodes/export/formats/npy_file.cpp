#include "nodes/export/formats/npy_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "nodes/common/io/checked_file.h"
#include "nodes/data/indices.h"

namespace terrazzo::exporting {
namespace {

std::string npy_header(const char* type, bool fortran_order, const std::string& shape) {
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': ({}), }}", type,
                                 fortran_order ? "True" : "False", shape);
  while ((10 + text.size() + 1) % 64 != 0) text += ' ';  // so that the data is aligned
  text += '\n';
  const unsigned size = text.size();
  return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(size & 255) + static_cast<char>(size >> 8) +
         text;
}

}  // namespace

void write_npy(const std::filesystem::path& path, const VoxelSource& source, const VoxelBox& box,
               const Work& work) {
  const int c = source.components();
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    out << npy_header(
        source.whole() ? "<i4" : "<f4", true,
        fmt::format("{}, {}, {}{}", box.size.x(), box.size.y(), box.size.z(), c > 1 ? ", 3" : ""));
    const int batch = std::clamp<std::size_t>((std::size_t{1} << 24) / box.plane(), 1, 1 << 20);
    std::vector<std::uint32_t> voxels(box.plane() * (std::min(batch, box.size.z()) * c));
    std::vector<std::uint32_t> one;  // one component of a vector: components are the slowest index
    for (int k = 0; k < c; ++k)
      for (int z = 0; z < box.size.z(); z += batch) {
        const int end = std::min(z + batch, box.size.z());
        const std::size_t count = box.plane() * (end - z);
        work.quiet().parallel(end - z, 1, [&](std::size_t a, std::size_t b) {
          source.read(z + static_cast<int>(a), z + static_cast<int>(b), voxels.data() + a * box.plane() * c);
        });
        const std::uint32_t* data = voxels.data();
        if (c > 1) {
          one.resize(count);
          for (std::size_t i = 0; i < count; ++i) one[i] = voxels[i * c + k];
          data = one.data();
        }
        out.write(reinterpret_cast<const char*>(data), 4 * count);
        work.progress((k + double(end) / box.size.z()) / c);
      }
  });
}

void write_npy(const std::filesystem::path& path, const Labels& labels) {
  const std::size_t count = pixels_in(labels.width, labels.height) * labels.sections;
  if (count == 0 || labels.ids.size() != count) throw Error("empty-labels", "the labels have no pixels");
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    out << npy_header("<i4", false, fmt::format("{}, {}, {}", labels.sections, labels.height, labels.width));
    out.write(reinterpret_cast<const char*>(labels.ids.data()), 4 * count);
  });
}

}  // namespace terrazzo::exporting
