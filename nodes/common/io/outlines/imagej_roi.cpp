// ImageJ's format of regions (ij/io/RoiDecoder.java and RoiEncoder.java): big-endian, coordinates after a
// header of 64 bytes, names and slices in a second header.
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "nodes/common/io/outlines/outline_file.h"

namespace terrazzo {
namespace {

enum RoiPlace {
  kType = 6,
  kTop = 8,
  kLeft = 10,
  kBottom = 12,
  kRight = 14,
  kCount = 16,
  kCorners = 18,  // of subpixel rectangles: x, y, width, height as floats; or the count, if it exceeds 65535
  kShapeSize = 36,
  kSubtype = 48,
  kOptions = 50,
  kPosition = 56,
  kHeader2 = 60,
  kCoordinates = 64
};
constexpr int kSubpixel = 128;          // of the options
constexpr int kSlice = 8, kGroup = 30;  // in the second header

class RoiBytes {
 public:
  RoiBytes(const std::string& bytes, const std::string& file) : bytes_(bytes), file_(file) {}
  std::uint64_t size() const { return bytes_.size(); }
  int byte(std::uint64_t at) const { return static_cast<unsigned char>(bytes_[checked(at, 1)]); }
  int half(std::uint64_t at) const { return byte(at) << 8 | byte(at + 1); }
  int signed_half(std::uint64_t at) const { return static_cast<std::int16_t>(half(at)); }
  std::uint32_t word(std::uint64_t at) const {
    return static_cast<std::uint32_t>(half(at)) << 16 | static_cast<std::uint32_t>(half(at + 2));
  }
  double number(std::uint64_t at) const {
    const std::uint32_t bits = word(at);
    float v = 0;
    std::memcpy(&v, &bits, sizeof v);
    if (!std::isfinite(v)) throw damaged("a coordinate is not a number");
    return v;
  }
  Error damaged(const std::string& what) const {
    return Error("unreadable-outlines", fmt::format("'{}' is no readable ImageJ region: {}", file_, what),
                 "save it with ImageJ again")
        .parameter("path");
  }

 private:
  std::uint64_t checked(std::uint64_t at, std::uint64_t length) const {
    if (at + length > bytes_.size()) throw damaged("it is cut off");
    return at;
  }
  const std::string& bytes_;
  const std::string& file_;
};

struct RoiBox {
  double left, top, width, height;
};

RoiBox box_of(const RoiBytes& roi) {
  if (roi.half(kOptions) & kSubpixel) {
    const RoiBox box{roi.number(kCorners), roi.number(kCorners + 4), roi.number(kCorners + 8),
                     roi.number(kCorners + 12)};
    if (box.width > 0 && box.height > 0) return box;
  }
  const double left = roi.signed_half(kLeft), top = roi.signed_half(kTop);
  return {left, top, roi.signed_half(kRight) - left, roi.signed_half(kBottom) - top};
}

Loop rectangle_of(const RoiBox& b) {
  const double right = b.left + b.width, bottom = b.top + b.height;
  return {{b.left, b.top}, {right, b.top}, {right, bottom}, {b.left, bottom}};
}

// A step of a pixel or less.
Loop oval_of(const RoiBox& b) {
  const int count = std::max(64, static_cast<int>(std::ceil(4 * (b.width + b.height))));
  Loop out;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    out.emplace_back(b.left + b.width / 2 * (1 + std::cos(angle)),
                     b.top + b.height / 2 * (1 + std::sin(angle)));
  }
  return out;
}

Loop polygon_of(const RoiBytes& roi, const std::string& file) {
  if (roi.half(kCount) == 0 && roi.half(kSubtype) != 0)
    throw bad_outline(file, "a rotated ellipse or rectangle has no outline",
                      "convert it to a polygon in ImageJ (Edit, Selection, Interpolate)");
  const std::uint64_t count = roi.half(kCount) ? roi.half(kCount) : roi.word(kCorners);
  if (kCoordinates + 4 * count > roi.size()) throw roi.damaged("it is cut off");
  Loop out;
  const bool exact = roi.half(kOptions) & kSubpixel;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (exact)
      out.emplace_back(roi.number(kCoordinates + 4 * (count + i)),
                       roi.number(kCoordinates + 4 * (2 * count + i)));
    else
      out.emplace_back(roi.signed_half(kLeft) + roi.half(kCoordinates + 2 * i),
                       roi.signed_half(kTop) + roi.half(kCoordinates + 2 * (count + i)));
  }
  return out;
}

// Several parts and holes: floats, each segment after its kind (java.awt.geom.PathIterator).
std::vector<Loop> composite_of(const RoiBytes& roi, std::uint64_t floats, const std::string& name,
                               const std::string& file) {
  if (kCoordinates + 4 * floats > roi.size()) throw roi.damaged("it is cut off");
  std::vector<Loop> out;
  const auto value = [&](std::uint64_t i) { return roi.number(kCoordinates + 4 * i); };
  for (std::uint64_t i = 0; i < floats;) {
    const double kind = value(i);
    if (kind == 4) {  // closes the part
      ++i;
      continue;
    }
    if (kind != 0 && kind != 1)
      throw bad_outline(file, name + " has curved segments",
                        "convert it to a polygon in ImageJ (Edit, Selection, Interpolate)");
    if (i + 2 >= floats) throw roi.damaged("a segment is cut off");
    if (kind == 0) out.emplace_back();
    if (out.empty()) throw roi.damaged("a part has no beginning");
    out.back().emplace_back(value(i + 1), value(i + 2));
    i += 3;
  }
  std::erase_if(out, [](const Loop& loop) { return loop.size() < 3; });
  for (Loop& loop : out)
    if (loop.back() == loop.front()) loop.pop_back();
  return out;
}

}  // namespace

FileOutline read_roi(const std::string& bytes, const std::string& file) {
  const RoiBytes roi(bytes, file);
  if (!bytes.starts_with("Iout")) throw roi.damaged("it does not begin with Iout");
  if (bytes.size() < kCoordinates) throw roi.damaged("it is cut off");
  FileOutline out;
  out.name = "the region";
  enum { kPolygon = 0, kRectangle = 1, kOval = 2, kFreehand = 7, kTraced = 8 };
  const int type = roi.byte(kType);
  if (const std::uint32_t floats = roi.word(kShapeSize); type == kRectangle && floats > 0)
    out.loops = composite_of(roi, floats, out.name, file);
  else if (type == kRectangle)
    out.loops = {rectangle_of(box_of(roi))};
  else if (type == kOval)
    out.loops = {oval_of(box_of(roi))};
  else if (type == kPolygon || type == kFreehand || type == kTraced)
    out.loops = {polygon_of(roi, file)};
  else
    throw bad_outline(file, fmt::format("the region of ImageJ's type {} encloses no area", type),
                      "keep polygons, freehand and traced areas, rectangles and ovals");
  std::uint32_t slice = roi.word(kPosition);
  if (const std::uint64_t second = roi.word(kHeader2); second > 0 && second + 64 <= bytes.size()) {
    if (const std::uint32_t z = roi.word(second + kSlice); z > 0) slice = z;
    if (const int group = roi.byte(second + kGroup); group > 0) out.cls = group - 1;
  }
  constexpr std::uint32_t kMostSlices = 1'000'000;
  if (slice > kMostSlices) throw roi.damaged("its slice has an impossible number");
  out.section = slice > 0 ? static_cast<int>(slice) - 1 : 0;
  return out;
}

}  // namespace terrazzo
