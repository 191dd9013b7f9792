#include <fmt/format.h>

#include <algorithm>

#include "graph/node_type.h"
#include "graph/utf8.h"
#include "nodes/common/io/json_input.h"
#include "nodes/common/io/reading.h"
#include "nodes/load_profiles/profile_json.h"
#include "nodes/load_profiles/profile_table.h"
#include "runtime/context.h"

namespace terrazzo::load_profiles {
namespace {

// A row has at least two characters. In memory it needs its text and its profile, each up to twice while the
// lists grow.
std::string file_of(const std::filesystem::path& file, Context& c) {
  try {
    std::string text = read_whole(file, reading_of(c));
    const auto rows = static_cast<double>(std::count(text.begin(), text.end(), '\n'));
    require_memory(is_json(text)
                       ? memory_to_read_json(text)
                       : 4.0 * static_cast<double>(text.size()) + rows * (3 * sizeof(Profile) + 150),
                   c.memory(), "the profiles '" + file.string() + "'");
    return text;
  } catch (Error& e) {
    throw e.parameter("path");
  }
}

// The profiles of tables, or of one JSON file.
Profiles profiles_of(Context& c) {
  const ProfileUnit unit = profile_unit(c.text("unit"));
  Profiles all;
  all.sections = 0;
  for (const auto& file : c.files("path")) {
    c.work().check();
    const std::string text = file_of(file, c), read = valid_utf8(text);
    if (read != text)
      c.warn("'" + file.filename().string() + "' is not UTF-8: invalid bytes are read as U+FFFD");
    if (is_json(read)) {
      if (c.files("path").size() != 1)
        throw Error("several-files",
                    "'" + file.string() + "' is JSON, which cannot be joined with other files",
                    "name one file")
            .parameter("path");
      if (unit.length != 1)
        throw Error("bad-value", "'" + file.string() + "' is JSON, which is in mm", "leave out the unit")
            .parameter("unit");
      return read_profiles_json(read, file.string());
    }
    Profiles one = read_profiles(read, file.string(), unit);
    for (auto& p : one.profiles) {
      p.section += all.sections;
      all.profiles.push_back(std::move(p));
    }
    all.sections += one.sections;
    all.classes = std::max(all.classes, one.classes);
  }
  return all;
}

void compute(Context& c) {
  Profiles all = profiles_of(c);
  double sum = 0;
  for (const auto& p : all.profiles) sum += p.area;
  if (c.number("observed_area") > 0) {
    all.observed_area = c.number("observed_area");
    all.area_fraction = sum / all.observed_area;
    if (all.area_fraction > 1)
      throw Error("area-too-small",
                  "the profiles cover " + fmt::format("{:g}", sum) +
                      " mm², which exceeds the observed area of " + fmt::format("{:g}", all.observed_area) +
                      " mm²",
                  "check unit and observed_area (mm², total of all sections)")
          .parameter("observed_area");
  }
  c.metric("profiles", static_cast<double>(all.profiles.size()));
  c.metric("area", sum);
  c.output("profiles", std::move(all));
}

}  // namespace
}  // namespace terrazzo::load_profiles

namespace terrazzo {

NodeType load_profiles_node() {
  using namespace load_profiles;
  return NodeType("LoadProfiles", 2)
      .doc_(
          "Reads profile areas or diameters measured with other software, such as ImageJ or GrainSizeTools, "
          "and "
          "profiles that Export wrote to .json, with their outlines.")
      .output("profiles", "Profiles", "Profile sizes; with outlines if the file is JSON")
      .parameter(Parameter::input_path("path").doc_("CSV or TSV file with a column area or diameter, or one "
                                                    "JSON file of profiles. A glob joins several "
                                                    "tables, each with its own sections."))
      .parameter(
          Parameter::number("observed_area", 0)
              .unit_("mm²")
              .range(0, 1e18)
              .doc_("Total area, over all sections, in which the profiles were counted. 0: what the JSON "
                    "file says; for tables, unknown, so densities are relative."))
      .parameter(
          Parameter::choice("unit", "mm", {"mm", "µm", "um", "nm", "cm", "m", "mm²", "µm²", "mm2", "um2"})
              .doc_("Unit of length in the table. Areas are in its square. JSON is in mm."))
      .compute_(compute);
}

}  // namespace terrazzo
