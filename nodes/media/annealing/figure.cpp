#include <fmt/format.h>

#include <algorithm>

#include "nodes/common/plot/plot.h"
#include "nodes/media/annealing/comparison.h"

namespace terrazzo::annealing {
namespace {

constexpr int kColumns = 3, kTop = 28;  // plots side by side; pixels above pictures

// One curve of the solid, and the picture's points with the range of its tiles.
Plot plot_of(const Agreement& a) {
  Plot plot;
  plot.width = 420;
  plot.height = 300;
  plot.title = fmt::format("{}, phase {}", a.measure, a.phase);
  plot.x_label = "pixels";
  PlotSeries picture, solid;
  picture.kind = PlotSeries::Kind::Points;
  picture.name = "picture and its tiles";
  solid.name = "slices of the solid";
  solid.color = 1;
  const std::size_t step = std::max<std::size_t>(1, a.of_picture.size() / 20);
  for (std::size_t r = 0; r < a.of_picture.size(); ++r) {
    solid.x.push_back(static_cast<double>(r));
    solid.y.push_back(a.of_solid[r]);
    if (r % step) continue;
    picture.x.push_back(static_cast<double>(r));
    picture.y.push_back(a.of_picture[r]);
    picture.low.push_back(a.low[r]);
    picture.high.push_back(a.high[r]);
  }
  plot.series = {picture, solid};
  return plot;
}

// A map enlarged to about `edge` pixels, from black to white by phase.
void paint(Image& out, const media::PhaseMap& map, int left, int top, int edge) {
  for (int y = 0; y < edge; ++y)
    for (int x = 0; x < edge; ++x) {
      const std::uint8_t p = map.at[map.index(x * map.width / edge, y * map.height / edge)];
      out.at(left + x, top + y) =
          p == media::kUnobserved
              ? Vec3f(0.6f, 0.05f, 0.05f)
              : Vec3f::Constant(static_cast<float>(p) / static_cast<float>(map.phases - 1));
    }
}

}  // namespace

Image agreement_figure(const std::vector<Agreement>& all, const std::vector<Shown>& shown) {
  std::vector<Plot> plots;
  for (const Agreement& a : all)
    if (a.of_picture.size() > 1 && a.picture == 0) plots.push_back(plot_of(a));
  const Image curves = draw(plots, kColumns);
  const int count = count_of(shown), edge = curves.width / std::max(4, count) - 8;
  Image out(curves.width, curves.height + edge + kTop + 8, 1, 1, Vec3f::Constant(1));
  for (int k = 0; k < count; ++k) {
    const int left = 4 + k * (edge + 8);
    draw_text(out, left, 6, shown[k].caption, 14, Vec3f::Zero());
    paint(out, shown[k].map, left, kTop, edge);
  }
  for (int y = 0; y < curves.height; ++y)
    for (int x = 0; x < curves.width; ++x) out.at(x, edge + kTop + 8 + y) = curves.at(x, y);
  return out;
}

}  // namespace terrazzo::annealing
