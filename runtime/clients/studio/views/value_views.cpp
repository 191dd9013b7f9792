#include "runtime/clients/studio/views/value_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "runtime/clients/studio/views/geometry_views.h"
#include "runtime/clients/studio/views/solid_picture.h"
#include "runtime/clients/studio/views/view_bytes.h"
#include "runtime/json_text.h"
#include "runtime/report/json_summary.h"

namespace terrazzo::studio {
using nlohmann::json;
namespace {

constexpr std::size_t kShown = 200;          // entries of a list in a summary
constexpr std::size_t kMostJson = 48 << 20;  // bytes
const char* const kBytes = "application/octet-stream";

struct Raster {
  int width, height, sections, section, factor;
  Raster(int width, int height, int sections, int section, int most)
      : width(width),
        height(height),
        sections(sections),
        section(std::clamp(section, 0, std::max(sections - 1, 0))),
        factor(std::max(1, (std::max(width, height) + most - 1) / std::max(most, 1))) {
    if (width <= 0 || height <= 0 || sections <= 0) throw Error("empty-image", "the picture has no pixels");
  }
  int w() const { return (width + factor - 1) / factor; }
  int h() const { return (height + factor - 1) / factor; }

  // The head, then `pixel(x, y)` as four bytes for each pixel that is shown.
  template <class Pixel>
  ValueView view(Pixel&& pixel) const {
    std::string out;
    out.reserve(20 + std::size_t{4} * w() * h());
    for (const int v : {w(), h(), sections, width, height}) append(out, static_cast<std::uint32_t>(v));
    for (int y = 0; y < height; y += factor)
      for (int x = 0; x < width; x += factor) append(out, pixel(x, y));
    return {kBytes, std::move(out)};
  }
};

// The byte of a channel, as lround(255 · linear_to_srgb()) gives it, from a table: pictures have a million
// of them, and a power takes longer than all else that a picture needs.
class Bytes {
 public:
  Bytes() {
    for (int k = 1; k < 256; ++k) {  // the smallest value that is encoded as k or more, by bisection
      float below = 0, from = 1;
      while (std::nextafter(below, 1.0f) < from) {
        const float middle = below + (from - below) / 2;
        (encoded(middle) < k ? below : from) = middle;
      }
      from_[k] = from;
    }
    for (int k = 0; k < kCells; ++k)
      start_[k] = static_cast<std::uint8_t>(encoded(static_cast<float>(k) / kCells));
  }
  std::uint32_t at(float linear) const {
    if (!(linear > 0)) return 0;  // also NaN
    if (linear >= 1) return std::isfinite(linear) ? 255 : 0;
    int k = start_[static_cast<std::size_t>(linear * kCells)];
    while (k < 255 && linear >= from_[k + 1]) ++k;
    return static_cast<std::uint32_t>(k);
  }

