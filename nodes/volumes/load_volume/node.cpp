#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "graph/node_type.h"
#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/volumes/load_volume/dream3d.h"
#include "nodes/volumes/load_volume/scan.h"
#include "nodes/volumes/load_volume/slices.h"
#include "nodes/volumes/load_volume/vdb.h"
#include "nodes/volumes/load_volume/vti.h"
#include "nodes/volumes/load_volume/zip.h"
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

// The formats with one volume per file that become one grid.
struct ScanFormat {
  const char* name;
  bool (*is)(const std::filesystem::path&);
  LoadedScan (*read)(const std::filesystem::path&, const Work&, const Reading&);
};
constexpr ScanFormat kScanFormats[] = {{"NIfTI", is_nifti, read_nifti},
                                       {"NumPy", is_npy, read_npy},
                                       {"NRRD", is_nrrd, read_nrrd},
                                       {"MetaImage", is_metaimage, read_metaimage},
                                       {"MRC", is_mrc, read_mrc}};

SliceOptions slice_choice(const Context& c) { return {page_choice(c), c.text("order") == "stored"}; }

LoadedScan read(const std::vector<std::filesystem::path>& files, const std::string& entry,
                const SliceOptions& slices, const Work& work, const Reading& reading) {
  if (is_zip(files[0])) {
    require_one(files, "zip");
    return read_zip(files[0], entry, slices, work, reading);
  }
  for (const ScanFormat& format : kScanFormats)
    if (format.is(files[0])) {
      require_one(files, format.name);
      return format.read(files[0], work, reading);
    }
  if (is_dicom(files[0])) return read_dicom(files, work, reading);
  refuse_foreign(files[0]);
  try {
    return read_slices(files, slices, work, reading);
  } catch (const Error& e) {
    if (e.diagnostic().code != "unreadable-image") throw;
    throw no_volume(files[0], e);
  }
}

// The files that are opened along with the named one.
std::vector<std::filesystem::path> companions(const std::filesystem::path& path) {
  if (is_vdb(path) || is_vti(path) || is_hdf5(path) || is_npy(path) || is_dicom(path) || is_zip(path))
    return {};
  if (is_nrrd(path)) return nrrd_companions(path);
  if (is_metaimage(path)) return metaimage_companions(path);
  return nifti_companions(path);
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
  const Vec3 spacing = s.size() == 3 ? Vec3(s[0], s[1], s[2]) : Vec3::Constant(s[0]);
  require_representable(spacing);
  return spacing;
}

Vec3 spacing_of(const Context& c, const LoadedScan& scan) {
  if (const auto given = given_spacing(c)) return *given;
  if (!scan.spacing.allFinite() || scan.spacing.minCoeff() < kSmallestSpacing)
    throw Error("no-spacing", "the file does not contain the size of its voxels", "set spacing, in mm")
        .parameter("spacing");
  require_representable(scan.spacing);
  return scan.spacing;
}

struct Rescale {
  double slope = 1, intercept = 0;
  bool none() const { return slope == 1 && intercept == 0; }
};

// Grids of whole numbers, which stand for particles or phases.
bool is_of_labels(const std::string& grid) { return grid == "id" || grid == "phase"; }

// Slope and intercept from the parameters if set, else from the file.
Rescale rescale_of(Context& c, const LoadedScan& scan) {
  const bool own_slope = c.keyword("slope").empty(), own_intercept = c.keyword("intercept").empty();
  if (!scan.slope && !own_slope && !own_intercept && !is_of_labels(c.text("grid")))
    c.warn("the file contains no rescale: stored numbers are used unchanged");
  return {own_slope ? c.number("slope") : scan.slope.value_or(1),
          own_intercept ? c.number("intercept") : scan.intercept.value_or(0)};
}

std::string place_of_voxel(const LoadedScan& scan, std::size_t i) {
  const auto nx = static_cast<std::size_t>(scan.size.x()), ny = static_cast<std::size_t>(scan.size.y());
  return fmt::format("({}, {}, {})", i % nx, i / nx % ny, i / nx / ny);
}

