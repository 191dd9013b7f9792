// ImageJ's regions (ij/io/RoiEncoder.java): big-endian, version 228.
#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "graph/diagnostic.h"
#include "nodes/export/formats/outlines/outlines.h"

namespace terrazzo::exporting {
namespace {

class RoiText {
 public:
  void byte(int v) { text_ += static_cast<char>(v); }
  void half(int v) {
    byte(v >> 8 & 0xff);
    byte(v & 0xff);
  }
  void word(std::uint32_t v) {
    half(static_cast<int>(v >> 16));
    half(static_cast<int>(v & 0xffff));
  }
  void number(double v) {
    const auto value = static_cast<float>(v);
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    word(bits);
  }
  void zeros(std::size_t to) { text_.resize(to, '\0'); }
  std::size_t size() const { return text_.size(); }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

bool whole(const Loop& loop) {
  return std::all_of(loop.begin(), loop.end(),
                     [](const Vec2& p) { return p.x() == std::floor(p.x()) && p.y() == std::floor(p.y()); });
}

// The parts and holes of a composite region, each segment after its kind.
void add_segments(const std::vector<Loop>& loops, RoiText& out) {
  constexpr double kMove = 0, kLine = 1, kClose = 4;
  for (const Loop& loop : loops) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      out.number(i == 0 ? kMove : kLine);
      out.number(loop[i].x());
      out.number(loop[i].y());
    }
    out.number(kClose);
  }
}

void add_points(const Loop& loop, int left, int top, bool exact, RoiText& out) {
  for (const Vec2& p : loop) out.half(static_cast<int>(std::lround(p.x())) - left);
  for (const Vec2& p : loop) out.half(static_cast<int>(std::lround(p.y())) - top);
  if (!exact) return;
  for (const Vec2& p : loop) out.number(p.x());
  for (const Vec2& p : loop) out.number(p.y());
}

}  // namespace

std::string roi_of(const FileOutline& o, bool in_stack, bool grouped) {
  constexpr int kVersion = 228, kPolygon = 0, kRectangle = 1, kTraced = 8, kSubpixel = 128, kHeader = 64;
  constexpr double kFarthest = 32767;
  Vec2 low = o.loops[0][0], high = low;
  std::size_t points = 0;
  for (const Loop& loop : o.loops)
    for (const Vec2& p : loop) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
      ++points;
    }
  if (low.minCoeff() < -kFarthest || high.maxCoeff() > kFarthest || (grouped && o.cls > 254))
    throw Error("format-does-not-fit",
                "ImageJ's regions hold coordinates up to 32,767 pixels and 255 classes",
                "use .geojson or .coco.json")
        .parameter("path");
  const bool composite = o.loops.size() > 1, exact = !composite && !whole(o.loops[0]);
  const int left = static_cast<int>(std::floor(low.x())), top = static_cast<int>(std::floor(low.y()));
  RoiText out;
  for (const char c : {'I', 'o', 'u', 't'}) out.byte(c);
  out.half(kVersion);
  out.byte(composite ? kRectangle : exact ? kPolygon : kTraced);
  out.byte(0);
  for (const int v :
       {top, left, static_cast<int>(std::ceil(high.y())), static_cast<int>(std::ceil(high.x()))})
    out.half(v);
  const bool many = points > 65535;
  out.half(composite || many ? 0 : static_cast<int>(points));
  out.word(many && !composite ? static_cast<std::uint32_t>(points) : 0);
  out.zeros(36);
  const std::size_t floats = composite ? 3 * points + o.loops.size() : 0;
  out.word(static_cast<std::uint32_t>(floats));
  out.zeros(50);
  out.half(exact ? kSubpixel : 0);
  out.zeros(56);
  out.word(in_stack ? o.section + 1 : 0);
  out.word(static_cast<std::uint32_t>(kHeader + (composite ? 4 * floats : (exact ? 12 : 4) * points)));
  if (composite)
    add_segments(o.loops, out);
  else
    add_points(o.loops[0], left, top, exact, out);
  const std::size_t second = out.size();
  out.zeros(second + 30);
  out.byte(grouped ? o.cls + 1 : 0);
  out.zeros(second + kHeader);
  return out.take();
}

void write_roi_zip(const std::filesystem::path& path, const OutlineFile& all) {
  const bool grouped =
      std::any_of(all.outlines.begin(), all.outlines.end(), [](const FileOutline& o) { return o.cls > 0; });
  std::vector<std::string> texts;  // libzip reads them when it closes the archive
  for (const FileOutline& o : all.outlines) texts.push_back(roi_of(o, all.sections > 1, grouped));
  int code = 0;
  std::unique_ptr<zip_t, void (*)(zip_t*)> zip(zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code),
                                               zip_discard);
  const auto failed = [&](const std::string& why) {
    return Error("write-failed", fmt::format("'{}': {}", path.string(), why),
                 "check the output folder and the free disk space");
  };
  if (!zip) throw failed("cannot create the file");
  for (std::size_t i = 0; i < texts.size(); ++i) {
    zip_source_t* source = zip_source_buffer(zip.get(), texts[i].data(), texts[i].size(), 0);
    const std::string name = fmt::format("{:0>6}.roi", all.outlines[i].name);
    const zip_int64_t index = source ? zip_file_add(zip.get(), name.c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    constexpr zip_uint16_t kTime = 0, kDate = 1 << 5 | 1;  // 1980-01-01: equal outlines give equal files
    if (index < 0 || zip_file_set_dostime(zip.get(), index, kTime, kDate, 0) != 0) {
      if (source && index < 0) zip_source_free(source);
      throw failed(zip_strerror(zip.get()));
    }
  }
  if (zip_close(zip.get()) != 0) throw failed(zip_strerror(zip.get()));
  zip.release();
}

}  // namespace terrazzo::exporting
