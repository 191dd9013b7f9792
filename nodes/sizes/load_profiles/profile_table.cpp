#include "nodes/sizes/load_profiles/profile_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/io/reading.h"
#include "nodes/sizes/load_profiles/measured_table.h"

namespace terrazzo::load_profiles {
namespace {

// The unit of the numbers in each column of lengths or areas.
class Units {
 public:
  Units(const MeasuredTable& table, const std::string& file, const std::optional<ProfileUnit>& given)
      : table_(table), file_(file), given_(given) {
    find_common();
  }

  // mm per unit of a column of lengths, mm² per unit of a column of areas.
  double factor(std::size_t column, int power) {
    const ColumnHeader& header = table_.header(column);
    double mm = 1;
    if (!header.unit_text.empty()) {
      mm = checked(column, power);
    } else if (given_) {
      if (common_ && *common_ != given_->length)
        throw Error("contradicting-unit",
                    fmt::format("the columns of '{}' name another unit than the parameter unit, which is {}",
                                file_, given_->name),
                    fmt::format("leave out unit, or name the unit of the column '{}' in its header",
                                table_.name(column)))
            .parameter("unit");
      mm = given_->length;
    } else if (common_) {
      mm = *common_;
    } else {
      assumed_ = table_.name(column) + (power == 2 ? " (mm²)" : " (mm)");
    }
    return power == 2 ? mm * mm : mm;
  }

  // The last column that was read in mm because nothing names a unit; "" if there is none.
  const std::string& assumed() const { return assumed_; }

 private:
  // The unit in the header of a column, which must not contradict the parameter.
  double checked(std::size_t column, int power) const {
    const ColumnHeader& header = table_.header(column);
    const std::string place = fmt::format("the column '{}' of '{}'", table_.name(column), file_);
    if (!header.unit || header.unit->mm == 0)
      throw Error("unknown-unit",
                  fmt::format("{} {}", place,
                              header.unit ? "is in pixels, whose size is unknown" : "has an unknown unit"),
                  "convert the column to a unit such as µm or mm, and name it in the header")
          .parameter("path");
    // "Area (µm)" can only mean µm².
    if (header.unit->power > 0 && header.unit->power != power)
      throw Error("contradicting-unit",
                  fmt::format("{} has a unit that is not one of {}", place, power == 2 ? "area" : "length"),
                  "correct the header")
          .parameter("path");
    if (given_ && given_->length != header.unit->mm)
      throw Error(
          "contradicting-unit",
          fmt::format("{} has another unit than the parameter unit, which is {}", place, given_->name),
          "leave out unit if the header is right, or else correct the header")
          .parameter("unit");
    return header.unit->mm;
  }

  // A program measures all lengths of a table in one unit. It counts where the column of sizes names none.
  void find_common() {
    static const std::set<std::string> lengths = {
        "area",   "perim",    "perimeter", "feret",     "minferet",  "maxferet",
        "feretx", "ferety",   "width",     "height",    "major",     "minor",
        "x",      "y",        "xm",        "ym",        "bx",        "by",
        "length", "diameter", "ecd",       "centroidx", "centroidy", "equivalentdiameter"};
    for (const ColumnHeader& h : table_.headers()) {
      if (!h.unit || h.unit->mm == 0 || !lengths.count(h.name)) continue;
      if (common_ && *common_ != h.unit->mm) {
        common_.reset();
        return;
      }
      common_ = h.unit->mm;
    }
  }