// The rescaled numbers as floats, in `values`.
void make_floats(LoadedScan& scan, const Rescale& rescale, const std::string& path, const Work& work) {
  const std::size_t count = scan.count();
  std::vector<float> out(scan.whole.empty() ? 0 : count);
  std::vector<float>& to = scan.whole.empty() ? scan.values : out;
  std::size_t bad = 0, first = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % (1u << 22) == 0) work.check();
    const double v = rescale.slope * scan.stored(i) + rescale.intercept;
    to[i] = static_cast<float>(v);
    if (!std::isfinite(to[i]) && bad++ == 0) first = i;
    if (!scan.whole.empty() && rescale.none() && double{to[i]} != v)
      throw Error("bad-values",
                  fmt::format("'{}': voxel {} has the value {}; a grid of floats holds whole numbers up to "
                              "2^24 = 16777216 without loss",
                              path, place_of_voxel(scan, i), scan.whole[i]),
                  "set grid: id for labels, or slope to make the numbers smaller")
          .parameter("path");
  }
  if (bad > 0)
    throw Error("bad-values",
                fmt::format("{} of {} voxels of '{}' are NaN or infinite, the first at {}", bad, count, path,
                            place_of_voxel(scan, first)),
                "replace those voxels")
        .parameter("path");
  if (scan.whole.empty()) return;
  scan.values = std::move(out);
  scan.whole = {};
}

// The rescaled numbers as indices of particles or phases, in `whole`.
void make_labels(LoadedScan& scan, const Rescale& rescale, const std::string& path, const Work& work) {
  if (scan.is_lossy)
    throw Error(
        "lossy-mask",
        fmt::format("'{}': the slices are compressed with losses (JPEG), which changes the numbers of "
                    "particles and phases",
                    path),
        "save them as PNG or TIFF in the program that made them")
        .parameter("path");
  // Numbers that were stored as floats may have been rounded when they were written.
  const double most = scan.whole.empty() ? 16777216.0 : 2147483647.0;
  const std::size_t count = scan.count();
  std::vector<std::int32_t> out(scan.whole.empty() ? count : 0);
  std::vector<std::int32_t>& to = scan.whole.empty() ? out : scan.whole;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % (1u << 22) == 0) work.check();
    const double v = rescale.slope * scan.stored(i) + rescale.intercept;
    if (v != std::nearbyint(v) || !(std::abs(v) <= most))
      throw Error(
          "bad-labels",
          fmt::format("'{}' contains {} at voxel {}; the grids id and phase hold whole numbers up to {}",
                      path, v, place_of_voxel(scan, i),
                      scan.whole.empty() ? "2^24 from files that store floats" : "2^31 − 1"),
          "set grid to another name, or slope and intercept so that values are whole")
          .parameter("grid");
    to[i] = static_cast<std::int32_t>(v);
  }
  if (scan.whole.empty()) scan.whole = std::move(out);
  scan.values = {};
}

// Numbers the values from 0 in ascending order, as masks of phases often hold 0 and 255.
void number_phases(Context& c, std::vector<std::int32_t>& values, const std::string& path) {
  constexpr std::size_t kMost = 255;
  std::vector<std::int32_t> known;  // ascending
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i % (1u << 22) == 0) c.work().check();
    const auto at = std::lower_bound(known.begin(), known.end(), values[i]);
    if (at != known.end() && *at == values[i]) continue;
    if (known.size() == kMost)
      throw Error("bad-labels", fmt::format("'{}' contains more than {} different numbers", path, kMost),
                  "segment it into phases first")
          .parameter("grid");
    known.insert(at, values[i]);
  }
  if (known.front() == 0 && known.back() + 1 == static_cast<std::int64_t>(known.size())) return;
  c.warn(fmt::format("the numbers {} become phases 0 to {}", fmt::join(known, ", "), known.size() - 1));
  for (std::int32_t& v : values)
    v = static_cast<std::int32_t>(std::lower_bound(known.begin(), known.end(), v) - known.begin());
}

