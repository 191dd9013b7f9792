#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "nodes/common/io/json_input.h"
#include "nodes/common/io/outlines/outline_file.h"
#include "nodes/data/indices.h"

namespace terrazzo {
namespace {
using nlohmann::json;

constexpr int kLargestSide = 1'000'000;

// Alternate lengths of background and object, in columns from the left.
using RunLengths = std::vector<std::uint32_t>;

// COCO's text form: six bits per character from '0', five of the number with the lowest first, one that says
// whether more follow; from the third number on, differences to the one before the last (maskApi.c of
// pycocotools).
RunLengths unpacked(const std::string& text, const std::string& name, const std::string& file) {
  RunLengths out;
  for (std::size_t at = 0; at < text.size();) {
    std::int64_t value = 0;
    int shift = 0;
    bool more = true;
    while (more) {
      const int c = at < text.size() ? text[at++] - 48 : -1;
      if (c < 0 || c > 63 || shift > 30)
        throw bad_outline(file, name + " has damaged run lengths", "write the file again");
      value |= static_cast<std::int64_t>(c & 0x1f) << shift;
      shift += 5;
      more = c & 0x20;
      if (!more && (c & 0x10)) value |= -(std::int64_t{1} << shift);
    }
    if (out.size() > 2) value += out[out.size() - 2];
    if (value < 0 || value > 0xffffffffLL)
      throw bad_outline(file, name + " has damaged run lengths", "write the file again");
    out.push_back(static_cast<std::uint32_t>(value));
  }
  return out;
}

// Of a picture of out.width × out.height pixels.
RunLengths runs_of(const JsonObject& object, const FileOutline& one, const OutlineFile& out,
                   const std::string& file) {
  const std::vector<double> size = object.numbers("size", 1, kLargestSide);
  if (size.size() != 2)
    throw bad_outline(file, one.name + " has no size [height, width]", "write the file again");
  if (size[0] != out.height || size[1] != out.width)
    throw Error("size-mismatch",
                fmt::format("'{}': {} has run lengths for {} × {} pixels, but its picture has {} × {}", file,
                            one.name, size[1], size[0], out.width, out.height),
                "write the file again")
        .parameter("path");
  const json& counts = object.field("counts");
  if (counts.is_string()) return unpacked(counts.get<std::string>(), one.name, file);
  RunLengths runs;
  for (const double v : object.numbers("counts", 0, 0xffffffffU)) {
    if (v != std::floor(v)) object.fail("the field counts contains a number that is not whole");
    runs.push_back(static_cast<std::uint32_t>(v));
  }
  return runs;
}

// A part of the object in one column, rows [begin, end).
struct ColumnRun {
  int x, begin, end;
};
std::vector<ColumnRun> column_runs(const RunLengths& runs, const std::string& name, const OutlineFile& out,
                                   const std::string& file) {
  const auto height = static_cast<std::size_t>(out.height);
  const std::size_t pixels = pixels_in(out.width, out.height);
  std::vector<ColumnRun> columns;
  std::size_t at = 0;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (runs[k] > pixels - at)
      throw bad_outline(
          file, fmt::format("{} has run lengths for more than {} × {} pixels", name, out.width, out.height),
          "write the file again");
    const std::size_t end = at + runs[k];
    while (k % 2 == 1 && at < end) {
      const std::size_t x = at / height, stop = std::min(end, (x + 1) * height);
      columns.push_back(
          {static_cast<int>(x), static_cast<int>(at - x * height), static_cast<int>(stop - x * height)});
      at = stop;
    }
    at = end;
  }
  return columns;
}

// From the pixels of the object's box.
std::vector<Loop> loops_of_runs(const std::vector<ColumnRun>& columns, const std::string& file,
                                const Reading& reading, const Work& work) {
  if (columns.empty()) return {};
  int top = columns[0].begin, bottom = columns[0].end;
  for (const ColumnRun& c : columns) {
    top = std::min(top, c.begin);
    bottom = std::max(bottom, c.end);
  }
  const int left = columns.front().x, width = columns.back().x + 1 - left, height = bottom - top;
  const std::size_t pixels = pixels_in(width, height);
  require_memory(8.0 * pixels, reading.memory, "the run lengths of '" + file + "'");
  std::vector<std::int32_t> mask(pixels, 0);
  for (const ColumnRun& c : columns)
    for (int y = c.begin; y < c.end; ++y) mask[pixel_at(c.x - left, y - top, width)] = 1;
  std::vector<Loop> loops = pixel_outlines(mask.data(), width, height, work)[1];
  for (Loop& loop : loops)
    for (Vec2& p : loop) p += Vec2(left, top);
  return loops;
}

Loop loop_of_numbers(const json& list, const std::string& name, const std::string& file) {
  Loop out;
  const bool fits = list.is_array() && list.size() >= 6 && list.size() % 2 == 0;
  for (std::size_t i = 0; fits && i < list.size(); i += 2) {
    if (!list[i].is_number() || !list[i + 1].is_number()) break;
    out.emplace_back(list[i].get<double>(), list[i + 1].get<double>());
  }
  if (!fits || 2 * out.size() != list.size())
    throw bad_outline(file, name + " has a polygon that is not a list of at least six numbers x, y, …",
                      "write the file again");
  if (out.back() == out.front()) out.pop_back();
  return out;
}

// The images in their order, as sections of one size.
std::map<std::int64_t, int> sections_of(const JsonObject& all, const JsonSource& source, OutlineFile& out) {
  std::map<std::int64_t, int> sections;
  for (const json& j : all.list("images")) {
    const JsonObject image(j, source, fmt::format("image {}: ", sections.size() + 1), "unreadable-outlines");
    const int width = image.whole("width", 1, kLargestSide), height = image.whole("height", 1, kLargestSide);
    if (out.width > 0 && (width != out.width || height != out.height))
      throw Error("size-mismatch",
                  fmt::format("'{}' has pictures of {} × {} and of {} × {} pixels", source.file, out.width,
                              out.height, width, height),
                  "all sections of a stack must have one size: write one file for each picture")
          .parameter("path");
    out.width = width;
    out.height = height;
    if (j.contains("pixel_size_mm")) {
      const double pixel_size = image.number("pixel_size_mm", JsonObject::kSmallest);
      if (out.pixel_size > 0 && pixel_size != out.pixel_size)
        throw Error("size-mismatch",
                    fmt::format("'{}' has pictures with pixels of {:.6g} and of {:.6g} mm", source.file,
                                out.pixel_size, pixel_size),
                    "all sections of a stack must have one scale: write one file for each picture")
            .parameter("path");
      out.pixel_size = pixel_size;
    }
    sections.emplace(image.whole("id", 0, 2'000'000'000), count_of(sections));
  }
  out.sections = std::max(1, count_of(sections));
  return sections;
}

}  // namespace

OutlineFile read_coco(const std::string& text, const std::string& file, const Reading& reading,
                      const Work& work) {
  const JsonSource source{file, "use COCO's format for object detection"};
  const json json_text = parse_json(text, "", source);
  const JsonObject all(json_text, source, "the file ", "unreadable-outlines");
  OutlineFile out;
  const auto sections = sections_of(all, source, out);
  std::map<std::int64_t, int> classes;
  if (all.has("categories"))
    for (const json& j : all.list("categories")) {
      const JsonObject category(j, source, "a category ", "unreadable-outlines");
      classes.emplace(category.whole("id", 0, 2'000'000'000), count_of(classes));
    }
  for (const json& j : all.list("annotations")) {
    work.check();
    FileOutline one;
    one.name = fmt::format("annotation {}", out.outlines.size() + 1);
    const JsonObject annotation(j, source, one.name + ": ", "bad-outline");
    const auto section = sections.find(annotation.whole("image_id", 0, 2'000'000'000));
    if (section == sections.end()) annotation.fail("the field image_id names no image of the file");
    one.section = section->second;
    if (annotation.has("category_id") && !classes.empty()) {
      const auto cls = classes.find(annotation.whole("category_id", 0, 2'000'000'000));
      if (cls == classes.end()) annotation.fail("the field category_id names no category of the file");
      one.cls = cls->second;
    }
    if (annotation.has("score")) one.confidence = annotation.number("score", 0, 1);
    const json& segmentation = annotation.field("segmentation");
    if (segmentation.is_object()) {
      const JsonObject object(segmentation, source, one.name + ": ", "bad-outline");
      one.loops = loops_of_runs(column_runs(runs_of(object, one, out, file), one.name, out, file), file,
                                reading, work);
    } else if (segmentation.is_array()) {
      for (const json& polygon : segmentation) one.loops.push_back(loop_of_numbers(polygon, one.name, file));
    } else {
      annotation.fail("the field segmentation is neither polygons nor run lengths");
    }
    out.outlines.push_back(std::move(one));
  }
  return out;
}

}  // namespace terrazzo
