// Drawings of a graph: Graphviz, Mermaid, and SVG with our own layered layout (Sugiyama's method: layers by
// longest path, order within a layer by the mean position of the neighbors).
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "graph/describe.h"
#include "graph/text/element_name.h"
#include "graph/text/escape_xml.h"

namespace terrazzo {
namespace {

// A node, or all elements of a repeated node.
struct DrawnNode {
  std::string title, type;
};
struct DrawnWire {
  std::size_t from, to;
  std::string output, input;
};
struct Drawing {
  std::vector<DrawnNode> nodes;
  std::vector<DrawnWire> wires;
};

Drawing drawing_of(const Graph& g) {
  Drawing out;
  std::map<std::string, std::size_t> known;
  std::vector<std::size_t> drawn, count;
  for (const auto& node : g.nodes) {
    const std::string path = without_elements(node.path);
    const auto [at, fresh] = known.try_emplace(path, out.nodes.size());
    if (fresh) {
      out.nodes.push_back({path, node.type->name});
      count.push_back(0);
    }
    drawn.push_back(at->second);
    ++count[at->second];
  }
  for (std::size_t i = 0; i < count.size(); ++i)
    if (count[i] > 1) out.nodes[i].title += fmt::format(" × {}", count[i]);
  std::set<std::tuple<std::size_t, std::size_t, std::string, std::string>> seen;
  for (std::size_t i = 0; i < g.nodes.size(); ++i)
    for (const auto& [port, wires] : g.nodes[i].inputs)
      for (const auto& w : wires) {
        const std::size_t from = drawn[w.node];
        // Two wires of one node stay two; those of elements become one.
        const bool one = count[from] > 1 || count[drawn[i]] > 1;
        if (!one || seen.insert({from, drawn[i], w.port, port}).second)
          out.wires.push_back({from, drawn[i], w.port, port});
      }
  return out;
}

// In quotes.
std::string dot_text(const std::string& text) {
  std::string out;
  for (const char c : escape_line(text)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

// Mermaid labels are HTML in quotes; #quot; and #35; are its own escapes.
std::string mermaid_text(const std::string& text) {
  std::string out;
  for (const char c : escape_line(text))
    out += c == '"'   ? "#quot;"
           : c == '#' ? "#35;"
           : c == '<' ? "&lt;"
           : c == '>' ? "&gt;"
                      : std::string(1, c);
  return out;
}

}  // namespace

std::string draw_dot(const Graph& graph) {
  const Drawing g = drawing_of(graph);
  std::string out =
      "digraph terrazzo {\n  rankdir=LR;\n  node [shape=box, style=rounded, fontname=\"sans-serif\"];\n";
  for (std::size_t i = 0; i < g.nodes.size(); ++i)
    out += fmt::format("  n{} [label=\"{}\\n{}\"];\n", i, dot_text(g.nodes[i].title), g.nodes[i].type);
  for (const auto& w : g.wires)
    out += fmt::format("  n{} -> n{} [label=\"{}\"];\n", w.from, w.to,
                       w.output == w.input ? w.output : w.output + " → " + w.input);
  return out + "}\n";
}

std::string draw_mermaid(const Graph& graph) {
  const Drawing g = drawing_of(graph);
  std::string out = "flowchart LR\n";
  for (std::size_t i = 0; i < g.nodes.size(); ++i)
    out += fmt::format("  n{}[\"{}<br/><i>{}</i>\"]\n", i, mermaid_text(g.nodes[i].title), g.nodes[i].type);
  for (const auto& w : g.wires)
    out += fmt::format("  n{} -->|{}| n{}\n", w.from,
                       w.output == w.input ? w.output : w.output + " → " + w.input, w.to);
  return out;
}

namespace {

// Where nodes are drawn.
struct Layers {
  std::vector<int> layer;                           // of each node
  std::vector<double> row;                          // of each node within its layer
  std::map<int, std::vector<std::size_t>> members;  // of each layer, by row
};

// Puts every node behind its inputs, and sorts layers by the rows of their neighbors.
Layers layers_of(const Drawing& g) {
  const std::size_t n = g.nodes.size();
  Layers out{std::vector<int>(n, 0), std::vector<double>(n, 0), {}};
  std::vector<int>& layer = out.layer;
  std::vector<double>& row = out.row;
  auto& layers = out.members;
  for (const auto& w : g.wires) layer[w.to] = std::max(layer[w.to], layer[w.from] + 1);
  for (std::size_t i = 0; i < n; ++i) layers[layer[i]].push_back(i);
  for (auto& [l, members] : layers)
    for (std::size_t k = 0; k < members.size(); ++k) row[members[k]] = k;
  for (int sweep = 0; sweep < 8; ++sweep)
    for (auto& [number, members] : layers) {
      const int l = number;
      std::map<std::size_t, std::pair<double, int>> mean;
      for (const auto& w : g.wires) {
        if (layer[w.to] == l) {
          mean[w.to].first += row[w.from];
          ++mean[w.to].second;
        }
        if (layer[w.from] == l && sweep % 2) {
          mean[w.from].first += row[w.to];
          ++mean[w.from].second;
        }
      }
      const auto place = [&](std::size_t i) {
        return mean.count(i) ? mean[i].first / mean[i].second : row[i];
      };
      std::stable_sort(members.begin(), members.end(),
                       [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
      for (std::size_t k = 0; k < members.size(); ++k) row[members[k]] = k;
    }
  return out;
}

}  // namespace

std::string draw_svg(const Graph& graph) {
  const Drawing g = drawing_of(graph);
  const Layers placed = layers_of(g);
  const std::vector<int>& layer = placed.layer;
  const std::vector<double>& row = placed.row;
  const auto& layers = placed.members;
  constexpr double kWidth = 150, kHeight = 44, kGapX = 70, kGapY = 22, kMargin = 20;
  std::size_t tallest = 1;
  for (const auto& [l, members] : layers) tallest = std::max(tallest, members.size());
  const auto x = [&](std::size_t i) { return kMargin + layer[i] * (kWidth + kGapX); };
  const auto y = [&](std::size_t i) {
    const double spare = (tallest - layers.at(layer[i]).size()) * (kHeight + kGapY) / 2;
    return kMargin + spare + row[i] * (kHeight + kGapY);
  };
  const double total_x = 2 * kMargin + layers.size() * (kWidth + kGapX) - kGapX;
  const double total_y = 2 * kMargin + tallest * (kHeight + kGapY) - kGapY;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
      "{1:.0f}\" "
      "font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      total_x, total_y);
  for (const auto& w : g.wires) {
    const double x0 = x(w.from) + kWidth, y0 = y(w.from) + kHeight / 2, x1 = x(w.to),
                 y1 = y(w.to) + kHeight / 2;
    out += fmt::format(
        "<path d=\"M{:.1f} {:.1f} C{:.1f} {:.1f} {:.1f} {:.1f} {:.1f} {:.1f}\" fill=\"none\" "
        "stroke=\"#7a8794\" stroke-width=\"1.4\"><title>{}</title></path>\n",
        x0, y0, x0 + kGapX / 2, y0, x1 - kGapX / 2, y1, x1, y1, escape_xml(w.output));
  }
  for (std::size_t i = 0; i < g.nodes.size(); ++i)
    out += fmt::format(
        "<g><rect x=\"{0:.1f}\" y=\"{1:.1f}\" width=\"{2}\" height=\"{3}\" rx=\"7\" fill=\"#f3f5f7\" "
        "stroke=\"#4a5662\"/>"
        "<text x=\"{4:.1f}\" y=\"{5:.1f}\" font-size=\"13\" text-anchor=\"middle\" "
        "fill=\"#1d252c\">{6}</text>"
        "<text x=\"{4:.1f}\" y=\"{7:.1f}\" font-size=\"11\" text-anchor=\"middle\" "
        "fill=\"#66727d\">{8}</text></g>\n",
        x(i), y(i), kWidth, kHeight, x(i) + kWidth / 2, y(i) + 19, escape_xml(g.nodes[i].title), y(i) + 35,
        escape_xml(g.nodes[i].type));
  return out + "</svg>\n";
}

}  // namespace terrazzo