template <class T>
void report_range(Context& c, const std::vector<T>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  c.metric("min", static_cast<double>(*low));
  c.metric("max", static_cast<double>(*high));
  c.metric("voxels", static_cast<double>(values.size()));
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
  LoadedScan scan = read(files, c.text("entry"), slice_choice(c), c.work().part(0, 0.7), reading_of(c));
  for (const auto& note : scan.notes) c.warn(note);
  const Vec3 spacing = spacing_of(c, scan);
  const Rescale rescale = rescale_of(c, scan);
  Volume volume;
  volume.extent = scan.size;
  if (is_of_labels(name)) {
    make_labels(scan, rescale, files[0].string(), c.work());
    if (name == "phase") number_phases(c, scan.whole, files[0].string());
    report_range(c, scan.whole);
    const auto value = [&](std::size_t i) { return scan.whole[i]; };
    if (name == "id")
      add_id_grid(volume, name, scan.size, spacing, c.work().part(0.7, 1), value);
    else
      add_phase_grid(volume, scan.size, spacing, c.work().part(0.7, 1), value);
  } else {
    make_floats(scan, rescale, files[0].string(), c.work());
    report_range(c, scan.values);
    add_number_grid(volume, name.empty() ? "density" : name, scan.size, spacing, c.work().part(0.7, 1),
                    [&](std::size_t i) { return scan.values[i]; });
  }
  c.output("volume", std::move(volume));
}

}  // namespace
}  // namespace terrazzo::load_volume

namespace terrazzo {

NodeType load_volume_node() {
  using namespace load_volume;
  return NodeType("LoadVolume", 5)
      .doc_(
          "Reads a volume: OpenVDB, VTK image data, DREAM3D, NIfTI, NRRD, MetaImage, MRC, a NumPy array, a "
          "DICOM series, or a stack of gray images, which may be in a zip archive.")
      .source_(
          "OpenVDB, libnifti, DCMTK, OpenImageIO, VTK XML 1.0, DREAM3D file version 7.0, NumPy .npy, "
          "NRRD 5, MetaIO, MRC 2014")
      .output(
          "volume", "Volume",
          "A scan becomes one float grid, in Hounsfield units or the units of its rescale, with x to the "
          "right, y to the front and z to the head. Grids of an OpenVDB file are returned unchanged, cell "
          "data of VTK and DREAM3D files as grids of the same names; FeatureIds of a DREAM3D file, less 1, "
          "as the grid id. Element [x, y, z] of an array is voxel (x, y, z). Pictures are stacked along z "
          "from the first file name on, and their bottom row is y = 0, so y is the other way round than the "
          "row number. The volume is all that the file contains, also where voxels are inactive.")
      .parameter(Parameter::input_path("path").doc_("Volume file, or a glob that names the slices of one "
                                                    "series or stack. The content determines the format. "
                                                    "Slices of a stack are in the natural order of their "
                                                    "names, slice_2 before slice_10; DICOM slices are in the "
                                                    "order of their positions."))
      .parameter(
          Parameter::text("grid", "")
              .doc_("OpenVDB, VTK and DREAM3D: name of the single grid to read; empty: all grids. Other "
                    "formats: name of the output grid; empty: density; id: whole numbers up to 2³¹ − 1, the "
                    "index of the particle at each voxel, negative in the binder; phase: whole "
                    "numbers, which are phases 0, 1, … in ascending order."))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "spacing", "auto")
                     .range(1e-9, 1e9)
                     .count(1, 3)
                     .unit_("mm")
                     .doc_("Edge lengths of a voxel, one number or three. auto: from the file; NumPy arrays "
                           "and image stacks, except those of ImageJ and OME, contain no spacing. Lengths in "
                           "VTK files are meters, in DREAM3D files micrometers."))
      .parameter(Parameter::optional_number("slope", "auto")
                     .range(-1e12, 1e12)
                     .doc_("Factor in value = slope · stored + intercept. auto: from the file, else 1."))
      .parameter(Parameter::optional_number("intercept", "auto")
                     .range(-1e12, 1e12)
                     .doc_("Offset in value = slope · stored + intercept. auto: from the file, else 0."))
      .parameter(Parameter::optional_integer("channel", "auto")
                     .range(1, 10000)
                     .doc_("Images: channel to read, from 1. auto: the only one."))
      .parameter(Parameter::optional_integer("page", "auto")
                     .range(1, 1e6)
                     .doc_("Images: frame of a time series to read, from 1. auto: the only one."))
      .parameter(
          Parameter::choice("order", "described", {"described", "stored"})
              .doc_("Images: which pages of a file are its slices. described: those that the metadata of "
                    "ImageJ, OME or tifffile say, else all. stored: all, in the order of the file."))
      .parameter(Parameter::text("entry", "")
                     .doc_("Zip archives: glob of the pictures to read, such as `gray/*.tif`, in the natural "
                           "order of their names. Empty: all, which must be one volume: one file with pages, "
                           "or slices in one folder whose names differ in a number."))
      .companion_files_(companions)
      .compute_(compute);
}

}  // namespace terrazzo
