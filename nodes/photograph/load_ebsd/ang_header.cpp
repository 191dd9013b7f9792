#include "nodes/photograph/load_ebsd/ang_header.h"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>
#include <numbers>

#include "nodes/common/io/cell_rows.h"
#include "nodes/common/io/reading.h"
#include "nodes/data/indices.h"

namespace terrazzo::load_ebsd {
namespace {

Symmetry ang_symmetry(std::string_view code, const Lines& lines) {
  using enum LaueGroup;
  static const std::map<std::string_view, Symmetry> known = {
      {"1", {Triclinic}},     {"2", {Monoclinic, 2}}, {"20", {Monoclinic, 1}},  {"21", {Monoclinic, 0}},
      {"22", {Orthorhombic}}, {"4", {TetragonalLow}}, {"42", {TetragonalHigh}}, {"3", {TrigonalLow}},
      {"32", {TrigonalHigh}}, {"6", {HexagonalLow}},  {"62", {HexagonalHigh}},  {"23", {CubicLow}},
      {"43", {CubicHigh}}};
  const auto it = known.find(code);
  if (it == known.end())
    lines.unreadable(fmt::format("the symmetry '{}' is unknown", printable(code)),
                     "use the numbers of TSL, such as 43 for m-3m and 62 for 6/mmm");
  return it->second;
}

// Small letters and digits of a text.
std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c >= 'A' && c <= 'Z') out += static_cast<char>(c - 'A' + 'a');
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) out += c;
  }
  return out;
}

std::vector<std::string_view> list_of(std::string_view text) {
  std::vector<std::string_view> out;
  for (std::size_t at = 0; at <= text.size();) {
    const auto end = std::min(text.find(',', at), text.size());
    out.push_back(trimmed_cell(text.substr(at, end - at)));
    at = end + 1;
  }
  return out;
}

class HeaderReader {
 public:
  explicit HeaderReader(const Lines& lines) : lines_(lines) {}

  // A line without its #.
  void read(std::string_view line) {
    const auto end = line.find_first_of(" \t:");
    const std::string_view key = line.substr(0, end);
    std::string_view value =
        end == std::string_view::npos ? std::string_view() : trimmed_cell(line.substr(end + 1));
    if (value.starts_with(':')) value = trimmed_cell(value.substr(1));
    // Between "NOTES: Start" and "NOTES: End" is free text, but "HEADER: Start" is around everything.
    if (!notes_.empty()) {
      if (key == notes_ && value == "End") notes_.clear();
    } else if (value == "Start" && key != "HEADER") {
      notes_ = key;
    } else if (!read_phase(key, value) && !read_grid(key, value)) {
      read_columns(key, value, line);
    }
  }

  AngHeader result() {
    if (!units_.empty()) apply_units();
    for (auto* step : {&header_.grid.x_step, &header_.grid.y_step})
      if (*step) (*step)->value *= header_.length, (*step)->digit *= header_.length;
    return std::move(header_);
  }

 private:
  HeaderNumber number(std::string_view key, std::string_view value) const {
    const auto v = number_in(value);
    if (!v) lines_.malformed(fmt::format("{} must be a number; it is '{}'", key, printable(value)));
    return {*v, last_digit(value)};
  }
  std::int64_t whole(std::string_view key, std::string_view value) const {
    const double v = number(key, value).value;
    if (v < 0 || v > 1e9 || v != std::floor(v))
      lines_.malformed(fmt::format("{} must be a whole number from 0 to 1e9; it is {}", key, v));
    return static_cast<std::int64_t>(v);
  }

  bool read_phase(std::string_view key, std::string_view value) {
    // "Phase 1". Other text after the word is a note.
    if (key == "Phase" && number_in(value)) {
      const auto id = whole(key, value);
      if (id > 1'000'000)
        lines_.malformed(fmt::format("the number of a phase must be at most 1000000; it is {}", id));
      start_phase(id);
      numbered_ = true;
    } else if (key == "MaterialName") {
      // ASTAR does not number its phases.
      if (!numbered_) start_phase(count_of(header_.phases) + 1);
      phase_->name = printable(value);
    } else if (key == "Symmetry" && phase_) {
      phase_->symmetry = ang_symmetry(value, lines_);
    } else {
      return false;
    }
    return true;
  }

  void start_phase(int id) {
    if (header_.phases.size() >= 1000) lines_.malformed("there are more than 1000 phases");
    phase_ = &header_.phases[id];
  }

  bool read_grid(std::string_view key, std::string_view value) {
    GridHeader& g = header_.grid;
    if (key == "GRID") {
      const std::string kind = plain(value);  // "SqrGrid", and "SqrGrid#" of ASTAR
      const bool hexagonal = kind.starts_with("hex");
      if (!hexagonal && !kind.starts_with("sqr") && !kind.starts_with("square"))
        lines_.malformed(fmt::format("GRID must be SqrGrid or HexGrid; it is '{}'", printable(value)));
      g.hexagonal = hexagonal;
    } else if (key == "XSTEP") {
      g.x_step = number(key, value);
    } else if (key == "YSTEP") {
      g.y_step = number(key, value);
    } else if (key == "NCOLS_ODD") {
      g.odd = whole(key, value);
    } else if (key == "NCOLS_EVEN") {
      g.even = whole(key, value);
    } else if (key == "NROWS") {
      g.rows = whole(key, value);
    } else {
      return false;
    }
    return true;
  }

