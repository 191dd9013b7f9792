#include "nodes/photograph/segment/segment.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/data/equal_size.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/segment/color/color_classes.h"
#include "nodes/photograph/segment/color/delight.h"
#include "nodes/photograph/segment/find.h"
#include "nodes/photograph/segment/measure/measure.h"
#include "nodes/photograph/segment/outline/coverage.h"
#include "nodes/photograph/segment/tiles.h"
#include "runtime/memory.h"

namespace terrazzo::segment {
namespace {

// Measured at 1024² and 2400² pixels, auto: 365 bytes per pixel, and 0.6 GB of buffers that do not grow. In
// tiles, only labels, coverage, confidence and the picture without light are as large as the photograph
// (estimated).
constexpr double kBytesWhole = 370, kBytesTiled = 40, kBytesOfTile = 3.1e9;

void check_image(const Image& image) {
  if (image.width <= 0 || image.height <= 0 || image.sections <= 0 ||
      image.pixels.size() != pixels_in(image.width, image.height) * image.sections)
    throw Error("empty-image", "the image has no pixels");
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    if (!image.pixels[i].allFinite())
      throw Error("bad-pixels",
                  "the image contains NaN or infinity at column " + std::to_string(i % image.width) +
                      ", row " + std::to_string(i / image.width % image.height) + " of section " +
                      std::to_string(i / image.width / image.height),
                  "replace those pixels before segmenting the image");
}

void classify(Segmentation& s, int k, std::uint64_t seed, const Work& work) {
  const std::vector<int> classes = color_classes(s.profiles, k, seed, work);
  s.profiles.classes = 1;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    s.profiles.profiles[i].cls = s.labels.classes[i] = classes[i];
    s.profiles.classes = std::max(s.profiles.classes, classes[i] + 1);
  }
}

// Removes labels from ignored pixels, and what is left of a particle there if it is smaller than min_area.
void cut_by_ignored(Segmentation& s) {
  if (s.ignored.empty()) return;
  std::vector<std::int64_t> seen(s.labels.classes.size() + 1, 0), hidden(seen.size(), 0);
  for (std::size_t i = 0; i < s.labels.ids.size(); ++i) ++(s.ignored[i] ? hidden : seen)[s.labels.ids[i]];
  const auto is_speck = [&](std::int32_t id) {
    return id > 0 && hidden[id] > 0 && static_cast<double>(seen[id]) < s.min_area;
  };
  for (std::size_t i = 0; i < s.labels.ids.size(); ++i)
    if (s.ignored[i] || is_speck(s.labels.ids[i])) s.labels.ids[i] = 0;
  for (std::size_t k = 1; k < seen.size(); ++k)
    if (seen[k] > 0 && is_speck(static_cast<std::int32_t>(k))) {
      ++s.specks;
      s.speck_pixels += seen[k];
    }
}

// Removes labels without pixels or with too little confidence, and renumbers the rest. What such a particle
// covered is undecided.
void drop_labels(Segmentation& s, std::vector<double>& confidence, double least) {
  cut_by_ignored(s);
  const IgnoredPixels& ignored = s.ignored;
  std::vector<std::uint8_t> used(s.labels.classes.size() + 1, 0);
  for (const auto id : s.labels.ids) used[id] = 1;
  std::vector<std::int32_t> number(used.size(), 0);
  std::int32_t count = 0;
  for (std::size_t k = 1; k < used.size(); ++k) {
    if (!used[k]) continue;
    if (confidence[k - 1] < least) {
      ++s.unlikely;
      continue;
    }
    confidence[count] = confidence[k - 1];
    s.labels.classes[count] = s.labels.classes[k - 1];
    number[k] = ++count;
  }
  confidence.resize(count);
  s.labels.classes.resize(count);
  if (s.unlikely > 0) s.undecided.resize(s.labels.ids.size(), 0);
  for (std::size_t i = 0; i < s.labels.ids.size(); ++i) {
    auto& id = s.labels.ids[i];
    if (id > 0 && number[id] == 0) s.undecided[i] = 1;
    id = number[id];
    if (!s.undecided.empty() && (id > 0 || (!ignored.empty() && ignored[i]))) s.undecided[i] = 0;
  }
}

// What the photograph shows, as the options say or the picture does, and from where.
void decide_view(const Image& photo, const SegmentOptions& options, Segmentation& s, const Work& work) {
  s.evidence = view_evidence(photo, s.labels, work);
  const double covered = options.binder.kind == Hint::Kind::None ? 1 : s.profiles.area_fraction;
  const View judged = judged_view(s.evidence, covered);
  set_view(s.profiles, options.view.value_or(judged), s.evidence);
  if (s.profiles.view == View::Surface) s.tilt = estimated_tilt(s.profiles);
}

void measure_scales(const Image& photo, Segmentation& s) {
  for (FoundObject& o : s.not_material)
    o.scale =
        find_scale(photo, o.section, {o.left, o.top, o.right, o.bottom}, s.ignored,
                   o.kind == FoundObject::Kind::Caption ? ScaleMark::Kind::Bar : ScaleMark::Kind::Ticks);
}

}  // namespace

