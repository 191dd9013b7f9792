#include "nodes/load_profiles/profile_table.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/common/io/cell_rows.h"
#include "nodes/common/io/reading.h"

namespace terrazzo::load_profiles {
namespace {

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

// A table with named columns, read row by row.
class ProfileTable {
 public:
  ProfileTable(const std::string& text, const std::string& file)
      : file_(file), rows_(text, file, {.separators = "\t;, ", .comments = true}) {
    CellRow header;
    if (!rows_.next(header))
      throw Error("no-particles", "'" + file_ + "' contains no rows").parameter("path");
    bool numbers = true;
    for (const auto& c : header.cells) {
      header_.push_back(c.text);
      numbers = numbers && number_in(c).has_value();
    }
    if (numbers) {
      if (header_.size() != 1)
        throw Error("no-column",
                    "'" + file_ + "' has " + std::to_string(header_.size()) + " columns but no header line",
                    "add a header line that names a column area or diameter")
            .parameter("path");
      header_ = {"area"};
      first_ = std::move(header);
    } else if (CellRow row; rows_.next(row)) {
      // Some programs number the rows without a header for that column.
      if (row.cells.size() == header_.size() + 1) shift_ = 1;
      first_ = std::move(row);
    }
    for (std::size_t i = 0; i < header_.size(); ++i) index_.emplace(plain_name(header_[i]), i + shift_);
  }

  std::optional<std::size_t> column(std::initializer_list<const char*> names) const {
    for (const char* n : names)
      if (const auto i = index_.find(n); i != index_.end()) return i->second;
    return std::nullopt;
  }
  // Reads the next row below the header. Returns false at the end.
  bool next() {
    if (first_) {
      row_ = std::move(*first_);
      first_.reset();
    } else if (!rows_.next(row_)) {
      return false;
    }
    rows_.require_cells(row_, header_.size() + shift_);
    return true;
  }
  // A cell of the row that was read last.
  const std::string& text(std::size_t column) const { return row_.cells[column].text; }
  double number(std::size_t column) const {
    const auto v = number_in(row_.cells[column]);
    if (!v || !std::isfinite(*v))
      malformed("'" + printable(text(column)) + "' is not a number (column " + name(column) + ")");
    return *v;
  }
  int whole(std::size_t column) const {
    const double v = number(column);
    if (v < 0 || v != std::floor(v) || v > 1e9)
      malformed("'" + printable(text(column)) + "' is not a whole number ≥ 0 (column " + name(column) + ")");
    return static_cast<int>(v);
  }
  [[noreturn]] void malformed(const std::string& what) const { rows_.malformed(row_.line, what); }
  std::string names() const {
    std::string all;
    for (const auto& h : header_) all += (all.empty() ? "" : ", ") + (h.empty() ? "''" : h);
    return printable(all);
  }

 private:
  // Numbers may be in quotes.
  std::optional<double> number_in(const CellRow::Cell& cell) const {
    return cell_number(trimmed_cell(cell.text), rows_.separator() != ',');
  }
  std::string name(std::size_t column) const {
    return column < shift_ ? "1" : printable(header_[column - shift_]);
  }

  std::string file_;
  CellReader rows_;
  std::vector<std::string> header_;
  std::size_t shift_ = 0;         // columns without a header before the others
  std::optional<CellRow> first_;  // the first row below the header, until next() returns it
  CellRow row_;
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
  ProfileTable table(text, file);
  const auto area = table.column({"area", "areas"});
  const auto diameter =
      table.column({"diameter", "diameters", "ecd", "equivalentdiameter", "equivdiameter", "eqdiameter"});
  if (!area && !diameter)
    throw Error("no-column",
                "'" + file + "' has no column area or diameter; its columns are " + table.names(),
                "name one column area or diameter")
        .parameter("path");
  const auto section = table.column({"section"}), slice = table.column({"slice"}),
             cls = table.column({"class", "cls"});
  const auto weight = table.column({"weight"}), border = table.column({"touchesborder"}),
             confidence = table.column({"confidence"});
  const auto x = table.column({"centroidx"}), y = table.column({"centroidy"});
  const auto r = table.column({"colorr"}), g = table.column({"colorg"}), b = table.column({"colorb"});

  Profiles out;
  while (table.next()) {
    Profile p;
    const double size = table.number(area ? *area : *diameter);
    if (size <= 0)
      table.malformed("an area or diameter must be above 0; it is '" +
                      printable(table.text(area ? *area : *diameter)) + "'");
    p.area = area ? size * unit.area : std::numbers::pi / 4 * size * unit.length * size * unit.length;
    if (section) p.section = table.whole(*section);
    if (!section && slice) p.section = std::max(0, table.whole(*slice) - 1);  // ImageJ counts from 1
    if (cls) p.cls = table.whole(*cls);
    if (weight) p.weight = table.number(*weight);
    if (p.weight < 0) table.malformed("a weight must be at least 0");
    if (confidence) p.confidence = table.number(*confidence);
    if (p.confidence < 0 || p.confidence > 1) table.malformed("a confidence must be from 0 to 1");
    if (border) p.touches_border = table.whole(*border) != 0;
    if (x && y) p.centroid = unit.length * Vec2(table.number(*x), table.number(*y));
    if (r && g && b) p.color = Vec3(table.number(*r), table.number(*g), table.number(*b)).cast<float>();
    out.sections = std::max(out.sections, p.section + 1);
    out.classes = std::max(out.classes, p.cls + 1);
    out.profiles.push_back(std::move(p));
  }
  if (out.profiles.empty())
    throw Error("no-particles", "'" + file + "' contains no rows below its header").parameter("path");
  return out;
}

}  // namespace terrazzo::load_profiles
