#include "nodes/load_profiles/profile_table.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "graph/diagnostic.h"
#include "nodes/common/io/reading.h"

namespace terrazzo::load_profiles {
namespace {

using Cells = std::vector<std::string>;

std::string trimmed(const std::string& s) {
  const auto first = s.find_first_not_of(" \t\r\n"), last = s.find_last_not_of(" \t\r\n");
  return first == std::string::npos ? "" : s.substr(first, last - first + 1);
}

// Splits at delimiters outside double quotes. A blank as delimiter matches any run of blanks.
Cells split(const std::string& line, char delimiter) {
  Cells cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"')
        cells.back() += line[i++];
      else
        quoted = !quoted;
    } else if (!quoted && line[i] == delimiter) {
      if (delimiter != ' ' || !cells.back().empty()) cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
  }
  for (auto& c : cells) c = trimmed(c);
  if (delimiter == ' ' && cells.back().empty()) cells.pop_back();
  return cells;
}

char delimiter_of(const std::string& line) {
  for (const char c : {'\t', ';', ','})
    if (line.find(c) != std::string::npos) return c;
  return ' ';
}

// A comma may be a decimal mark unless it separates the cells.
std::optional<double> number_in(std::string cell, char delimiter) {
  if (delimiter != ',' && cell.find('.') == std::string::npos &&
      std::count(cell.begin(), cell.end(), ',') == 1)
    std::replace(cell.begin(), cell.end(), ',', '.');
  double v = 0;
  const char* first = cell.data() + (!cell.empty() && cell[0] == '+');
  const auto [end, error] = std::from_chars(first, cell.data() + cell.size(), v);
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return v;
}

// "Area (µm²)" → "area", "Equivalent diameter [um]" → "equivalentdiameter".
std::string plain_name(std::string name) {
  for (const auto& [sign, letter] : {std::pair{"²", "2"}, {"µ", "u"}, {"μ", "u"}})
    for (auto at = name.find(sign); at != std::string::npos; at = name.find(sign))
      name.replace(at, std::string(sign).size(), letter);
  std::string plain;
  for (const char c : name) {
    if (c == '(' || c == '[') break;
    if (std::isalnum(static_cast<unsigned char>(c))) plain += static_cast<char>(std::tolower(c));
  }
  for (const char* suffix : {"mm2", "um2", "nm2", "cm2", "m2", "px2", "pixels2"}) {
    const std::string s = suffix;
    if (plain.size() > s.size() && plain.ends_with(s)) plain.resize(plain.size() - s.size());
  }
  return plain;
}

struct Line {
  int number;
  std::string text;
};

std::vector<Line> lines_of(const std::string& text) {
  std::vector<Line> lines;
  std::size_t at = text.starts_with("\xef\xbb\xbf") ? 3 : 0;
  for (int number = 1; at < text.size(); ++number) {
    const auto end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    if (const std::string t = trimmed(line); !t.empty() && t[0] != '#') lines.push_back({number, line});
  }
  return lines;
}

class Table {
 public:
  Table(const std::string& text, std::string file) : file_(std::move(file)), lines_(lines_of(text)) {
    if (lines_.empty()) throw Error("no-particles", "'" + file_ + "' contains no rows").parameter("path");
    delimiter_ = delimiter_of(trimmed(lines_[0].text));
    Cells header = split(without_end(lines_[0].text), delimiter_);
    bool numbers = true;
    for (const auto& c : header) numbers = numbers && number_in(c, delimiter_).has_value();
    if (numbers) {
      if (header.size() != 1)
        throw Error("no-column",
                    "'" + file_ + "' has " + std::to_string(header.size()) + " columns but no header line",
                    "add a header line that names a column area or diameter")
            .parameter("path");
      header = {"area"};
    } else {
      first_ = 1;
    }
    columns_ = header.size();
    // Some programs number the rows without a header for that column.
    if (first_ < lines_.size() && split(without_end(lines_[first_].text), delimiter_).size() == columns_ + 1)
      shift_ = 1;
    for (std::size_t i = 0; i < header.size(); ++i) index_.emplace(plain_name(header[i]), i + shift_);
    header_ = header;
  }

