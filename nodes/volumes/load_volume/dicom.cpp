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

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "nodes/data/indices.h"
#include "nodes/volumes/load_volume/scan.h"

namespace terrazzo::load_volume {
namespace {

struct DicomFile {
  std::filesystem::path path;
  int width = 0, height = 0, frames = 1;
  double thickness = 0;  // of a single slice, mm; 0 if unknown
  std::string series;
  std::vector<float> values;  // of all frames
};

struct Slice {
  std::size_t file = 0, frame = 0;
  std::string name;           // for messages
  Vec3 origin, across, down;  // patient coordinates: to the left, to the back, to the head; mm
  double dx = 0, dy = 0;
  bool has_rescale = false, has_place = false, has_direction = false;
  double slope = 1, intercept = 0;
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

// The first `count` numbers of an element, also within sequences if `nested`. Returns false if there are
// fewer.
bool numbers_of(DcmItem& set, const DcmTagKey& tag, bool nested, int count, double* out) {
  for (int k = 0; k < count; ++k) {
    Float64 v = 0;
    if (set.findAndGetFloat64(tag, v, static_cast<unsigned long>(k), nested ? OFTrue : OFFalse).bad() ||
        !std::isfinite(v))
      return false;
    out[k] = v;
  }
  return true;
}

// Where the attributes of one frame are, in the order of precedence: its own functional groups, those that
// all frames share, the data set. Files without functional groups have only the last.
struct FramePlaces {
  DcmItem *own = nullptr, *shared = nullptr, *set = nullptr;