 private:
  static constexpr int kCells = 4096;
  static int encoded(float linear) {
    return static_cast<int>(
        std::lround(255 * std::clamp(linear_to_srgb(Vec3f::Constant(linear))[0], 0.0f, 1.0f)));
  }
  std::array<float, 257> from_{};
  std::array<std::uint8_t, kCells> start_{};
};

}  // namespace

std::uint32_t rgba(const Vec3f& linear) {
  static const Bytes bytes;
  std::uint32_t out = 0xff000000u;
  for (int k = 0; k < 3; ++k) out |= bytes.at(linear[k]) << (8 * k);
  return out;
}

std::uint32_t color_of(std::int32_t id) {
  if (id <= 0) return 0xff201c1au;
  const double hue = std::fmod(static_cast<double>(id) * 0.61803398875, 1.0) * 6;
  const double light = 0.55 + 0.35 * std::fmod(static_cast<double>(id) * 0.7548776662, 1.0);
  std::uint32_t out = 0xff000000u;
  for (int k = 0; k < 3; ++k) {
    const double v = std::clamp(std::abs(std::fmod(hue + 6 - 2 * k, 6.0) - 3) - 1, 0.0, 1.0);
    out |= static_cast<std::uint32_t>(std::lround(255 * light * (0.45 + 0.55 * v))) << (8 * k);
  }
  return out;
}

namespace {

// A color for each profile of a section, by its first pixel: it stays when other profiles get other numbers.
std::vector<std::uint32_t> profile_colors(const Labels& labels, int section) {
  std::vector<std::uint32_t> out(labels.count() + 1, 0);
  out[0] = color_of(0);
  const std::size_t begin = labels.index(0, 0, section), end = labels.index(0, 0, section + 1);
  for (std::size_t k = begin; k < end; ++k) {
    const std::size_t id = std::max(labels.ids[k], 0);
    if (id < out.size() && out[id] == 0)
      out[id] = color_of(static_cast<std::int32_t>((k - begin) * 2654435761u % 1000003) + 1);
  }
  return out;
}

ValueView json_view(const json& j) {
  std::string text = json_text(j);
  if (text.size() > kMostJson)
    throw Error("too-large", fmt::format("the value has {} MB as JSON", text.size() / 1'000'000),
                "write it to a file with terrazzo show -o");
  return {"application/json", std::move(text)};
}

ValueView pixels(const Image& image, int section, int most) {
  const Raster r(image.width, image.height, image.sections, section, most);
  return r.view([&](int x, int y) { return rgba(image.at(x, y, r.section)); });
}

json outlines(const Profiles& p, int section) {
  json list = json::array();
  for (std::size_t k = 0; k < p.profiles.size(); ++k) {
    const Profile& q = p.profiles[k];
    if (q.section != section) continue;
    json points = json::array();
    for (const auto& v : q.contour) points.push_back({v.x(), v.y()});
    list.push_back({{"index", k},
                    {"area", q.area},
                    {"class", q.cls},
                    {"border", q.touches_border},
                    {"center", {q.centroid.x(), q.centroid.y()}},
                    {"points", points},
                    {"color", rgba(q.color) & 0xffffffu}});
  }
  return {{"window", {p.window.x(), p.window.y()}},
          {"sections", p.sections},
          {"area_fraction", p.area_fraction},
          {"binder", rgba(p.binder_color) & 0xffffffu},
          {"profiles", list}};
}

}  // namespace

ValueView view_of(const Value& value, const std::string& as, const ViewOptions& choice) {
  const int section = choice.slice.index, most = choice.most;
  if (as == "json") return json_view(value.type().describe(value.data()));
  if (as == "summary") {
    json j = value.type().describe(value.data());
    shorten_lists(j, kShown);
    return json_view(j);
  }
  if (as == "pixels" && value.is<Image>()) return pixels(value.as<Image>(), section, most);
  if (as == "picture") return pixels(solid_picture(value, choice.shapes, choice.azimuth), 0, most);
  if ((as == "pixels" || as == "ids") && value.is<Labels>()) {
    const auto& labels = value.as<Labels>();
    const Raster r(labels.width, labels.height, labels.sections, section, most);
    const auto id = [&](int x, int y) { return std::max(labels.ids[labels.index(x, y, r.section)], 0); };
    if (as == "ids") return r.view([&](int x, int y) { return static_cast<std::uint32_t>(id(x, y)); });
    const auto colors = profile_colors(labels, r.section);
    return r.view([&](int x, int y) {
      const std::size_t k = id(x, y);
      return k < colors.size() ? colors[k] : colors[0];
    });
  }
  if (as == "outlines" && value.is<Profiles>()) return json_view(outlines(value.as<Profiles>(), section));
  if (as == "particles" && value.is<Particles>()) return {kBytes, particles_view(value.as<Particles>())};
  if (as == "meshes" && value.is<Shapes>()) return {kBytes, shapes_view(value.as<Shapes>(), most)};
  if (value.is<Volume>()) {
    const auto& volume = value.as<Volume>();
    if (as == "head") return json_view(volume_head(volume));
    if (as == "slice") return {kBytes, slice_view(volume, choice.slice, most)};
    if (as == "voxels") return {kBytes, voxels_view(volume, choice.slice, most)};
  }
  throw Error("bad-request", fmt::format("a value of type {} has no view '{}'", value.type().name, as),
              "use summary or json");
}

}  // namespace terrazzo::studio
