#include "nodes/photograph/edit_labels/edit_labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "graph/diagnostic.h"
#include "graph/text/read_number.h"
#include "nodes/common/texture/footprint.h"
#include "nodes/data/indices.h"

namespace terrazzo::edit_labels {
namespace {

constexpr int kMostSections = 1 << 20;
constexpr const char* kBetween = " \t\r\n,";

struct Word {
  const char* name;
  Edit::Kind kind;
  std::size_t least;  // points
};
constexpr std::array<Word, 5> kWords{{{"merge", Edit::Kind::Merge, 2},
                                      {"split", Edit::Kind::Split, 2},
                                      {"delete", Edit::Kind::Delete, 1},
                                      {"outline", Edit::Kind::Outline, 3},
                                      {"ignore", Edit::Kind::Ignore, 2}}};

[[noreturn]] void bad_edit(const std::string& text, const std::string& why) {
  throw Error("bad-value", "'" + text + "' is not an edit: " + why,
              "write merge, split, delete, outline or ignore, then x and y of its points, as in \"merge 10 "
              "12 30 14\"")
      .parameter("edits");
}

// Shortens a segment to its part within the picture (Liang and Barsky 1984); false if there is none.
bool clip(Vec2& from, Vec2& to, int width, int height) {
  double begin = 0, end = 1;
  const Vec2 a = from, step = to - from, most(width, height);
  for (int k = 0; k < 2; ++k) {
    if (step[k] == 0) {
      if (a[k] < 0 || a[k] > most[k]) return false;
      continue;
    }
    const double u = -a[k] / step[k], v = (most[k] - a[k]) / step[k];
    begin = std::max(begin, std::min(u, v));
    end = std::min(end, std::max(u, v));
  }
  if (begin > end) return false;
  from = a + begin * step;
  to = a + end * step;
  return true;
}

class Editor {
 public:
  Editor(const Labels& labels, Edited& out) : out_(out) {
    out_.labels = labels;
    out_.not_material = labels;
    std::fill(out_.not_material.ids.begin(), out_.not_material.ids.end(), 0);
    out_.not_material.classes.clear();
    for (const auto id : labels.ids)
      if (id < 0 || id > labels.count())
        throw Error("bad-labels", "a pixel has the label " + std::to_string(id) + ", but only " +
                                      std::to_string(labels.count()) + " labels have a class");
  }

  // Returns why the edit does not apply, or "".
  std::string apply(const Edit& e) {
    Labels& l = out_.labels;
    if (e.section >= l.sections) return "there is no section " + std::to_string(e.section);
    switch (e.kind) {
      case Edit::Kind::Merge:
        return merge(e);
      case Edit::Kind::Split:
        return split(e);
      case Edit::Kind::Delete:
        return remove(e);
      case Edit::Kind::Outline: {
        const auto pixels = surrounded(l.width, l.height, {e.points});
        if (pixels.empty()) return "the outline contains no pixel of the picture";
        const std::int32_t id = add_label(0);
        for (const auto i : pixels) l.ids[first_of(e) + i] = id;
        return "";
      }
      case Edit::Kind::Ignore: {
        std::vector<Vec2> area = e.points;
        if (area.size() == 2)
          area = {area[0], {area[1].x(), area[0].y()}, area[1], {area[0].x(), area[1].y()}};
        const auto pixels = surrounded(l.width, l.height, {area});
        if (pixels.empty()) return "the area contains no pixel of the picture";
        for (const auto i : pixels) {
          l.ids[first_of(e) + i] = 0;
          out_.not_material.ids[first_of(e) + i] = 1;
        }
        out_.not_material.classes = {0};
        return "";
      }
    }
    return "";
  }

 private:
  std::size_t first_of(const Edit& e) const { return out_.labels.index(0, 0, e.section); }
  std::int32_t add_label(int cls) {
    out_.labels.classes.push_back(cls);
    return out_.labels.count();
  }

  // 0: binder, or outside of the picture
  std::int32_t label_at(const Vec2& p, int section) const {
    const Labels& l = out_.labels;
    const double x = std::floor(p.x()), y = std::floor(p.y());
    if (!(x >= 0 && y >= 0 && x < l.width && y < l.height)) return 0;
    return l.ids[l.index(static_cast<int>(x), static_cast<int>(y), section)];
  }
  void replace(const std::vector<std::int32_t>& from, std::int32_t to) {
    for (auto& id : out_.labels.ids)
      if (std::find(from.begin(), from.end(), id) != from.end()) id = to;
  }

  std::string merge(const Edit& e) {
    std::vector<std::int32_t> ids;
    for (const Vec2& p : e.points) {
      const auto id = label_at(p, e.section);
      if (id == 0) return "there is no particle at one of its points";
      if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
    }
    if (ids.size() < 2) return "its points lie in one particle already";
    const std::int32_t kept = ids.front();
    ids.erase(ids.begin());
    replace(ids, kept);
    return "";
  }

  std::string remove(const Edit& e) {
    bool all = true;
    std::vector<std::int32_t> ids;
    for (const Vec2& p : e.points) {
      if (const auto id = label_at(p, e.section); id > 0)
        ids.push_back(id);
      else
        all = false;
    }
    replace(ids, 0);
    return all ? "" : "there is no particle at one of its points";
  }

  // The pixels of particles under the line of an edit, in its order.
  std::vector<std::size_t> pixels_under(const Edit& e) const {
    const Labels& l = out_.labels;
    std::vector<std::size_t> line;
    for (std::size_t k = 0; k + 1 < e.points.size(); ++k) {
      // Only the part within the picture cuts, so that a line of any length takes bounded time.
      Vec2 from = e.points[k], to = e.points[k + 1];
      if (!clip(from, to, l.width, l.height)) continue;
      const int steps = round_up(4 * (to - from).norm()) + 1;
      for (int s = 0; s <= steps; ++s) {
        const Vec2 p = from + (to - from) * (static_cast<double>(s) / steps);
        if (label_at(p, e.section) == 0) continue;
        const std::size_t i = l.index(round_down(p.x()), round_down(p.y()), e.section);
        if (line.empty() || line.back() != i) line.push_back(i);
      }
    }
    return line;
  }

