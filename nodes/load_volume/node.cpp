#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "graph/node_type.h"
#include "nodes/common/geometry/voxel_grids.h"
#include "nodes/load_volume/dream3d.h"
#include "nodes/load_volume/scan.h"
#include "nodes/load_volume/vdb.h"
#include "nodes/load_volume/vti.h"
#include "runtime/context.h"

namespace terrazzo::load_volume {
namespace {

void require_one(const std::vector<std::filesystem::path>& files, const char* format) {
  if (files.size() > 1)
    throw Error("several-files",
                fmt::format("path matches {} {} files, each a separate volume", files.size(), format),
                "name a single file")
        .parameter("path");
}

LoadedScan read(const std::vector<std::filesystem::path>& files, const Work& work, const Reading& reading) {
  if (is_nifti(files[0])) {
    require_one(files, "NIfTI");
    return read_nifti(files[0], work, reading);
  }
  if (is_npy(files[0])) {
    require_one(files, "NumPy");
    return read_npy(files[0], work, reading);
  }
  return is_dicom(files[0]) ? read_dicom(files, work, reading) : read_slices(files, work, reading);
}

// The parameter, if it is set.
std::optional<Vec3> given_spacing(const Context& c) {
  if (!c.keyword("spacing").empty()) return {};
  const auto s = c.numbers("spacing");
  if (*std::min_element(s.begin(), s.end()) < kSmallestSpacing)
    throw Error("bad-spacing", "spacing is below 1e-9 mm", "write the edge lengths of a voxel in mm")
        .parameter("spacing");
  if (s.size() == 2)
    throw Error("bad-spacing", "spacing has two numbers", "write one number, or three for x, y and z")
        .parameter("spacing");
  return s.size() == 3 ? Vec3(s[0], s[1], s[2]) : Vec3::Constant(s[0]);
}

Vec3 spacing_of(const Context& c, const LoadedScan& scan) {
  if (const auto given = given_spacing(c)) return *given;
  if (!scan.spacing.allFinite() || scan.spacing.minCoeff() < kSmallestSpacing)
    throw Error("no-spacing", "the file does not contain the size of its voxels", "set spacing, in mm")
        .parameter("spacing");
  return scan.spacing;
}

// Applies slope and intercept from the parameters if set, else from the file.
void rescale(Context& c, LoadedScan& scan) {
  const bool own_slope = c.keyword("slope").empty(), own_intercept = c.keyword("intercept").empty();
  const double slope = own_slope ? c.number("slope") : scan.slope.value_or(1);
  const double intercept = own_intercept ? c.number("intercept") : scan.intercept.value_or(0);
  if (!scan.slope && !own_slope && !own_intercept)
    c.warn("the file contains no rescale: stored numbers are used unchanged");
  std::size_t bad = 0, first = 0;
  for (std::size_t i = 0; i < scan.values.size(); ++i) {
    if (i % (1u << 22) == 0) c.work().check();
    const double v = slope * scan.values[i] + intercept;
    scan.values[i] = static_cast<float>(v);
    if (!std::isfinite(scan.values[i]) && bad++ == 0) first = i;
  }
  if (bad == 0) return;
  const std::size_t nx = static_cast<std::size_t>(scan.size.x()),
                    ny = static_cast<std::size_t>(scan.size.y());
  throw Error("bad-values",
              fmt::format("{} of {} voxels are NaN or infinite, the first at ({}, {}, {})", bad,
                          scan.values.size(), first % nx, first / nx % ny, first / nx / ny),
              "replace those voxels")
      .parameter("path");
}

// Particle indices are whole numbers that floats hold exactly.
void check_ids(const LoadedScan& scan) {
  for (std::size_t i = 0; i < scan.values.size(); ++i)
    if (const float v = scan.values[i]; v != std::nearbyint(v) || std::abs(v) > 16777216.0f)
      throw Error("bad-labels",
                  fmt::format("the grid id contains {} at voxel {}; it holds whole numbers up to 2^24", v, i),
                  "set grid to another name, or slope and intercept so that values are whole")
          .parameter("grid");
}

void compute(Context& c) {
  const auto& files = c.files("path");
  const std::string name = c.text("grid");
  if (is_vdb(files[0])) {
    require_one(files, "OpenVDB");
    if (c.keyword("spacing").empty() || c.keyword("slope").empty() || c.keyword("intercept").empty())
      c.warn(
          "spacing, slope and intercept have no effect on OpenVDB files, which contain their own transform");
    Volume volume = read_vdb(files[0], name, reading_of(c));
    for (const auto& note : make_names_valid(volume)) c.warn(note);
    c.output("volume", std::move(volume));
    return;
  }
  const bool vti = is_vti(files[0]);
  if (vti || is_hdf5(files[0])) {
    const char* format = vti ? "VTK" : "DREAM3D";
    require_one(files, format);
    if (c.keyword("slope").empty() || c.keyword("intercept").empty())
      c.warn(fmt::format("slope and intercept have no effect on {} files", format));
    Volume volume =
        (vti ? read_vti : read_dream3d)(files[0], name, given_spacing(c), reading_of(c), c.work());
    for (const auto& note : make_names_valid(volume)) c.warn(note);
    c.output("volume", std::move(volume));
    return;
  }
  LoadedScan scan = read(files, c.work().part(0, 0.7), reading_of(c));
  for (const auto& note : scan.notes) c.warn(note);
  const Vec3 spacing = spacing_of(c, scan);
  rescale(c, scan);
  float low = scan.values[0], high = low;
  for (const float v : scan.values) low = std::min(low, v), high = std::max(high, v);
  c.metric("min", low), c.metric("max", high);
  c.metric("voxels", static_cast<double>(scan.values.size()));
  Volume volume;
  if (name == "id") {
    check_ids(scan);
    add_id_grid(volume, name, scan.size, spacing, c.work().part(0.7, 1),
                [&](std::size_t i) { return static_cast<std::int32_t>(scan.values[i]); });
    return c.output("volume", std::move(volume));
  }
  add_number_grid(volume, name.empty() ? "density" : name, scan.size, spacing, c.work().part(0.7, 1),
                  [&](std::size_t i) { return scan.values[i]; });
  c.output("volume", std::move(volume));
}

}  // namespace
}  // namespace terrazzo::load_volume

