#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcrledrg.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmjpeg/djdecode.h>
#include <dcmtk/dcmjpls/djdecode.h>
#include <dcmtk/oflog/oflog.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

#include "graph/diagnostic.h"
#include "nodes/load_volume/scan.h"

namespace terrazzo::load_volume {
namespace {

struct Slice {
  std::filesystem::path path;
  int width = 0, height = 0, frames = 1;
  Vec3 origin, across, down;  // patient coordinates: to the left, to the back, to the head; mm
  double dx = 0, dy = 0, dz = 0;
  bool has_rescale = false, has_place = false;
  double slope = 1, intercept = 0;
  std::string series;
  std::vector<float> values;
};

// DCMTK's decoders for compressed pixels, unregistered at program exit.
struct Decoders {
  Decoders() {
    OFLog::configure(OFLogger::OFF_LOG_LEVEL);
    DJDecoderRegistration::registerCodecs();
    DJLSDecoderRegistration::registerCodecs();
    DcmRLEDecoderRegistration::registerCodecs();
  }
  ~Decoders() {
    DcmRLEDecoderRegistration::cleanup();
    DJLSDecoderRegistration::cleanup();
    DJDecoderRegistration::cleanup();
  }
};

Error unreadable(const std::filesystem::path& path, const std::string& why) {
  return Error("unreadable-volume", "'" + path.string() + "' cannot be read as DICOM: " + why,
               "check that the file is complete");
}

std::string text_of(DcmItem& set, const DcmTagKey& tag) {
  OFString value;
  return set.findAndGetOFStringArray(tag, value, OFTrue).good() ? std::string(value.c_str()) : std::string();
}

// The first `count` numbers of an element at any nesting level. Returns false if there are fewer.
bool numbers_of(DcmItem& set, const DcmTagKey& tag, int count, double* out) {
  for (int k = 0; k < count; ++k) {
    Float64 v = 0;
    if (set.findAndGetFloat64(tag, v, static_cast<unsigned long>(k), OFTrue).bad() || !std::isfinite(v))
      return false;
    out[k] = v;
  }
  return true;
}

int whole_of(DcmItem& set, const DcmTagKey& tag, int otherwise) {
  Uint16 v = 0;
  return set.findAndGetUint16(tag, v).good() ? int(v) : otherwise;
}

// The stored number is in the lower `count` bits; the highest of them is the sign if has_sign.
float stored_number(std::uint32_t bits, int count, bool has_sign) {
  const std::uint32_t mask = count >= 32 ? ~0u : (1u << count) - 1;
  bits &= mask;
  const bool negative = has_sign && (bits >> (count - 1) & 1);
  return static_cast<float>(static_cast<std::int64_t>(bits) - (negative ? std::int64_t{1} << count : 0));
}

void read_pixels(DcmDataset& set, Slice& s) {
  const int allocated = whole_of(set, DCM_BitsAllocated, 16),
            stored = whole_of(set, DCM_BitsStored, allocated);
  const bool has_sign = whole_of(set, DCM_PixelRepresentation, 0) == 1;
  if ((allocated != 8 && allocated != 16) || stored < 1 || stored > allocated)
    throw Error("not-a-volume", fmt::format("'{}' contains pixels of {} bits, {} of them used",
                                            s.path.string(), allocated, stored));
  if (set.chooseRepresentation(EXS_LittleEndianExplicit, nullptr).bad())
    throw unreadable(s.path, "its pixel compression is not supported");
  unsigned long count = 0;
  const Uint8* bytes = nullptr;
  const Uint16* words = nullptr;
  if (allocated == 8)
    set.findAndGetUint8Array(DCM_PixelData, bytes, &count);
  else
    set.findAndGetUint16Array(DCM_PixelData, words, &count);
  if ((!bytes && !words) || count < s.values.size())
    throw unreadable(s.path, fmt::format("it contains {} of {} pixels", count, s.values.size()));
  for (std::size_t i = 0; i < s.values.size(); ++i)
    s.values[i] = stored_number(bytes ? bytes[i] : words[i], stored, has_sign);
}

// DCMTK reads sequences recursively, so a file of deeply nested sequences would exhaust the stack.
void check_nesting(std::string_view content, const std::filesystem::path& path) {
  constexpr std::size_t deepest = 64;
  std::vector<std::size_t> ends;
  for (std::size_t at = 0; at + 8 <= content.size(); ++at) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(content[at + k]); };
    const bool little = byte(0) == 0xfe && byte(1) == 0xff && byte(3) == 0xe0;
    const bool big = byte(0) == 0xff && byte(1) == 0xfe && byte(2) == 0xe0;
    if (!little && !big) continue;
    const unsigned kind = little ? byte(2) : byte(3);
    while (!ends.empty() && ends.back() <= at) ends.pop_back();
    if (kind == 0x0d && !ends.empty()) ends.pop_back();  // the end of an item
    if (kind != 0) continue;
    std::uint32_t length = 0;
    for (std::size_t k = 0; k < 4; ++k) length = length << 8 | byte(little ? 7 - k : 4 + k);
    ends.push_back(length == 0xffffffff ? content.size() : at + 8 + length);
    if (ends.size() > deepest) throw unreadable(path, "its sequences are nested too deeply");
  }
}

