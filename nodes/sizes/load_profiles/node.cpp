#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "graph/node_type.h"
#include "nodes/common/io/json_input.h"
#include "nodes/common/io/text_input.h"
#include "nodes/data/image.h"
#include "nodes/sizes/load_profiles/profile_json.h"
#include "nodes/sizes/load_profiles/profile_outlines.h"
#include "nodes/sizes/load_profiles/profile_table.h"
#include "runtime/context.h"

namespace terrazzo::load_profiles {
namespace {

// A row has at least two characters. In memory it needs its text and its profile, each up to twice while the
// lists grow.
std::string text_of(const std::filesystem::path& file, Context& c) {
  try {
    std::string text = read_text(file, reading_of(c));
    require_memory(is_json(text) ? memory_to_read_json(text)
                                 : 4.0 * static_cast<double>(text.size()) +
                                       static_cast<double>(count_lines(text)) * (3 * sizeof(Profile) + 150),
                   c.memory(), "the profiles '" + file.string() + "'");
    return text;
  } catch (Error& e) {
    throw e.parameter("path");
  }
}

// The profiles of one file of outlines, whose text is "" if it has ImageJ's regions.
Profiles outlined_profiles(Context& c, const std::filesystem::path& path, const std::string& text) {
  const std::string file = path.string();
  const Reading reading = reading_of(c);
  const Image* image = c.optional<Image>("image");
  const MapPlace place = image ? image->georeference : MapPlace();
  OutlineFile outlines = text.empty() ? read_outline_file(path, reading, c.work(), place)
                                      : read_outline_text(text, file, reading, c.work(), place);
  if (image) {
    take_picture(outlines, *image, true, file);
    outlines.pixel_size = image->pixel_size;
  }
  if (c.keyword("pixel_size").empty()) outlines.pixel_size = c.number("pixel_size");
  if (outlines.pixel_size == 0) {
    c.warn(fmt::format("'{}' does not tell the size of a pixel: it is taken as 1 mm; set pixel_size",
                       printable(path.filename().string())));
    outlines.pixel_size = 1;
  }
  const double pixel_size = outlines.pixel_size;
  return profiles_of_outlines(std::move(outlines), pixel_size, image, file, reading, c.work());
}

// Neither outlines nor JSON can be joined with other files, or have a unit.
void require_alone(Context& c, const std::filesystem::path& file, const std::string& what,
                   const std::optional<ProfileUnit>& unit) {
  if (c.files("path").size() != 1)
    throw Error("several-files",
                fmt::format("'{}' {}, which cannot be joined with other files", file.string(), what),
                "name one file")
        .parameter("path");
  if (unit && unit->length != 1)
    throw Error("bad-value", fmt::format("'{}' {}, whose areas are in mm²", file.string(), what),
                "leave out the unit")
        .parameter("unit");
}

// The profiles of tables, or of one JSON file or file of outlines.
Profiles profiles_of(Context& c, bool& json) {
  const auto unit = profile_unit(c.text("unit"));
  Profiles all;
  all.sections = 0;
  for (const auto& file : c.files("path")) {
    c.work().check();
    const bool regions = is_region_file(file);
    const std::string text = regions ? "" : text_of(file, c);
    if (regions || is_outline_json(text)) {
      require_alone(c, file, "has outlines", unit);
      json = true;
      return outlined_profiles(c, file, text);
    }
    if (is_json(text)) {
      require_alone(c, file, "is JSON", unit);
      json = true;
      return read_profiles_json(text, file.string());
    }
    Profiles one = read_profiles(text, file.string(), unit, [&](const std::string& w) { c.warn(w); });
    if (!all.profiles.empty() && one.view != all.view)
      throw Error("several-files",
                  fmt::format("'{}' shows a {}, but the files before it show a {}", file.string(),
                              name_of(one.view), name_of(all.view)),
                  "load files of one view")
          .parameter("path");
    all.view = one.view;
    for (auto& p : one.profiles) {
      p.section += all.sections;
      all.profiles.push_back(std::move(p));
    }
    all.sections += one.sections;
    all.classes = std::max(all.classes, one.classes);
  }
  return all;
}

Vec3f mean_color(const std::vector<Profile>& profiles) {
  Vec3f sum = Vec3f::Zero();
  for (const Profile& p : profiles) sum += p.color;
  return sum / static_cast<float>(std::max<std::size_t>(1, profiles.size()));
}

// Takes what the parameter says, which must not contradict the file. Whole silhouettes that nobody measured
// are the visible ones. Tables do not have the color of the ground: that of the stones keeps it from being
// taken for shadow.
void set_view(Context& c, bool json, Profiles& all) {
  const std::string word = c.text("view");
  for (const View asked : kViews) {
    if (word != name_of(asked)) continue;
    if (all.view != View::Section && asked != all.view)
      throw Error("bad-value", fmt::format("the file says that the view is {}", name_of(all.view)),
                  "leave out view, or correct the file")
          .parameter("view");
    all.view = asked;
  }
  if (all.view == View::Surface && !json) all.binder_color = mean_color(all.profiles);
  for (Profile& p : all.profiles) p.whole = all.view == View::Surface ? std::max(p.whole, p.area) : 0;
}

// Areas are written with three digits or more, and so are their sum and the observed area. Profiles that fill
// the section may exceed it by as much.
constexpr double kRounding = 1e-3;

void compute(Context& c) {
  bool json = false;
  Profiles all = profiles_of(c, json);
  set_view(c, json, all);
  double sum = 0;
  for (const auto& p : all.profiles) sum += p.area;
  if (c.number("observed_area") > 0) {
    all.observed_area = c.number("observed_area");
    if (sum > (1 + kRounding) * all.observed_area)
      throw Error(
          "area-too-small",
          fmt::format("the profiles cover {:.6g} mm², which is {:.3g} times the observed area of {} mm²", sum,
                      sum / all.observed_area, all.observed_area),
          "check unit and observed_area (mm², total of all sections)")
          .parameter("observed_area");
    all.area_fraction = std::min(1.0, sum / all.observed_area);
  }
  c.metric("profiles", all.profiles.size());
  c.metric("area", sum);
  c.output("profiles", std::move(all));
}

}  // namespace
}  // namespace terrazzo::load_profiles

