#include "nodes/bodies/contact_sheet/sheet.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "nodes/bodies/contact_sheet/resize.h"
#include "nodes/common/plot/plot.h"
#include "nodes/common/plot/stroke_font.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::contact_sheet {

Vec3f label_color(std::int32_t id) {
  if (id == 0) return Vec3f::Constant(0.012f);
  // Golden-angle hues separate neighboring ids; lightness and chroma cycle at other rates.
  const double k = id, hue = 2.399963229728653 * k;
  const double light = 0.6 + 0.25 * std::fmod(k * 0.7548776662466927, 1.0),
               chroma = 0.09 + 0.06 * std::fmod(k * 0.5698402909980532, 1.0);
  return oklab_to_linear(Vec3f(static_cast<float>(light), static_cast<float>(chroma * std::cos(hue)),
                               static_cast<float>(chroma * std::sin(hue))))
      .cwiseMax(0.0f)
      .cwiseMin(1.0f);
}

Image picture_of(const Labels& labels, int section) {
  Image image(labels.width, labels.height, 1, labels.pixel_size);
  for (int y = 0; y < labels.height; ++y)
    for (int x = 0; x < labels.width; ++x)
      image.at(x, y) = label_color(labels.ids[labels.index(x, y, section)]);
  return image;
}

namespace {

std::string shortened(const std::string& text, int height, int width) {
  if (text_width(text, height) <= width) return text;
  std::string kept = text;
  while (!kept.empty() && text_width(kept + "…", height) > width) {
    while (!kept.empty() && (static_cast<unsigned char>(kept.back()) >> 6) == 2) kept.pop_back();
    if (!kept.empty()) kept.pop_back();
  }
  return kept + "…";
}

}  // namespace

Image contact_sheet(const std::vector<Image>& images, const SheetOptions& choice, const Work& work) {
  const int n = images.size();
  const int columns = std::min(n, choice.columns > 0 ? choice.columns : n <= 3 ? n : round_up(std::sqrt(n)));
  const int rows = (n + columns - 1) / columns;
  const int gap = std::max(8, choice.cell / 20), words = std::clamp(choice.cell / 24, 11, 28),
            below = words / 2;

  std::vector<Image> fitted;
  std::vector<int> width(columns, 0), height(rows, 0), captioned(rows, 0);
  for (int i = 0; i < n; ++i) {
    const double scale = static_cast<double>(choice.cell) / std::max(images[i].width, images[i].height);
    const int w = std::max(1, round_nearest(images[i].width * scale));
    const int h = std::max(1, round_nearest(images[i].height * scale));
    fitted.push_back(resized(images[i], 0, w, h, work.part(static_cast<double>(i) / n, (i + 1.0) / n)));
    width[i % columns] = std::max(width[i % columns], w);
    height[i / columns] = std::max(height[i / columns], h);
    if (i < count_of(choice.captions) && !choice.captions[i].empty()) captioned[i / columns] = below + words;
  }

  const bool dark = choice.background == Background::Dark;
  const Vec3f paper = srgb_to_linear(dark ? Vec3f(0.085f, 0.088f, 0.096f) : Vec3f(1, 1, 1));
  const Vec3f ink = srgb_to_linear(dark ? Vec3f::Constant(0.88f) : Vec3f::Constant(0.16f));
  Image sheet(std::accumulate(width.begin(), width.end(), gap * (columns + 1)),
              std::accumulate(height.begin(), height.end(),
                              std::accumulate(captioned.begin(), captioned.end(), gap * (rows + 1))),
              1, 1, paper);
  int top = gap;
  for (int r = 0; r < rows; ++r) {
    int left = gap;
    for (int c = 0; c < columns && r * columns + c < n; ++c) {
      const int i = r * columns + c;
      const Image& image = fitted[i];
      const int x0 = left + (width[c] - image.width) / 2, y0 = top + (height[r] - image.height) / 2;
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) sheet.at(x0 + x, y0 + y) = image.at(x, y);
      if (i < count_of(choice.captions))
        draw_text(sheet, x0, y0 + image.height + below, shortened(choice.captions[i], words, width[c]), words,
                  ink);
      left += width[c] + gap;
    }
    top += height[r] + captioned[r] + gap;
  }
  return sheet;
}

}  // namespace terrazzo::contact_sheet