Segmentation segment(const Image& photo, const SegmentOptions& given, const Work& work) {
  check_image(photo);
  const bool tiled = needs_tiles(photo);
  const double pixels = photo.pixels.size();
  require_memory(tiled ? kBytesTiled * pixels + kBytesOfTile : kBytesWhole * pixels, given.memory,
                 "the segmentation of " + std::to_string(photo.width) + " × " + std::to_string(photo.height) +
                     " pixels");
  SegmentOptions options = given;
  std::vector<FoundObject> objects;
  if (options.find_objects) objects = find_objects(photo, options.ignored, work.quiet());
  Finding found =
      tiled ? find_in_tiles(photo, options, work.part(0, 0.9)) : find_in_whole(photo, options, nullptr, work);
  Segmentation s = std::move(found.result);
  s.ignored = std::move(found.ignored);
  s.undecided = std::move(found.undecided);
  s.not_material.insert(s.not_material.begin(), objects.begin(), objects.end());
  measure_scales(photo, s);
  drop_labels(s, found.confidence, options.min_confidence);
  if (s.labels.classes.empty())
    throw Error(
        "no-particles",
        "no particles are left: " + std::to_string(s.specks) + " parts are smaller than min_area (" +
            fmt::format("{:g}", s.min_area) + " pixels), and " + std::to_string(s.unlikely) +
            " are below min_confidence",
        "lower min_area or min_confidence, set binder to the binder's color, or choose another method");
  if (options.delight) s.delit = delight(photo, s.labels, s.ignored, work.quiet());
  s.profiles = measure_profiles(s.delit.pixels.empty() ? photo : s.delit, s.labels, found.coverage, s.ignored,
                                s.undecided, work.part(tiled ? 0.9 : 0.8, 1));
  for (std::size_t k = 0; k < s.profiles.profiles.size(); ++k)
    s.profiles.profiles[k].confidence = found.confidence[k];
  decide_view(photo, options, s, work.quiet());
  if (options.color_classes != 1) classify(s, options.color_classes, options.seed, work);
  return s;
}

Segmentation measure_labels(const Image& image, const Labels& labels, const SegmentOptions& options,
                            const Work& work) {
  check_image(image);
  require_equal_size(labels, "the labels have", image, "the image has", "connect labels of the same image");
  Segmentation s;
  s.labels = labels;
  s.labels.pixel_size = image.pixel_size;
  // Ids must be 1…n in section order; others are renumbered.
  std::vector<std::int32_t> number(labels.classes.size() + 1, 0);
  std::vector<std::int32_t> classes;
  for (auto& id : s.labels.ids) {
    if (id < 0 || id > labels.count())
      throw Error("bad-labels", "a pixel has the label " + std::to_string(id) + ", but only " +
                                    std::to_string(labels.count()) + " labels have a class");
    if (id == 0) continue;
    if (number[id] == 0) {
      classes.push_back(labels.classes[id - 1]);
      number[id] = static_cast<std::int32_t>(classes.size());
    }
    id = number[id];
  }
  s.labels.classes = std::move(classes);
  std::vector<double> confidence(s.labels.classes.size(), 1.0);
  s.ignored = options.ignored;
  if (options.find_objects) s.not_material = find_objects(image, s.ignored, work.quiet());
  measure_scales(image, s);
  drop_labels(s, confidence, 0);
  if (s.labels.classes.empty()) throw Error("no-particles", "the labels contain no particles");
  std::vector<float> coverage;
  const std::size_t size = pixels_in(image.width, image.height);
  for (int i = 0; i < labels.sections; ++i) {
    const auto first = s.labels.ids.begin() + (size * i);
    const auto share =
        smooth_coverage({first, first + static_cast<std::ptrdiff_t>(size)}, image.width, image.height, work);
    coverage.insert(coverage.end(), share.begin(), share.end());
  }
  if (options.delight) s.delit = delight(image, s.labels, s.ignored, work);
  s.profiles =
      measure_profiles(options.delight ? s.delit : image, s.labels, coverage, s.ignored, s.undecided, work);
  decide_view(image, options, s, work.quiet());
  if (options.color_classes != 1) classify(s, options.color_classes, options.seed, work);
  return s;
}

}  // namespace terrazzo::segment