  const MeasuredTable& table_;
  const std::string& file_;
  const std::optional<ProfileUnit>& given_;
  std::optional<double> common_;  // mm
  std::string assumed_;
};

View view_of(const MeasuredTable& table, std::size_t column) {
  for (const View view : kViews)
    if (table.text(column) == name_of(view)) return view;
  table.malformed("'" + printable(table.text(column)) + "' is not a view: section, surface or filling");
}

}  // namespace

std::optional<ProfileUnit> profile_unit(const std::string& name) {
  if (name == "auto") return std::nullopt;
  const auto unit = unit_of(name);
  if (!unit || unit->mm == 0 || unit->power > 2)
    throw Error("unknown-unit", "unknown unit '" + name + "'",
                "use mm, µm, um, nm, cm, m or one of their squares")
        .parameter("unit");
  return ProfileUnit{name, unit->mm, unit->mm * unit->mm};
}

Profiles read_profiles(const std::string& text, const std::string& file,
                       const std::optional<ProfileUnit>& unit,
                       const std::function<void(const std::string&)>& warn) {
  MeasuredTable table(text, file);
  const auto area = table.column({"area", "areas"});
  const auto diameter = table.column({"diameter", "diameters", "ecd", "equivalentdiameter", "equivdiameter",
                                      "eqdiameter", "equivalentcirculardiameter", "equivalentcirclediameter",
                                      "circularequivalentdiameter", "equivalentdiameterarea"});
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
  // Both are Export's; alone, they mean something else.
  auto whole = table.column({"whole"}), view = table.column({"view"});
  if (!whole || !view) whole = view = std::nullopt;
  const auto r = table.column({"colorr"}), g = table.column({"colorg"}), b = table.column({"colorb"});

  Units units(table, file, unit);
  const std::string short_name = printable(std::filesystem::path(file).filename().string());
  const std::size_t measured = area ? *area : *diameter;
  const double to_mm = units.factor(measured, area ? 2 : 1);
  const Vec2 position = x && y ? Vec2(units.factor(*x, 1), units.factor(*y, 1)) : Vec2(1, 1);
  // Export writes these columns, and mm.
  if (!units.assumed().empty() && !(border && confidence))
    warn(fmt::format("'{}' names no unit: it is read as {}; set unit", short_name, units.assumed()));

  Profiles out;
  while (table.next(measured)) {
    Profile p;
    const double size = table.number(measured);
    if (size <= 0)
      table.malformed("an area or diameter must be above 0; it is '" + printable(table.text(measured)) + "'");
    p.area = area ? size * to_mm : std::numbers::pi / 4 * size * to_mm * size * to_mm;
    if (section) p.section = table.whole(*section);
    if (!section && slice) p.section = std::max(0, table.whole(*slice) - 1);  // ImageJ counts from 1
    if (cls) p.cls = table.whole(*cls);
    if (weight) p.weight = table.number(*weight);
    if (p.weight < 0) table.malformed("a weight must be at least 0");
    if (confidence) p.confidence = table.number(*confidence);
    if (p.confidence < 0 || p.confidence > 1) table.malformed("a confidence must be from 0 to 1");
    if (border) p.touches_border = table.whole(*border) != 0;
    if (x && y) p.centroid = Vec2(table.number(*x), table.number(*y)).cwiseProduct(position);
    if (r && g && b) p.color = Vec3(table.number(*r), table.number(*g), table.number(*b)).cast<float>();
    if (view) {
      const View said = view_of(table, *view);
      if (!out.profiles.empty() && said != out.view)
        table.malformed(fmt::format("the view '{}' differs from that of the first row, {}", name_of(said),
                                    name_of(out.view)));
      out.view = said;
    }
    if (whole) p.whole = table.number(*whole) * units.factor(*whole, 2);
    if (out.view == View::Surface && whole && p.whole < p.area)
      table.malformed("a whole silhouette cannot be smaller than its visible area");
    out.sections = std::max(out.sections, p.section + 1);
    out.classes = std::max(out.classes, p.cls + 1);
    out.profiles.push_back(std::move(p));
  }
  if (const auto& left_out = table.statistics(); !left_out.empty()) {
    constexpr std::size_t kMost = 8;
    std::string list;
    for (std::size_t i = 0; i < std::min(left_out.size(), kMost); ++i)
      list += (i > 0 ? ", " : "") + left_out[i];
    warn(fmt::format("'{}': {} rows are statistics, not profiles, and are left out: {}{}", short_name,
                     left_out.size(), list, left_out.size() > kMost ? ", …" : ""));
  }
  if (out.profiles.empty())
    throw Error("no-particles", "'" + file + "' contains no rows below its header").parameter("path");
  return out;
}

}  // namespace terrazzo::load_profiles
