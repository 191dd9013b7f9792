#include <fmt/format.h>
#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/yaml.h>

#include "nodes/common/io/cell_rows.h"
#include "nodes/common/io/stroke_text.h"
#include "nodes/common/io/text_input.h"
#include "nodes/cooccurrence/load_strokes/stroke_files.h"

namespace terrazzo::load_strokes {
namespace {

std::string where(const YAML::Node& n) { return fmt::format("line {}", n.Mark().line + 1); }

Error bad_yaml(const std::string& what) {
  return Error("bad-strokes-file", what,
               "write each entry as {radius: 6, points: [[10, 20], [30, 40]]} or {area: true, points: …}");
}

// The locale does not matter.
double number_of(const YAML::Node& n) {
  const auto v = n.IsScalar() ? cell_number(n.Scalar(), false) : std::nullopt;
  if (!v)
    throw bad_yaml(where(n) + ": '" + printable(n.IsScalar() ? n.Scalar() : "a list") + "' is not a number");
  return *v;
}

// `left` is the number of points that may still be created. YAML aliases can repeat a list, so a small file
// can contain any number.
std::vector<Vec2> points_of(const YAML::Node& n, std::size_t& left) {
  if (!n.IsSequence()) throw bad_yaml(where(n) + ": points must be a list of [x, y]");
  std::vector<Vec2> out;
  for (const auto& p : n) {
    if (left-- == 0)
      throw Error("too-large", "the strokes have more points than fit in memory", "remove some strokes");
    if (!p.IsSequence() || p.size() != 2) throw bad_yaml(where(p) + ": a point must be [x, y]");
    out.emplace_back(number_of(p[0]), number_of(p[1]));
  }
  return out;
}

Stroke stroke_of(const YAML::Node& n, std::size_t& left) {
  if (n.IsScalar()) return strokes::read_stroke(n.Scalar());
  if (!n.IsMap()) throw bad_yaml(where(n) + ": a stroke must be a map or a line of text");
  Stroke s;
  for (const auto& entry : n) {
    const auto key = entry.first.as<std::string>();
    if (key == "radius")
      s.radius = number_of(entry.second);
    else if (key == "area")
      s.area = entry.second.as<bool>();
    else if (key == "points")
      s.parts.push_back(points_of(entry.second, left));
    else if (key == "parts") {
      if (!entry.second.IsSequence())
        throw bad_yaml(where(entry.second) + ": parts must be a list of lists of points");
      for (const auto& part : entry.second) s.parts.push_back(points_of(part, left));
    } else {
      throw bad_yaml(fmt::format("{}: unknown stroke field '{}'", where(entry.first), printable(key)));
    }
  }
  try {
    check_stroke(s);
  } catch (const Error& e) {
    throw bad_yaml(where(n) + ": " + e.diagnostic().message);
  }
  return s;
}

}  // namespace

Strokes read_yaml(const std::filesystem::path& file, const Reading& reading) {
  // A node of the document has at least two characters and uses about 300 bytes.
  std::string text = read_text(file, reading);
  // yaml-cpp does not know lines that end with CR alone.
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '\r' && (i + 1 == text.size() || text[i + 1] != '\n')) text[i] = '\n';
  require_memory(200.0 * text.size(), reading.memory, "the strokes in '" + file.string() + "'");
  std::size_t left = reading.memory / (4 * sizeof(Vec2));
  try {
    const YAML::Node root = YAML::Load(text);
    const YAML::Node list = root.IsMap() ? root["strokes"] : root;
    if (!list || !list.IsSequence()) throw bad_yaml("the list 'strokes' is missing");
    Strokes out;
    for (const auto& n : list) out.strokes.push_back(stroke_of(n, left));
    return out;
  } catch (const YAML::DeepRecursion& e) {
    throw bad_yaml(fmt::format("line {}: values are nested more than {} deep", e.mark.line + 1, e.depth()));
  } catch (const YAML::Exception& e) {
    throw bad_yaml(fmt::format("line {}: {}", e.mark.line + 1, printable(e.msg)));
  }
}

}  // namespace terrazzo::load_strokes
