#include "nodes/volumes/render_volume/tissue.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

#include "graph/diagnostic.h"
#include "nodes/common/texture/color.h"

namespace terrazzo::render_volume {
namespace {

constexpr std::size_t kMost = 16;  // limit of the shader's arrays

Error bad(const std::string& text, const std::string& why) {
  return Error("bad-class", "'" + text + "' is not a class: " + why,
               "write its name and range, for example \"muscle -30 150 #8f3a36 texture\"")
      .parameter("classes");
}

std::optional<double> number(const std::string& word) {
  double v = 0;
  const char* end = word.data() + word.size();
  const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);
  const auto [at, error] = std::from_chars(begin, end, v);
  if (error != std::errc() || at != end || !std::isfinite(v)) return {};
  return v;
}

std::optional<Vec3f> color(const std::string& word) {
  if (word.size() != 7) return {};
  unsigned rgb = 0;
  const auto [at, error] = std::from_chars(word.data() + 1, word.data() + 7, rgb, 16);
  if (error != std::errc() || at != word.data() + 7) return {};
  return srgb_to_linear(Vec3f(float(rgb >> 16), float(rgb >> 8 & 255), float(rgb & 255)) / 255.0f);
}

Tissue parse(const std::string& text) {
  std::istringstream in(text);
  Tissue t;
  std::string low, high, word;
  if (!(in >> t.name >> low >> high)) throw bad(text, "it needs a name and a range");
  const auto a = number(low), b = number(high);
  if (!a || !b) throw bad(text, "'" + (a ? high : low) + "' is not a number");
  t.low = *a;
  t.high = *b;
  if (!(t.low < t.high)) throw bad(text, fmt::format("its range from {} to {} is empty", t.low, t.high));
  while (in >> word) {
    if (word[0] == '#') {
      const auto c = color(word);
      if (!c) throw bad(text, "'" + word + "' is not a color");
      t.color = *c;
    } else if (word == "texture") {
      t.finish = Finish::Texture;
    } else if (word == "noise") {
      t.finish = Finish::Noise;
    } else if (word == "plain") {
      t.finish = Finish::Plain;
    } else if (word.starts_with("opacity=")) {
      const auto o = number(word.substr(8));
      if (!o || *o < 0 || *o > 1) throw bad(text, "an opacity must be between 0 and 1");
      t.opacity = *o;
    } else if (word.starts_with("penetration=")) {
      const auto l = number(word.substr(12));
      if (!l || !(*l > 0)) throw bad(text, "a penetration must be a length in mm above 0");
      t.penetration = *l;
    } else {
      throw bad(text, "'" + word + "' is not a color, texture, noise, plain, opacity=… or penetration=…");
    }
  }
  return t;
}

}  // namespace

std::vector<Tissue> parse_tissues(const std::vector<std::string>& texts) {
  std::vector<Tissue> all;
  for (const auto& text : texts) all.push_back(parse(text));
  if (all.empty() || all.size() > kMost)
    throw Error("no-classes", fmt::format("classes has {} entries", all.size()),
                fmt::format("write 1 to {} classes", kMost))
        .parameter("classes");
  std::stable_sort(all.begin(), all.end(), [](const Tissue& a, const Tissue& b) { return a.low < b.low; });
  for (std::size_t i = 1; i < all.size(); ++i) {
    const Tissue &a = all[i - 1], &b = all[i];
    if (b.low < a.high)
      throw Error("overlapping-classes",
                  fmt::format("'{}' ({} to {}) and '{}' ({} to {}) both contain densities from {} to {}",
                              a.name, a.low, a.high, b.name, b.low, b.high, b.low, std::min(a.high, b.high)),
                  "make one end where the other begins")
          .parameter("classes");
    for (std::size_t k = 0; k < i; ++k)
      if (all[k].name == b.name)
        throw Error("bad-class", "two classes are named '" + b.name + "'", "rename one of them")
            .parameter("classes");
  }
  return all;
}

DensityIntervals intervals_of(const std::vector<Tissue>& tissues) {
  DensityIntervals out;
  out.tissue.push_back(-1);
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    const float low = tissues[i].low, high = tissues[i].high;
    if (!out.edges.empty() && out.edges.back() == low) {
      out.tissue.back() = i;
    } else {
      out.edges.push_back(low);
      out.tissue.push_back(static_cast<int>(i));
    }
    out.edges.push_back(high);
    out.tissue.push_back(-1);
  }
  return out;
}

}  // namespace terrazzo::render_volume
