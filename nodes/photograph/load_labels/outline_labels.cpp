#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/common/io/outlines/outline_file.h"
#include "nodes/photograph/load_labels/label_file.h"

namespace terrazzo::load_labels {
namespace {

void take_size(OutlineFile& outlines, const Image* picture, const std::string& file) {
  if (!picture && outlines.width == 0)
    throw Error("missing-input", fmt::format("'{}' does not say how large its picture is", file),
                "connect the picture to the input image")
        .parameter("path");
  if (!picture) return;
  if (outlines.width > 0 && (outlines.width != picture->width || outlines.height != picture->height))
    throw Error("size-mismatch",
                fmt::format("the outlines of '{}' are of a picture of {} × {} pixels, but the connected one "
                            "has {} × {}",
                            file, outlines.width, outlines.height, picture->width, picture->height),
                "use the outlines of this picture")
        .parameter("path");
  outlines.width = picture->width;
  outlines.height = picture->height;
}

}  // namespace

Labels labels_from_outlines(const std::vector<std::filesystem::path>& files, const Image* picture,
                            double pixel_size, const Reading& reading) {
  Labels out;
  out.sections = 0;
  out.pixel_size = pixel_size;
  for (const auto& path : files) {
    OutlineFile outlines = read_outline_file(path, reading);
    const std::string file = path.string();
    take_size(outlines, picture, file);
    require_simple(outlines, file);
    if (!out.ids.empty() && (outlines.width != out.width || outlines.height != out.height))
      throw Error("size-mismatch",
                  fmt::format("'{}' is of a picture of {} × {} pixels, but the files before it of {} × {}",
                              file, outlines.width, outlines.height, out.width, out.height),
                  "all sections of a stack must have the same size and scale")
          .parameter("path");
    if (out.pixel_size == 0) out.pixel_size = outlines.pixel_size;
    out.width = outlines.width;
    out.height = outlines.height;
    if (picture && files.size() == 1) outlines.sections = std::max(outlines.sections, picture->sections);
    require_memory(8.0 * out.width * out.height * outlines.sections, reading.memory,
                   "the labels of '" + file + "'");
    // Labels are numbered by section.
    std::stable_sort(outlines.outlines.begin(), outlines.outlines.end(),
                     [](const FileOutline& a, const FileOutline& b) { return a.section < b.section; });
    const std::int32_t before = out.count();
    for (const std::int32_t id : raster_of(outlines, file)) out.ids.push_back(id == 0 ? 0 : id + before);
    for (const FileOutline& o : outlines.outlines) out.classes.push_back(o.cls);
    out.sections += outlines.sections;
  }
  if (out.pixel_size == 0) out.pixel_size = 1;
  if (picture && out.sections != picture->sections)
    throw Error("size-mismatch",
                fmt::format("the outlines are of {} sections, but the picture has {}", out.sections,
                            picture->sections),
                "use the outlines of this picture")
        .parameter("path");
  return out;
}

}  // namespace terrazzo::load_labels
