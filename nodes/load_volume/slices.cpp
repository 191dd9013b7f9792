#include <fmt/format.h>

#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/io/picture_input.h"
#include "nodes/load_volume/scan.h"

namespace terrazzo::load_volume {
namespace {

// OpenImageIO normalizes integers by the largest value of their type. Multiplying by it restores the stored
// number.
double largest(Sample sample) {
  switch (sample) {
    case Sample::UInt8:
      return 255;
    case Sample::Int8:
      return 127;
    case Sample::UInt16:
      return 65535;
    case Sample::Int16:
      return 32767;
    case Sample::UInt32:
      return 4294967295.0;
    case Sample::Int32:
      return 2147483647.0;
    default:
      return 0;
  }
}

// Appends the pages of one file, bottom row first.
void append(const std::filesystem::path& path, LoadedScan& scan, const Work& work, const Reading& reading) {
  PictureInput in(path, reading, {{"oiio:RawColor", 1}, {"oiio:UnassociatedAlpha", 1}});
  for (int page = 0; in.seek(page); ++page) {
    work.check();
    const PictureHeader spec = in.header();
    if (scan.size.z() == 0) scan.size = Vec3i(spec.width, spec.height, 0);
    if (spec.width != scan.size.x() || spec.height != scan.size.y())
      throw Error("size-mismatch",
                  fmt::format("'{}' is {} × {} pixels, the first image {} × {}", path.string(), spec.width,
                              spec.height, scan.size.x(), scan.size.y()),
                  "all slices of a volume must have the same size");
    const double count = double(spec.width) * spec.height * std::max(1, spec.depth) * (scan.size.z() + 1.0);
    if (count > 2147483648.0) throw Error("too-large", "'" + path.string() + "' has more than 2^31 voxels");
    // The list of voxels may exist twice while it grows.
    const auto pixels = in.samples<double>(Sample::Double, 3.0 * sizeof(float) * (scan.size.z() + 1.0));
    const double top = largest(spec.sample);
    for (int y = spec.height - 1; y >= 0; --y)
      for (int x = 0; x < spec.width; ++x) {
        const double* p = &pixels[(static_cast<std::size_t>(y) * spec.width + x) * spec.count()];
        if (spec.count() >= 3 && (p[0] != p[1] || p[0] != p[2]))
          throw Error("not-a-volume", "'" + path.string() + "' is a color image",
                      "a volume needs one number per voxel: convert the images to gray");
        scan.values.push_back(static_cast<float>(top > 0 ? std::round(p[0] * top) : p[0]));
      }
    ++scan.size.z();
  }
}

}  // namespace

LoadedScan read_slices(const std::vector<std::filesystem::path>& paths, const Work& work,
                       const Reading& reading) {
  LoadedScan scan;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    append(paths[i], scan, work, reading);
    work.progress(static_cast<double>(i + 1) / static_cast<double>(paths.size()));
  }
  return scan;
}

}  // namespace terrazzo::load_volume