  bool numbers(const DcmTagKey& tag, int count, double* out) const {
    for (DcmItem* item : {own, shared})
      if (item && numbers_of(*item, tag, true, count, out)) return true;
    // Nuclear medicine has positions within sequences.
    return numbers_of(*set, tag, false, count, out) || (!own && numbers_of(*set, tag, true, count, out));
  }
};

int whole_of(DcmItem& set, const DcmTagKey& tag, int otherwise) {
  Uint16 v = 0;
  return set.findAndGetUint16(tag, v).good() ? int(v) : otherwise;
}

// The stored number is in the lower `count` bits; the highest of them is the sign if has_sign.
float stored_number(std::uint32_t bits, int count, bool has_sign) {
  const std::uint32_t mask = count >= 32 ? ~0u : (1u << count) - 1;
  bits &= mask;
  const bool negative = has_sign && (bits >> (count - 1) & 1);
  return static_cast<std::int64_t>(bits) - (negative ? std::int64_t{1} << count : 0);
}

void read_pixels(DcmDataset& set, DicomFile& s) {
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
  constexpr std::size_t kDeepest = 64;
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
    if (ends.size() > kDeepest) throw unreadable(path, "its sequences are nested too deeply");
  }
}

// Checks the memory that DCMTK needs for the file itself. A deflated file is decompressed as it is read.
void check_file(const std::filesystem::path& path, const Reading& reading) {
  constexpr double kDeflate = 1032;
  const std::string content = read_whole(path, reading);
  const bool deflated = content.substr(0, 1024).find("1.2.840.10008.1.2.1.99") != std::string::npos;
  require_memory((deflated ? kDeflate : 3) * content.size(), reading.memory, "'" + path.string() + "'");
  check_nesting(content, path);
}

// Offsets of the frames along the normal in mm, of files without functional groups: radiation doses list
// them, and the sign of the spacing in nuclear medicine tells whether the stack follows the normal. Empty if
// the file says neither.
std::vector<double> frame_offsets(DcmDataset& set, std::size_t frames) {
  std::vector<double> at(frames);
  if (numbers_of(set, DCM_GridFrameOffsetVector, false, frames, at.data())) return at;
  double step = 0;
  if (!numbers_of(set, DCM_SpacingBetweenSlices, false, 1, &step) || step == 0) return {};
  for (std::size_t k = 0; k < frames; ++k) at[k] = step * k;
  return at;
}

Slice slice_of(const FramePlaces& places, const std::string& name) {
  Slice s;
  s.name = name;
  double place[3] = {}, cosines[6] = {1, 0, 0, 0, 1, 0}, spacing[2];
  s.has_place = places.numbers(DCM_ImagePositionPatient, 3, place);
  s.has_direction = places.numbers(DCM_ImageOrientationPatient, 6, cosines);
  s.origin = Vec3(place[0], place[1], place[2]);
  s.across = Vec3(cosines[0], cosines[1], cosines[2]);
  s.down = Vec3(cosines[3], cosines[4], cosines[5]);
  if (s.across.cross(s.down).norm() < 0.5)
    throw Error("unreadable-volume", "the row and column directions of " + name + " are invalid",
                "check that the file is complete");
  if (places.numbers(DCM_PixelSpacing, 2, spacing)) {
    s.dy = spacing[0];  // the spacing of the rows comes first
    s.dx = spacing[1];
  }
  s.has_rescale = places.numbers(DCM_RescaleSlope, 1, &s.slope);
  places.numbers(DCM_RescaleIntercept, 1, &s.intercept);
  return s;
}

// Adds the slices of one file, of which there may be many.
void add_slices(DcmDataset& set, const DicomFile& file, std::size_t number, std::vector<Slice>& out) {
  DcmSequenceOfItems *own = nullptr, *shared = nullptr;
  set.findAndGetSequence(DCM_PerFrameFunctionalGroupsSequence, own);
  set.findAndGetSequence(DCM_SharedFunctionalGroupsSequence, shared);
  const std::size_t frames = file.frames;
  if (own && own->card() < frames)
    throw unreadable(file.path, fmt::format("it describes {} of its {} frames", own->card(), file.frames));
  const std::vector<double> offsets = own || frames < 2 ? std::vector<double>() : frame_offsets(set, frames);
  for (std::size_t k = 0; k < frames; ++k) {
    const FramePlaces places{own ? own->getItem(static_cast<unsigned long>(k)) : nullptr,
                             shared && shared->card() > 0 ? shared->getItem(0) : nullptr, &set};
    const std::string name = file.path.filename().string();
    Slice s = slice_of(places, frames < 2 ? "'" + name + "'" : fmt::format("frame {} of '{}'", k + 1, name));
    s.file = number;
    s.frame = k;
    if (!own && frames > 1) {
      s.has_place = !offsets.empty();
      if (s.has_place) s.origin += (offsets[k] - offsets[0]) * s.across.cross(s.down).normalized();
    }
    out.push_back(std::move(s));
  }
}

DicomFile read_file(const std::filesystem::path& path, std::size_t number, const Reading& reading,
                    std::vector<Slice>& slices) {
  check_file(path, reading);
  DcmFileFormat file;
  if (const OFCondition state = file.loadFile(path.c_str()); state.bad())
    throw unreadable(path, printable(state.text()));
  DcmDataset& set = *file.getDataset();
  DicomFile s;
  s.path = path;
  s.width = whole_of(set, DCM_Columns, 0);
  s.height = whole_of(set, DCM_Rows, 0);
  if (s.width < 1 || s.height < 1) throw unreadable(path, "it contains no image");
  if (whole_of(set, DCM_SamplesPerPixel, 1) != 1)
    throw Error("not-a-volume", "'" + path.string() + "' is a color image, not a scan");
  if (Sint32 frames = 0; set.findAndGetSint32(DCM_NumberOfFrames, frames).good() && frames > 1)
    s.frames = frames;
  s.series = text_of(set, DCM_SeriesInstanceUID);
  const double count = double(s.width) * s.height * s.frames;
  if (count > 2147483648.0) throw Error("too-large", "'" + path.string() + "' has more than 2^31 voxels");
  check_plausible(2 * count, path);
  require_memory((sizeof(Uint16) + 2 * sizeof(float)) * count + double(sizeof(Slice)) * s.frames,
                 reading.memory, "'" + path.string() + "'");
  if (!set.tagExists(DCM_PixelData)) throw unreadable(path, "it contains no pixels");
  if (!numbers_of(set, DCM_SpacingBetweenSlices, true, 1, &s.thickness))
    numbers_of(set, DCM_SliceThickness, true, 1, &s.thickness);
  s.thickness = std::abs(s.thickness);
  add_slices(set, s, number, slices);
  s.values.resize(count);
  read_pixels(set, s);
  return s;
}

void require_one_series(const DicomFile& first, const DicomFile& file) {
  if (file.series != first.series)
    throw Error("mixed-series",
                "'" + first.path.string() + "' and '" + file.path.string() + "' belong to different series",
                "use the files of one series");
  if (file.width != first.width || file.height != first.height)
    throw Error("mixed-series",
                fmt::format("'{}' has {} × {} pixels, '{}' {} × {}", file.path.string(), file.width,
                            file.height, first.path.string(), first.width, first.height),
                "use the files of one series");
}

// All slices must be parallel, have equal pixels, and say where they are.
void require_one_stack(const std::vector<Slice>& slices) {
  const Slice& first = slices.front();
  for (const Slice& s : slices) {
    if (!s.has_place || !s.has_direction)
      throw Error("missing-slices",
                  fmt::format("{} has no slice {}, so the order of the {} slices is unknown", s.name,
                              s.has_place ? "orientation" : "position", slices.size()),
                  "convert the series with software that supports the scanner");
    if ((s.across - first.across).norm() > 1e-3 || (s.down - first.down).norm() > 1e-3 ||
        std::abs(s.dx - first.dx) > 1e-4 || std::abs(s.dy - first.dy) > 1e-4)
      throw Error("mixed-series", s.name + " differs in scale or direction from " + first.name,
                  "use the slices of one stack");
  }
}

// Slices that are shifted within their planes make a sheared volume, for example with a tilted gantry.
void require_straight(const std::vector<Slice>& slices, const Vec3& normal) {
  double most = 0;
  for (const Slice& s : slices) {
    const Vec3 d = s.origin - slices.front().origin;
    most = std::max(most, (d - d.dot(normal) * normal).norm());
  }
  const double pixel = std::max(slices.front().dx, slices.front().dy);
  if (pixel > 0 && most > pixel)
    throw Error("tilted-volume",
                fmt::format("the slices are shifted within their planes by up to {:.4g} mm, {:.1f} pixels",
                            most, most / pixel),
                "resample the series to a straight box (gantry tilt correction)");
}

// Sorts the slices by their position along the normal and returns their spacing in mm.
double order(std::vector<Slice>& slices, const Vec3& normal, LoadedScan& scan) {
  constexpr double kEqual = 0.1;  // of the spacing: positions in files are rounded
  std::stable_sort(slices.begin(), slices.end(), [&](const Slice& a, const Slice& b) {
    return a.origin.dot(normal) < b.origin.dot(normal);
  });
  std::vector<double> gaps;
  for (std::size_t i = 1; i < slices.size(); ++i) {
    gaps.push_back((slices[i].origin - slices[i - 1].origin).dot(normal));
    if (!(gaps.back() > 1e-6))
      throw Error("missing-slices",
                  fmt::format("{} and {} have the same position", slices[i - 1].name, slices[i].name),
                  "use the slices of one volume, of a single time, echo or weighting");
  }
  std::vector<double> sorted = gaps;
  std::nth_element(sorted.begin(), sorted.begin() + (sorted.size() / 2), sorted.end());
  const double step = sorted[sorted.size() / 2];
  double worst = 0, total = 0;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (std::abs(gaps[i] - step) > kEqual * step)
      throw Error("missing-slices",
                  fmt::format("{} and {} are {:.4g} mm apart; most slices are {:.4g} mm apart",
                              slices[i].name, slices[i + 1].name, gaps[i], step),
                  "include every slice of the series exactly once, or resample it to equal spacing");
    worst = std::max(worst, std::abs(gaps[i] - step));
    total += gaps[i];
  }
  const double mean = total / gaps.size();
  if (worst > 0.02 * step)
    scan.notes.push_back(fmt::format(
        "the slice spacing deviates by up to {:.2g} mm from its average of {:.4g} mm", worst, mean));
  return mean;
}

std::uint32_t little(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t v = 0;
  for (std::size_t k = count; k-- > 0;) v = v << 8 | static_cast<unsigned char>(bytes[at + k]);
  return v;
}

// The offset after the element at `at`, little-endian with or without its kind of value; 0 if it is none that
// a file can begin with: one of group 0002 or 0008 that ends within the file.
std::size_t after_element(std::string_view head, std::size_t at, std::uintmax_t file_size) {
  static constexpr std::string_view kKinds = "AEASATCSDADSDTISLOLTPNSHSSSTTMUIULUS";  // of 16-bit lengths
  if (at + 8 > head.size() || (little(head, at, 2) != 2 && little(head, at, 2) != 8)) return 0;
  const std::size_t kind = kKinds.find(head.substr(at + 4, 2));
  const bool is_explicit = kind != std::string_view::npos && kind % 2 == 0;
  const std::size_t end = at + 8 + (is_explicit ? little(head, at + 6, 2) : little(head, at + 4, 4));
  return end <= file_size ? end : 0;
}

// Whether the file begins with two elements in ascending order, as data sets without a preamble do.
bool begins_with_elements(std::string_view head, std::uintmax_t file_size) {
  const std::size_t second = after_element(head, 0, file_size);
  if (second == 0 || after_element(head, second, file_size) == 0) return false;
  const auto tag = [&](std::size_t at) { return little(head, at, 2) << 16 | little(head, at + 2, 2); };
  return tag(0) < tag(second);
}

}  // namespace