  void read_columns(std::string_view key, std::string_view value, std::string_view line) {
    if (key == "COLUMN_HEADERS") {
      name_columns(value);
    } else if (key == "Column" && value.starts_with("names:")) {  // orix
      name_columns(trimmed_cell(value.substr(6)));
    } else if (key == "COLUMN_UNITS") {
      for (const auto unit : list_of(value)) units_.push_back(plain(unit));
    } else if (const std::string text = plain(line);
               text.starts_with("filecreatedfromacomres") || text.starts_with("temdata")) {
      header_.length = 1e-3;  // maps of transmission electron microscopes are in nm
    }
  }

  void name_columns(std::string_view value) {
    using Names = std::initializer_list<std::string_view>;
    static const Names known[AngHeader::Columns] = {{"phi1", "euler1"},
                                                    {"phi", "euler2"},
                                                    {"phi2", "euler3"},
                                                    {"x"},
                                                    {"y"},
                                                    {"iq", "imagequality"},
                                                    {"ci", "confidenceindex"},
                                                    {"phaseindex", "phase", "phaseid"}};
    header_.at.fill(std::string_view::npos);
    header_.names_columns = true;
    const auto names = list_of(value);
    for (std::size_t i = 0; i < names.size(); ++i)
      for (std::size_t k = 0; k < AngHeader::Columns; ++k)
        for (const std::string_view name : known[k])
          if (plain(names[i].substr(0, names[i].find_first_of("[("))) == name) header_.at[k] = i;
    for (const int k : {AngHeader::Phi1, AngHeader::Phi, AngHeader::Phi2, AngHeader::X, AngHeader::Y})
      if (header_.at[k] == std::string_view::npos)
        lines_.malformed(fmt::format("the header names no column {}", *known[k].begin()));
  }

  // The unit of the columns that have one of the two; "" if none is named.
  std::string unit_of(AngHeader::Column a, AngHeader::Column b) const {
    std::string out;
    for (const std::size_t i : {header_.at[a], header_.at[b]}) {
      const std::string unit = i < units_.size() ? units_[i] : "";
      if (!out.empty() && unit != out)
        lines_.unreadable(fmt::format("COLUMN_UNITS names '{}' and '{}' for columns of one kind", out, unit));
      out = unit;
    }
    return out;
  }

  void apply_units() {
    static const std::map<std::string, double> angles = {{"", 1},
                                                         {"radians", 1},
                                                         {"radian", 1},
                                                         {"rad", 1},
                                                         {"degrees", std::numbers::pi / 180},
                                                         {"degree", std::numbers::pi / 180},
                                                         {"deg", std::numbers::pi / 180}};
    static const std::map<std::string, double> lengths = {{"", 1},
                                                          {"microns", 1},
                                                          {"micron", 1},
                                                          {"um", 1},
                                                          {"micrometers", 1},
                                                          {"nm", 1e-3},
                                                          {"nanometers", 1e-3},
                                                          {"mm", 1000},
                                                          {"millimeters", 1000}};
    const auto angle = angles.find(unit_of(AngHeader::Phi1, AngHeader::Phi));
    const auto length = lengths.find(unit_of(AngHeader::X, AngHeader::Y));
    if (angle == angles.end() || length == lengths.end())
      lines_.unreadable("COLUMN_UNITS has an unknown unit of angles or lengths",
                        "use radians or degrees, and microns, nm or mm");
    header_.angle = angle->second;
    if (!length->first.empty()) header_.length = length->second;
  }

  const Lines& lines_;
  AngHeader header_;
  Phase* phase_ = nullptr;
  bool numbered_ = false;  // phases have numbers
  std::string notes_;      // the block of notes that is being skipped
  std::vector<std::string> units_;
};

}  // namespace

AngHeader read_ang_header(Lines& lines) {
  HeaderReader reader(lines);
  std::string_view line;
  bool any = false;
  while (lines.next(line)) {
    const std::string_view text = trimmed_cell(line);
    if (text.empty()) continue;
    if (!text.starts_with('#')) {
      lines.back();
      break;
    }
    any = true;
    reader.read(trimmed_cell(text.substr(1)));
  }
  if (!any)
    lines.unreadable(
        "it has no header",
        "use an .ang file of EDAX/TSL or a .ctf file of Oxford/HKL; the programs of the instruments "
        "export them");
  AngHeader out = reader.result();
  if (out.phases.empty())
    lines.unreadable("its header names no phase", "export the map with its full header");
  if (out.phases.size() > 1 && out.phases.count(0)) lines.unreadable("a phase has the number 0");
  return out;
}

}  // namespace terrazzo::load_ebsd