// Checks the memory that DCMTK needs for the file itself. A deflated file is decompressed as it is read.
void check_file(const std::filesystem::path& path, const Reading& reading) {
  constexpr double deflate = 1032;
  const std::string content = read_whole(path, reading);
  const bool deflated = content.substr(0, 1024).find("1.2.840.10008.1.2.1.99") != std::string::npos;
  require_memory((deflated ? deflate : 3) * static_cast<double>(content.size()), reading.memory,
                 "'" + path.string() + "'");
  check_nesting(content, path);
}

Slice read_slice(const std::filesystem::path& path, const Reading& reading) {
  check_file(path, reading);
  DcmFileFormat file;
  if (const OFCondition state = file.loadFile(path.c_str()); state.bad())
    throw unreadable(path, printable(state.text()));
  DcmDataset& set = *file.getDataset();
  Slice s;
  s.path = path;
  s.width = whole_of(set, DCM_Columns, 0), s.height = whole_of(set, DCM_Rows, 0);
  if (s.width < 1 || s.height < 1) throw unreadable(path, "it contains no image");
  if (whole_of(set, DCM_SamplesPerPixel, 1) != 1)
    throw Error("not-a-volume", "'" + path.string() + "' is a color image, not a scan");
  if (Sint32 frames = 0; set.findAndGetSint32(DCM_NumberOfFrames, frames).good() && frames > 1)
    s.frames = frames;
  double place[3], cosines[6] = {1, 0, 0, 0, 1, 0}, spacing[2];
  s.has_place = numbers_of(set, DCM_ImagePositionPatient, 3, place);
  numbers_of(set, DCM_ImageOrientationPatient, 6, cosines);
  for (int k = 0; k < 3; ++k)
    s.origin[k] = s.has_place ? place[k] : 0, s.across[k] = cosines[k], s.down[k] = cosines[k + 3];
  if (s.across.cross(s.down).norm() < 0.5)
    throw unreadable(path, "its row and column directions are invalid");
  // The spacing of the rows comes first.
  if (numbers_of(set, DCM_PixelSpacing, 2, spacing)) s.dy = spacing[0], s.dx = spacing[1];
  if (!numbers_of(set, DCM_SpacingBetweenSlices, 1, &s.dz)) numbers_of(set, DCM_SliceThickness, 1, &s.dz);
  s.dz = std::abs(s.dz);
  s.has_rescale = numbers_of(set, DCM_RescaleSlope, 1, &s.slope);
  numbers_of(set, DCM_RescaleIntercept, 1, &s.intercept);
  s.series = text_of(set, DCM_SeriesInstanceUID);
  const double count = double(s.width) * s.height * s.frames;
  if (count > 2147483648.0) throw Error("too-large", "'" + path.string() + "' has more than 2^31 voxels");
  check_plausible(2 * count, path);
  require_memory((sizeof(Uint16) + 2 * sizeof(float)) * count, reading.memory, "'" + path.string() + "'");
  if (!set.tagExists(DCM_PixelData)) throw unreadable(path, "it contains no pixels");
  s.values.resize(static_cast<std::size_t>(count));
  read_pixels(set, s);
  return s;
}

