#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/cooccurrence/load_strokes/stroke_files.h"
#include "runtime/context.h"

namespace terrazzo::load_strokes {
namespace {

void compute(Context& c) {
  const auto& files = c.files("path");
  if (files.size() != 1)
    throw Error("several-files", fmt::format("path matches {} files", files.size()), "name a single file")
        .parameter("path");
  const std::string extension = files[0].extension().string();
  const bool svg = extension == ".svg" || extension == ".SVG";
  if (!svg && extension != ".yaml" && extension != ".yml" && extension != ".json")
    throw Error("unknown-format",
                "strokes are read from .svg, .yaml, .yml and .json files, not from '" + extension + "'")
        .parameter("path");
  Strokes out;
  try {
    out = svg ? read_svg(files[0], reading_of(c)) : read_yaml(files[0], reading_of(c));
  } catch (Error& e) {
    throw e.parameter("path");
  }
  const double scale = c.number("scale");
  for (auto& s : out.strokes) {
    s.radius *= scale;
    for (auto& part : s.parts)
      for (auto& p : part) p *= scale;
  }
  if (out.strokes.empty()) c.warn("the file contains no strokes");
  c.metric("strokes", out.strokes.size());
  c.output("strokes", std::move(out));
}

}  // namespace
}  // namespace terrazzo::load_strokes

namespace terrazzo {

NodeType load_strokes_node() {
  using namespace load_strokes;
  return NodeType("LoadStrokes", 1)
      .doc_("Reads strokes for TextureNib from an SVG drawing, a YAML list, or JSON that Export wrote.")
      .source_("SVG 1.1, sections 7 to 9 and F.6")
      .output("strokes", "Strokes", "Strokes, in file order")
      .parameter(Parameter::input_path("path").doc_(
          "An .svg drawing or a .yaml list. SVG shapes with a stroke become lines with a nib radius of half "
          "the stroke width; shapes with only a fill become areas. A .yaml file lists {radius, points} and "
          "{area: true, points}, and so does a .json file that Export wrote."))
      .parameter(Parameter::number("scale", 1)
                     .above(0)
                     .range(1e-6, 1e6)
                     .unit_("pixels")
                     .doc_("Size of one unit of the file"))
      .compute_(compute);
}

}  // namespace terrazzo
