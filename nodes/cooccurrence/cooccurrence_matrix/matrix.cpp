#include "nodes/cooccurrence/cooccurrence_matrix/matrix.h"

#include <fmt/format.h>

#include "nodes/common/plot/plot.h"

namespace terrazzo::cooccurrence_matrix {
namespace {

double probability(const Cooccurrence& m, std::size_t offset, int home, int remote) {
  return m.pairs[offset] > 0 ? double(m.counts[m.at(offset, home, remote)]) / double(m.pairs[offset]) : 0;
}

}  // namespace

std::vector<Vec3i> all_offsets(int extent) {
  std::vector<Vec3i> out;
  for (int y = -extent; y <= extent; ++y)
    for (int x = -extent; x <= extent; ++x) out.emplace_back(x, y, 0);
  return out;
}

Table matrix_table(const Cooccurrence& m) {
  Table t;
  t.columns = {"dx pixels", "dy pixels", "home", "remote", "pairs", "probability"};
  for (std::size_t d = 0; d < m.offsets.size(); ++d)
    for (int home = 0; home < m.levels; ++home)
      for (int remote = 0; remote < m.levels; ++remote)
        t.rows.push_back({double(m.offsets[d].x()), double(m.offsets[d].y()), double(home + 1),
                          double(remote + 1), double(m.pairs[d]), probability(m, d, home, remote)});
  return t;
}

Image slice_figure(const Cooccurrence& m, int extent, int level) {
  const int edge = 2 * extent + 1;
  std::vector<Plot> plots;
  for (const bool down : {true, false}) {
    Plot p;
    p.title = down ? "Slice through the matrix, dx = 0" : "Slice through the matrix, dy = 0";
    p.x_label = down ? "dy, pixels" : "dx, pixels";
    p.y_label = "probability";
    p.width = 560;
    p.height = 420;
    for (int l = level ? level - 1 : 0; l < (level ? level : m.levels); ++l) {
      PlotSeries& s = p.series.emplace_back();
      s.name = fmt::format("level {}", l + 1);
      s.color = l;
      for (int i = -extent; i <= extent; ++i) {
        const int row = down ? i + extent : extent, column = down ? extent : i + extent;
        s.x.push_back(i);
        s.y.push_back(probability(m, row * edge + column, l, l));
      }
    }
    plots.push_back(std::move(p));
  }
  return draw(plots, 2);
}

}  // namespace terrazzo::cooccurrence_matrix