namespace terrazzo {

NodeType load_profiles_node() {
  using namespace load_profiles;
  return NodeType("LoadProfiles", 3)
      .doc_(
          "Reads profile areas or diameters measured with other software, such as ImageJ or GrainSizeTools, "
          "and "
          "profiles that Export wrote to .json, with their outlines. It also reads outlines: GeoJSON, COCO, "
          "and ImageJ's regions.")
      .source_("RFC 7946 (GeoJSON); COCO, format for object detection; ImageJ, RoiDecoder")
      .optional_input(
          "image", {"Image"},
          "Picture that outlines belong to: its size, sections, pixel_size and colors. Tables need none")
      .output("profiles", "Profiles", "Profile sizes; with outlines if the file is JSON")
      .parameter(Parameter::input_path("path").doc_("CSV or TSV file with a column area or diameter, or one "
                                                    "JSON file of profiles. A glob joins several "
                                                    "tables, each with its own sections. Or one file of "
                                                    "outlines: GeoJSON, COCO (.json), ImageJ (.roi, .zip)."))
      .parameter(
          Parameter::optional_number("pixel_size", "auto")
              .unit_("mm")
              .range(1e-9, 1e9)
              .doc_(
                  "Edge length of a pixel of outlines. auto: that of image, else what the file says, else 1, "
                  "with a warning. Tables do not use it."))
      .parameter(
          Parameter::number("observed_area", 0)
              .unit_("mm²")
              .range(0, 1e18)
              .doc_("Total area, over all sections, in which the profiles were counted. 0: what the JSON "
                    "file says; for tables, unknown, so densities are relative."))
      .parameter(
          Parameter::choice("view", "auto", {"auto", "section", "surface", "filling"})
              .doc_("What the picture shows in which the profiles were measured: section, a cut through "
                    "particles in a binder; surface, whole stones from outside; filling, a cut through "
                    "grains without a binder. auto: what the file says, else a section."))
      .parameter(
          Parameter::choice("unit", "auto",
                            {"auto", "mm", "µm", "um", "nm", "cm", "m", "mm²", "µm²", "mm2", "um2"})
              .doc_("Unit of length in the table. Areas are in its square. auto: the unit that the header "
                    "names, as in 'Area (µm²)', else mm. A header that names another unit than this "
                    "parameter is an error. JSON is in mm."))
      .compute_(compute);
}

}  // namespace terrazzo