  std::optional<std::size_t> column(std::initializer_list<const char*> names) const {
    for (const char* n : names)
      if (const auto i = index_.find(n); i != index_.end()) return i->second;
    return std::nullopt;
  }
  std::size_t rows() const { return lines_.size() - first_; }
  Cells row(std::size_t i) const {
    Cells cells = split(without_end(lines_[first_ + i].text), delimiter_);
    if (cells.size() != columns_ + shift_)
      malformed(
          i, std::to_string(cells.size()) + " cells; " + std::to_string(columns_ + shift_) + " are expected");
    return cells;
  }
  double number(const Cells& cells, std::size_t i, std::size_t column) const {
    const auto v = number_in(cells[column], delimiter_);
    if (!v || !std::isfinite(*v))
      malformed(i, "'" + printable(cells[column]) + "' is not a number (column " + name(column) + ")");
    return *v;
  }
  int whole(const Cells& cells, std::size_t i, std::size_t column) const {
    const double v = number(cells, i, column);
    if (v < 0 || v != std::floor(v) || v > 1e9)
      malformed(i,
                "'" + printable(cells[column]) + "' is not a whole number ≥ 0 (column " + name(column) + ")");
    return static_cast<int>(v);
  }
  [[noreturn]] void malformed(std::size_t i, const std::string& what) const {
    throw Error("malformed-row", file_ + ":" + std::to_string(lines_[first_ + i].number) + ": " + what,
                "correct or remove the row")
        .parameter("path");
  }
  std::string name(std::size_t column) const {
    return column < shift_ ? "1" : printable(header_[column - shift_]);
  }
  std::string names() const {
    std::string all;
    for (const auto& h : header_) all += (all.empty() ? "" : ", ") + (h.empty() ? "''" : h);
    return printable(all);
  }

 private:
  std::string without_end(std::string line) const {
    while (!line.empty() && (line.back() == '\r' || line.back() == '\n')) line.pop_back();
    return line;
  }
  std::string file_;
  std::vector<Line> lines_;
  char delimiter_ = ',';
  std::size_t first_ = 0, columns_ = 0, shift_ = 0;
  Cells header_;
  std::map<std::string, std::size_t> index_;
};

}  // namespace

ProfileUnit profile_unit(const std::string& name) {
  std::string length = name;
  for (const char* square : {"²", "2", "^2"})
    if (length.ends_with(square)) length.resize(length.size() - std::string(square).size());
  if (length.ends_with("^")) length.pop_back();
  const std::map<std::string, double> mm = {{"mm", 1},    {"µm", 1e-3}, {"μm", 1e-3}, {"um", 1e-3},
                                            {"nm", 1e-6}, {"cm", 10},   {"m", 1000}};
  const auto found = mm.find(length);
  if (found == mm.end())
    throw Error("unknown-unit", "unknown unit '" + name + "'",
                "use mm, µm, um, nm, cm, m or one of their squares")
        .parameter("unit");
  return {found->second, found->second * found->second};
}

Profiles read_profiles(const std::string& text, const std::string& file, const ProfileUnit& unit) {
  const Table table(text, file);
  const auto area = table.column({"area", "areas"});
  const auto diameter =
      table.column({"diameter", "diameters", "ecd", "equivalentdiameter", "equivdiameter", "eqdiameter"});
  if (!area && !diameter)
    throw Error("no-column",
                "'" + file + "' has no column area or diameter; its columns are " + table.names(),
                "name one column area or diameter")
        .parameter("path");
  if (table.rows() == 0)
    throw Error("no-particles", "'" + file + "' contains no rows below its header").parameter("path");
  const auto section = table.column({"section"}), slice = table.column({"slice"}),
             cls = table.column({"class", "cls"});
  const auto weight = table.column({"weight"}), border = table.column({"touchesborder"}),
             confidence = table.column({"confidence"});
  const auto x = table.column({"centroidx"}), y = table.column({"centroidy"});
  const auto r = table.column({"colorr"}), g = table.column({"colorg"}), b = table.column({"colorb"});

  Profiles out;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const Cells cells = table.row(i);
    Profile p;
    const double size = table.number(cells, i, area ? *area : *diameter);
    if (size <= 0)
      table.malformed(i, "an area or diameter must be above 0; it is '" +
                             printable(cells[area ? *area : *diameter]) + "'");
    p.area = area ? size * unit.area : std::numbers::pi / 4 * size * unit.length * size * unit.length;
    if (section) p.section = table.whole(cells, i, *section);
    if (!section && slice)
      p.section = std::max(0, table.whole(cells, i, *slice) - 1);  // ImageJ counts from 1
    if (cls) p.cls = table.whole(cells, i, *cls);
    if (weight) p.weight = table.number(cells, i, *weight);
    if (p.weight < 0) table.malformed(i, "a weight must be at least 0");
    if (confidence) p.confidence = table.number(cells, i, *confidence);
    if (p.confidence < 0 || p.confidence > 1) table.malformed(i, "a confidence must be from 0 to 1");
    if (border) p.touches_border = table.whole(cells, i, *border) != 0;
    if (x && y) p.centroid = unit.length * Vec2(table.number(cells, i, *x), table.number(cells, i, *y));
    if (r && g && b)
      p.color = Vec3(table.number(cells, i, *r), table.number(cells, i, *g), table.number(cells, i, *b))
                    .cast<float>();
    out.sections = std::max(out.sections, p.section + 1);
    out.classes = std::max(out.classes, p.cls + 1);
    out.profiles.push_back(std::move(p));
  }
  return out;
}

}  // namespace terrazzo::load_profiles
