#include "nodes/volumes/load_volume/slices.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "graph/diagnostic.h"
#include "nodes/common/io/pictures/stored_picture.h"
#include "nodes/data/indices.h"

namespace terrazzo::load_volume {
namespace {

// Which sample of a pixel is the voxel's number. Colors are accepted if they are gray.
int sample_of(const StoredSamples& s, const std::optional<int>& channel, const std::filesystem::path& path) {
  if (channel && *channel >= s.count)
    throw Error("bad-value",
                fmt::format("channel is {}, but '{}' has {} channels per pixel", *channel + 1, path.string(),
                            s.count),
                "channels are counted from 1")
        .parameter("channel");
  if (channel) return *channel;
  if (s.is_color) {
    for (std::size_t p = 0; p < s.values.size() / s.count; ++p)
      if (s.at(p, 0) != s.at(p, 1) || s.at(p, 0) != s.at(p, 2))
        throw Error("not-a-volume", "'" + path.string() + "' is a color image",
                    "a volume needs one number per voxel: convert the images to gray, or set channel");
  } else if (s.plain() > 1) {
    throw Error("several-channels", fmt::format("'{}' has {} channels per pixel", path.string(), s.plain()),
                fmt::format("set channel to the one to read, from 1 to {}", s.count))
        .parameter("channel");
  }
  return 0;
}

void note_once(LoadedScan& scan, const std::string& note) {
  if (std::find(scan.notes.begin(), scan.notes.end(), note) == scan.notes.end()) scan.notes.push_back(note);
}

void note_kind(const StoredSamples& s, LoadedScan& scan) {
  scan.is_lossy = scan.is_lossy || s.is_lossy;
  if (s.is_lossy)
    note_once(scan, "the slices are compressed with losses (JPEG), which changes their numbers");
  if (s.white_is_zero)
    note_once(scan,
              "the slices are stored as WhiteIsZero; the stored numbers are used, so larger ones are darker");
  bool same = true;
  for (std::size_t i = 0; i < s.palette.size(); ++i)
    for (const int level : s.palette[i]) same = same && level == static_cast<int>(i);
  if (!same) note_once(scan, "the slices have a palette; the numbers are its indices, not colors");
}

// The float that a stored number becomes. Whole numbers are not rounded silently.
float as_float(double stored, bool is_float) {
  const float kept = stored;
  if (!is_float && double{kept} != stored)
    throw Error(
        "bad-values",
        fmt::format("a voxel has the value {:.17g}; whole numbers above 2^31 − 1 are kept only if a float "
                    "holds them without loss",
                    stored),
        "write the stack with smaller numbers")
        .parameter("path");
  return kept;
}

// Whole numbers stay whole as long as all of them fit.
void append(LoadedScan& scan, double stored, bool is_float) {
  constexpr double kLeast = std::numeric_limits<std::int32_t>::min(),
                   kMost = std::numeric_limits<std::int32_t>::max();
  if (scan.values.empty() && !is_float && stored >= kLeast && stored <= kMost) {
    scan.whole.push_back(static_cast<std::int32_t>(stored));
    return;
  }
  for (const std::int32_t number : scan.whole) scan.values.push_back(as_float(number, false));
  scan.whole.clear();
  scan.values.push_back(as_float(stored, is_float));
}

// Appends the voxels of one page, bottom row first.
void append_page(const PictureContent& content, const ChosenPage& chosen, LoadedScan& scan,
                 const Reading& reading) {
  // The list of voxels may exist twice while it grows.
  const StoredSamples s =
      stored_samples(content, chosen.page, reading, 2.0 * sizeof(float) * (scan.size.z() + 1.0));
  if (scan.size.z() == 0) scan.size = Vec3i(s.width, s.height, 0);
  if (s.width != scan.size.x() || s.height != scan.size.y())
    throw Error("size-mismatch",
                fmt::format("'{}' is {} × {} pixels, the first image {} × {}", content.path.string(), s.width,
                            s.height, scan.size.x(), scan.size.y()),
                "all slices of a volume must have the same size");
  const double count = double(s.width) * s.height * (scan.size.z() + 1.0);
  if (count > 2147483648.0)
    throw Error("too-large", "'" + content.path.string() + "' has more than 2^31 voxels");
  const int sample = sample_of(s, chosen.channel, content.path);
  note_kind(s, scan);
  for (int y = s.height - 1; y >= 0; --y)
    for (int x = 0; x < s.width; ++x) append(scan, s.at(pixel_at(x, y, s.width), sample), s.is_float);
  ++scan.size.z();
}

}  // namespace

LoadedScan read_slices(std::size_t count, const std::function<PictureContent(std::size_t)>& picture,
                       const SliceOptions& choice, const Work& work, const Reading& reading) {
  LoadedScan scan;
  for (std::size_t i = 0; i < count; ++i) {
    const PictureContent content = picture(i);
    const auto slices = choose_slices(content.pages, choice.choice, choice.stored_order, content.path);
    if (count == 1 && content.pages.spacing) scan.spacing = *content.pages.spacing;
    for (const auto& slice : slices) {
      work.check();
      append_page(content, slice, scan, reading);
    }
    work.done(i + 1, count);
  }
  return scan;
}

LoadedScan read_slices(const std::vector<std::filesystem::path>& paths, const SliceOptions& choice,
                       const Work& work, const Reading& reading) {
  return read_slices(
      paths.size(), [&](std::size_t i) { return checked_picture(paths[i], reading); }, choice, work, reading);
}

}  // namespace terrazzo::load_volume