  // The particle with most of these pixels, or 0.
  std::int32_t most_crossed(const std::vector<std::size_t>& line) const {
    std::map<std::int32_t, std::size_t> crossed;
    for (const std::size_t i : line) ++crossed[out_.labels.ids[i]];
    std::int32_t target = 0;
    std::size_t most = 0;
    for (const auto& [id, n] : crossed)
      if (n > most) {
        target = id;
        most = n;
      }
    return target;
  }

  std::string split(const Edit& e) {
    Labels& l = out_.labels;
    const std::vector<std::size_t> line = pixels_under(e);
    const std::int32_t target = most_crossed(line);
    if (target == 0) return "the line meets no particle";
    std::vector<std::uint8_t> cut(l.ids.size(), 0);
    for (const auto i : line)
      if (l.ids[i] == target) cut[i] = 1;
    // Pieces beside the line, by edges; then the line's own pixels join the piece they touch first.
    const std::size_t first = l.index(0, 0, e.section), last = first + pixels_in(l.width, l.height);
    std::vector<std::int32_t> piece(l.ids.size(), 0);
    std::vector<std::size_t> queue;
    std::int32_t pieces = 0;
    const auto spread = [&](std::size_t begin, bool over_line) {
      for (std::size_t q = begin; q < queue.size(); ++q) {
        const std::size_t i = queue[q], in = i - first;
        const int x = in % l.width, y = in / l.width;
        const auto visit = [&](std::size_t j) {
          if (l.ids[j] == target && piece[j] == 0 && (over_line || !cut[j])) {
            piece[j] = piece[i];
            queue.push_back(j);
          }
        };
        if (x > 0) visit(i - 1);
        if (x + 1 < l.width) visit(i + 1);
        if (y > 0) visit(i - l.width);
        if (y + 1 < l.height) visit(i + l.width);
      }
    };
    for (std::size_t i = first; i < last; ++i)
      if (l.ids[i] == target && !cut[i] && piece[i] == 0) {
        const std::size_t begin = queue.size();
        piece[i] = ++pieces;
        queue.push_back(i);
        spread(begin, false);
      }
    if (pieces < 2) return "the line does not divide the particle that it crosses";
    spread(0, true);
    std::vector<std::int32_t> number(pieces + 1, target);
    for (std::int32_t k = 2; k <= pieces; ++k) number[k] = add_label(l.classes[target - 1]);
    for (std::size_t i = first; i < last; ++i)
      if (piece[i] > 0) l.ids[i] = number[piece[i]];
    return "";
  }

  Edited& out_;
};

// Numbers the labels from 1 by their first pixel; those without pixels go.
void renumber(Labels& l) {
  std::vector<std::int32_t> number(l.classes.size() + 1, 0);
  std::vector<std::int32_t> classes;
  for (auto& id : l.ids) {
    if (id == 0) continue;
    if (number[id] == 0) {
      classes.push_back(l.classes[id - 1]);
      number[id] = classes.size();
    }
    id = number[id];
  }
  l.classes = std::move(classes);
}

}  // namespace

Edit read_edit(const std::string& text) {
  std::string_view words = text;
  Edit e;
  if (const auto colon = words.find(':'); colon != std::string::npos) {
    const auto section = read_numbers(words.substr(0, colon));
    if (!section || section->size() != 1 || !(section->at(0) >= 0 && section->at(0) < kMostSections) ||
        section->at(0) != std::floor(section->at(0)))
      bad_edit(text, "'" + text.substr(0, colon) + "' is not a section, from 0");
    e.section = static_cast<int>(section->at(0));
    words.remove_prefix(colon + 1);
  }
  words.remove_prefix(std::min(words.find_first_not_of(kBetween), words.size()));
  const std::string kind(words.substr(0, words.find_first_of(kBetween)));
  words.remove_prefix(kind.size());
  const auto word = std::find_if(kWords.begin(), kWords.end(), [&](const Word& w) { return kind == w.name; });
  if (word == kWords.end()) bad_edit(text, kind.empty() ? "it is empty" : "there is no edit '" + kind + "'");
  e.kind = word->kind;
  const auto numbers = read_numbers(words);
  if (!numbers || numbers->size() % 2 != 0 ||
      !std::all_of(numbers->begin(), numbers->end(), [](double x) { return std::abs(x) <= 1e9; }))
    bad_edit(text, "its points are not pairs of numbers up to 1e9");
  const std::vector<double>& v = *numbers;
  if (v.size() < 2 * word->least)
    bad_edit(text, kind + " needs " + std::to_string(word->least) +
                       (word->least == 1 ? " point" : " points") + " or more");
  for (std::size_t k = 0; k < v.size(); k += 2) e.points.emplace_back(v[k], v[k + 1]);
  return e;
}

Edited apply_edits(const Labels& labels, const std::vector<Edit>& edits, const Work& work) {
  Edited out;
  Editor editor(labels, out);
  for (std::size_t k = 0; k < edits.size(); ++k) {
    work.check();
    if (const std::string why = editor.apply(edits[k]); !why.empty())
      out.warnings.push_back("edit " + std::to_string(k + 1) + " no longer applies: " + why);
    work.done(k + 1, edits.size());
  }
  renumber(out.labels);
  return out;
}

}  // namespace terrazzo::edit_labels