bool is_dicom(const std::filesystem::path& path) {
  const std::string head = read_beginning(path, 1024);
  if (head.size() >= 132 && head.compare(128, 4, "DICM") == 0) return true;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  return !error && begins_with_elements(head, size);
}

LoadedScan read_dicom(const std::vector<std::filesystem::path>& paths, const Work& work,
                      const Reading& given) {
  Reading reading = given;
  static const Decoders decoders;
  std::vector<DicomFile> files;
  std::vector<Slice> slices;
  for (const auto& path : paths) {
    work.check();
    try {
      files.push_back(read_file(path, files.size(), reading, slices));
    } catch (const Error&) {
      throw;
    } catch (const std::exception& e) {
      throw unreadable(path, printable(e.what()));
    }
    // A file's values stay in memory; they are also in the volume and in the reoriented copy.
    reading.memory -= std::min<std::uint64_t>(reading.memory, 3 * sizeof(float) * files.back().values.size());
    require_one_series(files.front(), files.back());
    work.done(files.size(), paths.size());
  }
  LoadedScan scan;
  const Slice first = slices.front();
  const Vec3 normal = first.across.cross(first.down).normalized();
  scan.size = Vec3i(files[0].width, files[0].height, count_of(slices));
  scan.spacing = Vec3(first.dx, first.dy, files[0].thickness);
  if (slices.size() > 1) {
    require_one_stack(slices);
    require_straight(slices, normal);
    scan.spacing.z() = order(slices, normal, scan);
  }
  allocate(scan, paths[0].string(), given);
  // Each slice may have its own rescale (as in PET), so the values are rescaled here.
  const std::size_t plane = pixels_in(files[0].width, files[0].height);
  bool rescaled = true;
  std::size_t at = 0;
  for (const Slice& s : slices) {
    rescaled = rescaled && s.has_rescale;
    const float* values = files[s.file].values.data() + s.frame * plane;
    for (std::size_t i = 0; i < plane; ++i) scan.values[at++] = s.slope * values[i] + s.intercept;
  }
  if (rescaled) {
    scan.slope = 1;
    scan.intercept = 0;
  }
  Mat3 axes;  // the patient's left and back are −x and −y here
  const Vec3 to_ours(-1, -1, 1);
  axes << to_ours.cwiseProduct(first.across), to_ours.cwiseProduct(first.down), to_ours.cwiseProduct(normal);
  align_axes(scan, axes);
  return scan;
}

}  // namespace terrazzo::load_volume
