#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/common/io/outlines/outline_file.h"
#include "nodes/photograph/load_labels/label_file.h"

namespace terrazzo::load_labels {
Labels labels_from_outlines(const std::vector<std::filesystem::path>& files, const Image* picture,
                            double pixel_size, const Reading& reading, const Work& work) {
  Labels out;
  double first_scale = 0;  // mm; 0: no file has said one
  out.sections = 0;
  out.pixel_size = pixel_size;
  for (const auto& path : files) {
    OutlineFile outlines =
        read_outline_file(path, reading, work, picture ? picture->georeference : MapPlace());
    const std::string file = path.string();
    if (picture)
      take_picture(outlines, *picture, files.size() == 1, file);
    else if (outlines.width == 0)
      throw Error("missing-input", fmt::format("'{}' does not say how large its picture is", file),
                  "connect the picture to the input image")
          .parameter("path");
    if (!out.ids.empty() && (outlines.width != out.width || outlines.height != out.height))
      throw Error("size-mismatch",
                  fmt::format("'{}' is of a picture of {} × {} pixels, but the files before it of {} × {}",
                              file, outlines.width, outlines.height, out.width, out.height),
                  "all sections of a stack must have the same size and scale")
          .parameter("path");
    if (first_scale == 0) first_scale = outlines.pixel_size;
    if (pixel_size == 0 && outlines.pixel_size > 0 && outlines.pixel_size != first_scale)
      throw Error("size-mismatch",
                  fmt::format("'{}' has pixels of {:.6g} mm, but the files before it of {:.6g} mm", file,
                              outlines.pixel_size, first_scale),
                  "all sections of a stack must have the same size and scale")
          .parameter("path");
    out.width = outlines.width;
    out.height = outlines.height;
    require_memory(8.0 * out.width * out.height * outlines.sections, reading.memory,
                   "the labels of '" + file + "'");
    // Labels are numbered by section.
    std::stable_sort(outlines.outlines.begin(), outlines.outlines.end(),
                     [](const FileOutline& a, const FileOutline& b) { return a.section < b.section; });
    const std::int32_t before = out.count();
    for (const std::int32_t id : raster_of(outlines, file, work))
      out.ids.push_back(id == 0 ? 0 : id + before);
    for (const FileOutline& o : outlines.outlines) out.classes.push_back(o.cls);
    out.sections += outlines.sections;
  }
  if (out.pixel_size == 0) out.pixel_size = first_scale > 0 ? first_scale : 1;
  if (picture && out.sections != picture->sections)
    throw Error("size-mismatch",
                fmt::format("the outlines are of {} sections, but the picture has {}", out.sections,
                            picture->sections),
                "use the outlines of this picture")
        .parameter("path");
  return out;
}

}  // namespace terrazzo::load_labels