// Sorts the slices by their position along the normal and returns their spacing in mm.
double order(std::vector<Slice>& slices, const Vec3& normal, LoadedScan& scan) {
  std::stable_sort(slices.begin(), slices.end(), [&](const Slice& a, const Slice& b) {
    return a.origin.dot(normal) < b.origin.dot(normal);
  });
  std::vector<double> at;
  for (const Slice& s : slices) at.push_back(s.origin.dot(normal));
  const double step = (at.back() - at.front()) / static_cast<double>(at.size() - 1);
  if (!(step > 1e-6))
    throw Error("missing-slices", fmt::format("all {} slices have the same position", slices.size()),
                "use the slices of one volume");
  double worst = 0;
  for (std::size_t i = 1; i < at.size(); ++i) {
    const double gap = at[i] - at[i - 1];
    if (gap > 1.5 * step || gap < 0.5 * step)
      throw Error(
          "missing-slices",
          fmt::format("'{}' and '{}' are {:.4g} mm apart; the average spacing is {:.4g} mm",
                      slices[i - 1].path.filename().string(), slices[i].path.filename().string(), gap, step),
          "include every slice of the series exactly once");
    worst = std::max(worst, std::abs(gap - step));
  }
  if (worst > 0.02 * step)
    scan.notes.push_back(fmt::format(
        "the slice spacing deviates by up to {:.2g} mm from its average of {:.4g} mm", worst, step));
  return step;
}

}  // namespace

bool is_dicom(const std::filesystem::path& path) {
  char head[132] = {};
  std::ifstream(path, std::ios::binary).read(head, sizeof head);
  return std::memcmp(head + 128, "DICM", 4) == 0;
}

LoadedScan read_dicom(const std::vector<std::filesystem::path>& paths, const Work& work,
                      const Reading& given) {
  Reading reading = given;
  static const Decoders decoders;
  std::vector<Slice> slices;
  for (const auto& path : paths) {
    work.check();
    try {
      slices.push_back(read_slice(path, reading));
      // A slice stays in memory; its values are also in the volume and in the reoriented copy.
      reading.memory -=
          std::min<std::uint64_t>(reading.memory, 3 * sizeof(float) * slices.back().values.size());
    } catch (const Error&) {
      throw;
    } catch (const std::exception& e) {
      throw unreadable(path, printable(e.what()));
    }
    const Slice &first = slices.front(), &s = slices.back();
    if (s.series != first.series)
      throw Error("mixed-series",
                  "'" + paths[0].string() + "' and '" + path.string() + "' belong to different series",
                  "use the files of one series");
    if (s.width != first.width || s.height != first.height || (s.frames > 1 && paths.size() > 1) ||
        (s.across - first.across).norm() > 1e-3 || (s.down - first.down).norm() > 1e-3 ||
        std::abs(s.dx - first.dx) > 1e-4 || std::abs(s.dy - first.dy) > 1e-4)
      throw Error(
          "mixed-series",
          "'" + path.string() + "' differs in size, scale or direction from '" + paths[0].string() + "'",
          "use the files of one series");
    work.progress(static_cast<double>(slices.size()) / static_cast<double>(paths.size()));
  }
  LoadedScan scan;
  const Slice first = slices.front();
  const Vec3 normal = first.across.cross(first.down).normalized();
  scan.size = Vec3i(first.width, first.height, static_cast<int>(slices.size()) * first.frames);
  scan.spacing = Vec3(first.dx, first.dy, first.dz);
  if (slices.size() > 1) {
    for (const Slice& s : slices)
      if (!s.has_place)
        throw Error("missing-slices", "'" + s.path.string() + "' contains no slice position",
                    "convert the series with software that supports the scanner");
    const double step = order(slices, normal, scan);
    scan.spacing.z() = step;
  }
  allocate(scan, paths[0].string(), given);
  // Each slice may have its own rescale (as in PET), so the values are rescaled here.
  bool rescaled = true;
  std::size_t at = 0;
  for (const Slice& s : slices) {
    rescaled = rescaled && s.has_rescale;
    for (const float v : s.values) scan.values[at++] = static_cast<float>(s.slope * v + s.intercept);
  }
  if (rescaled) scan.slope = 1, scan.intercept = 0;
  Mat3 axes;  // the patient's left and back are −x and −y here
  const Vec3 to_ours(-1, -1, 1);
  axes << to_ours.cwiseProduct(first.across), to_ours.cwiseProduct(first.down), to_ours.cwiseProduct(normal);
  align_axes(scan, axes);
  return scan;
}

}  // namespace terrazzo::load_volume
