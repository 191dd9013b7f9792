// Drawings of a graph: Graphviz, Mermaid, and SVG with our own layered layout (Sugiyama's method: layers by
// longest path, order within a layer by the mean position of the neighbors).
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "graph/describe.h"
#include "graph/escape_xml.h"

namespace terrazzo {
namespace {

template <class Use>
void each_wire(const Graph& g, Use&& use) {
  for (std::size_t i = 0; i < g.nodes.size(); ++i)
    for (const auto& [port, wires] : g.nodes[i].inputs)
      for (const auto& w : wires) use(static_cast<std::size_t>(w.node), w.port, i, port);
}

}  // namespace

std::string draw_dot(const Graph& g) {
  std::string out =
      "digraph terrazzo {\n  rankdir=LR;\n  node [shape=box, style=rounded, fontname=\"sans-serif\"];\n";
  for (std::size_t i = 0; i < g.nodes.size(); ++i)
    out += fmt::format("  n{} [label=\"{}\\n{}\"];\n", i, g.nodes[i].path, g.nodes[i].type->name);
  each_wire(g, [&](std::size_t from, const std::string& output, std::size_t to, const std::string& input) {
    out += fmt::format("  n{} -> n{} [label=\"{}\"];\n", from, to,
                       output == input ? output : output + " → " + input);
  });
  return out + "}\n";
}

std::string draw_mermaid(const Graph& g) {
  std::string out = "flowchart LR\n";
  for (std::size_t i = 0; i < g.nodes.size(); ++i)
    out += fmt::format("  n{}[\"{}<br/><i>{}</i>\"]\n", i, g.nodes[i].path, g.nodes[i].type->name);
  each_wire(g, [&](std::size_t from, const std::string& output, std::size_t to, const std::string& input) {
    out += fmt::format("  n{} -->|{}| n{}\n", from, output == input ? output : output + " → " + input, to);
  });
  return out;
}

std::string draw_svg(const Graph& g) {
  const std::size_t n = g.nodes.size();
  std::vector<int> layer(n, 0);
  each_wire(g, [&](std::size_t from, const std::string&, std::size_t to, const std::string&) {
    layer[to] = std::max(layer[to], layer[from] + 1);
  });
  std::map<int, std::vector<std::size_t>> layers;
  for (std::size_t i = 0; i < n; ++i) layers[layer[i]].push_back(i);
  std::vector<double> row(n, 0);
  for (auto& [l, members] : layers)
    for (std::size_t k = 0; k < members.size(); ++k) row[members[k]] = static_cast<double>(k);
  for (int sweep = 0; sweep < 8; ++sweep)
    for (auto& [number, members] : layers) {
      const int l = number;
      std::map<std::size_t, std::pair<double, int>> mean;
      each_wire(g, [&](std::size_t from, const std::string&, std::size_t to, const std::string&) {
        if (layer[to] == l) mean[to].first += row[from], ++mean[to].second;
        if (layer[from] == l && sweep % 2) mean[from].first += row[to], ++mean[from].second;
      });
      const auto place = [&](std::size_t i) {
        return mean.count(i) ? mean[i].first / mean[i].second : row[i];
      };
      std::stable_sort(members.begin(), members.end(),
                       [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
      for (std::size_t k = 0; k < members.size(); ++k) row[members[k]] = static_cast<double>(k);
    }
  constexpr double width = 150, height = 44, gap_x = 70, gap_y = 22, margin = 20;
  std::size_t tallest = 1;
  for (const auto& [l, members] : layers) tallest = std::max(tallest, members.size());
  const auto x = [&](std::size_t i) { return margin + layer[i] * (width + gap_x); };
  const auto y = [&](std::size_t i) {
    const double spare = static_cast<double>(tallest - layers[layer[i]].size()) * (height + gap_y) / 2;
    return margin + spare + row[i] * (height + gap_y);
  };
  const double total_x = 2 * margin + static_cast<double>(layers.size()) * (width + gap_x) - gap_x;
  const double total_y = 2 * margin + static_cast<double>(tallest) * (height + gap_y) - gap_y;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
      "{1:.0f}\" "
      "font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      total_x, total_y);
  each_wire(g, [&](std::size_t from, const std::string& output, std::size_t to, const std::string&) {
    const double x0 = x(from) + width, y0 = y(from) + height / 2, x1 = x(to), y1 = y(to) + height / 2;
    out += fmt::format(
        "<path d=\"M{:.1f} {:.1f} C{:.1f} {:.1f} {:.1f} {:.1f} {:.1f} {:.1f}\" fill=\"none\" "
        "stroke=\"#7a8794\" stroke-width=\"1.4\"><title>{}</title></path>\n",
        x0, y0, x0 + gap_x / 2, y0, x1 - gap_x / 2, y1, x1, y1, escape_xml(output));
  });
  for (std::size_t i = 0; i < n; ++i)
    out += fmt::format(
        "<g><rect x=\"{0:.1f}\" y=\"{1:.1f}\" width=\"{2}\" height=\"{3}\" rx=\"7\" fill=\"#f3f5f7\" "
        "stroke=\"#4a5662\"/>"
        "<text x=\"{4:.1f}\" y=\"{5:.1f}\" font-size=\"13\" text-anchor=\"middle\" "
        "fill=\"#1d252c\">{6}</text>"
        "<text x=\"{4:.1f}\" y=\"{7:.1f}\" font-size=\"11\" text-anchor=\"middle\" "
        "fill=\"#66727d\">{8}</text></g>\n",
        x(i), y(i), width, height, x(i) + width / 2, y(i) + 19, escape_xml(g.nodes[i].path), y(i) + 35,
        escape_xml(g.nodes[i].type->name));
  return out + "</svg>\n";
}

}  // namespace terrazzo
