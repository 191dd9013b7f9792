#include "nodes/compare/texture_observer/figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/plot/drawing.h"
#include "nodes/common/plot/plot.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::texture_observer {

namespace {

constexpr int kWidth = 1240, kMargin = 20, kGap = 8, kShown = 8;
constexpr int kTile = (kWidth - 2 * kMargin - (kShown - 1) * kGap) / kShown;
const Vec3f kInk = Vec3f::Constant(0.02f);

void paste(Image& onto, const Image& from, int left, int top) {
  for (int y = 0; y < std::min(from.height, onto.height - top); ++y)
    for (int x = 0; x < std::min(from.width, onto.width - left); ++x)
      onto.at(left + x, top + y) = from.at(x, y);
}

// A crop at a whole multiple of its size, so that its pixels stay visible; reduced if it is larger than a
// tile.
Image tile_of(const CropSet& set, const Crop& crop) {
  int level = 0;
  while (level + 1 < kLevels && set.crop >> level > kTile) ++level;
  const Patch& patch = set.cells[crop.cell].levels[level];
  const int edge = std::min(set.crop >> level, kTile), times = std::max(1, kTile / edge);
  Image out(edge * times, edge * times, 1, 1);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      out.at(x, y) = oklab_to_linear(patch.at((crop.x >> level) + x / times, (crop.y >> level) + y / times))
                         .cwiseMax(0.0f)
                         .cwiseMin(1.0f);
  return out;
}

// The crops of one picture, the most certain first: of those recognized, or of those taken for the other.
std::vector<JudgedCrop> most_certain(const Verdict& v, bool of_b, bool recognized) {
  std::vector<JudgedCrop> out;
  for (const auto& j : v.judged)
    if (j.of_b == of_b && j.score != 0 && (j.score > 0) == (of_b == recognized)) out.push_back(j);
  std::stable_sort(out.begin(), out.end(), [](const JudgedCrop& x, const JudgedCrop& y) {
    return std::abs(x.score) > std::abs(y.score);
  });
  return out;
}

Image gallery_of(const Verdict& v, const std::array<const Halves*, 2>& pictures,
                 const std::array<std::string, 2>& names) {
  constexpr int kCaption = 30, kHead = 52;
  std::array<std::vector<JudgedCrop>, 4> rows;  // a and b recognized, a and b mistaken
  int height = kHead;
  for (int row = 0; row < 4; ++row) {
    rows[row] = most_certain(v, row % 2, row < 2);
    height += kCaption + (rows[row].empty() ? 0 : kTile + 6);
  }
  Image out(kWidth, height, 1, 1, Vec3f::Ones());
  Coverage title(out.width, out.height);
  add_text(title, kMargin, 16,
           fmt::format("Observer '{}' recognizes {:.1f} ± {:.1f} % (control {:.1f} ± {:.1f} %)", v.observer,
                       100 * v.accuracy.share, 100 * v.accuracy.error, 100 * v.control.share,
                       100 * v.control.error),
           19, Turn::None, 1.25);
  title.paint(out, kInk);
  int top = kHead;
  for (int row = 0; row < 4; ++row) {
    const int of = row % 2;
    draw_text(out, kMargin, top + 6,
              fmt::format("{}: {} of {} crops {}{}", names[of], rows[row].size(), v.accuracy.crops / 2,
                          row < 2 ? "recognized" : "taken for " + names[1 - of],
                          rows[row].size() > 1 ? ", the most certain first" : ""),
              15, kInk);
    top += kCaption;
    for (int k = 0; k < std::min(kShown, count_of(rows[row])); ++k) {
      const CropSet& set = (*pictures[of])[rows[row][k].half];
      paste(out, tile_of(set, set.crops[rows[row][k].crop]), kMargin + k * (kTile + kGap), top);
    }
    if (!rows[row].empty()) top += kTile + 6;
  }
  return out;
}

void add_bar(PlotSeries& s, std::size_t x, const Accuracy& a) {
  s.x.push_back(x);
  s.y.push_back(100 * a.share);
  s.low.push_back(100 * (a.share - a.error));
  s.high.push_back(100 * std::min(1.0, a.share + a.error));
}

Plot bars_of(const std::array<Verdict, 2>& verdicts) {
  Plot plot;
  plot.title = "Crops recognized, with standard errors";
  plot.y_label = "%";
  plot.width = kWidth;
  plot.height = 320;
  PlotSeries all, control, alone, chance;
  all.kind = alone.kind = PlotSeries::Kind::Bars;
  control.kind = PlotSeries::Kind::Points;
  all.name = "by all features of an observer";
  control.name = "control: parts of a from each other";
  alone.name = "by one group of features alone";
  chance.name = "chance";
  control.color = 6;
  alone.color = 5;
  chance.color = 1;
  for (const Verdict& v : verdicts) {
    add_bar(all, plot.x_words.size(), v.accuracy);
    add_bar(control, plot.x_words.size(), v.control);
    plot.x_words.push_back(v.observer);
    for (const auto& g : v.groups) {
      add_bar(alone, plot.x_words.size(), g.accuracy);
      plot.x_words.push_back(g.name);
    }
  }
  chance.x = {-0.5, plot.x_words.size() - 0.5};
  chance.y = {50, 50};
  plot.series = {all, control, alone, chance};
  return plot;
}

}  // namespace

Image figure_of(const std::array<Verdict, 2>& verdicts, const Verdict& shown, const Halves& a,
                const Halves& b, const std::array<std::string, 2>& names) {
  const Image gallery = gallery_of(shown, {&a, &b}, names), bars = draw(bars_of(verdicts));
  Image out(kWidth, gallery.height + bars.height, 1, 1, Vec3f::Ones());
  paste(out, gallery, 0, 0);
  paste(out, bars, 0, gallery.height);
  return out;
}

}  // namespace terrazzo::texture_observer