namespace terrazzo {

NodeType load_volume_node() {
  using namespace load_volume;
  return NodeType("LoadVolume", 3)
      .doc_(
          "Reads a volume: OpenVDB, VTK image data, DREAM3D, NIfTI, a NumPy array, a DICOM series, or a "
          "stack of "
          "gray images.")
      .source_("OpenVDB, libnifti, DCMTK, OpenImageIO, VTK XML 1.0, DREAM3D file version 7.0, NumPy .npy")
      .output(
          "volume", "Volume",
          "A scan becomes one float grid, in Hounsfield units or the units of its rescale, with x to the "
          "right, y to the front and z to the head. Grids of an OpenVDB file are returned unchanged, cell "
          "data of VTK and DREAM3D files as grids of the same names; FeatureIds of a DREAM3D file, less 1, "
          "as the grid id.")
      .parameter(Parameter::input_path("path").doc_("Volume file, or a glob that names the slices of one "
                                                    "series or stack. The content determines the format."))
      .parameter(
          Parameter::text("grid", "")
              .doc_("OpenVDB, VTK and DREAM3D: name of the single grid to read; empty: all grids. Other "
                    "formats: name of the output grid; empty: density; id: whole numbers, the index of "
                    "the particle at each voxel, negative in the binder."))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "spacing", "auto")
                     .above(0)
                     .count(1, 3)
                     .unit_("mm")
                     .doc_("Edge lengths of a voxel, one number or three. auto: from the file; image stacks "
                           "and NumPy arrays contain no spacing. Lengths in VTK files are meters, in DREAM3D "
                           "files micrometers."))
      .parameter(Parameter::optional_number("slope", "auto")
                     .range(-1e12, 1e12)
                     .doc_("Factor in value = slope · stored + intercept. auto: from the file, else 1."))
      .parameter(Parameter::optional_number("intercept", "auto")
                     .range(-1e12, 1e12)
                     .doc_("Offset in value = slope · stored + intercept. auto: from the file, else 0."))
      .companion_files_([](const std::filesystem::path& path) {
        return is_vdb(path) || is_vti(path) || is_hdf5(path) || is_npy(path) || is_dicom(path)
                   ? std::vector<std::filesystem::path>()
                   : nifti_companions(path);
      })
      .compute_(compute);
}

}  // namespace terrazzo
