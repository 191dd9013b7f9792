#include "nodes/segment/segment.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/segment/coverage.h"
#include "nodes/segment/measure.h"

namespace terrazzo::segment {
namespace {

void check_image(const Image& image) {
  if (image.width <= 0 || image.height <= 0 || image.sections <= 0 ||
      image.pixels.size() != static_cast<std::size_t>(image.width) * image.height * image.sections)
    throw Error("empty-image", "the image has no pixels");
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    if (!image.pixels[i].allFinite())
      throw Error("bad-pixels",
                  "the image contains NaN or infinity at column " + std::to_string(i % image.width) +
                      ", row " + std::to_string(i / image.width % image.height) + " of section " +
                      std::to_string(i / image.width / image.height),
                  "replace those pixels before segmenting the image");
}

// Classifies profiles by k-means on their mean colors. Classes are numbered by decreasing number of profiles.
void classify(Segmentation& s, int k, std::uint64_t seed, const Work& work) {
  auto& profiles = s.profiles.profiles;
  std::vector<Vec3f> colors;
  for (const auto& p : profiles) colors.push_back(patch_color_of_linear(p.color));
  Clusters clusters;
  if (k > 0) {
    clusters = k_means(colors, k, seed, work);
  } else {
    for (int n = 2; n <= 8; ++n)
      if (Clusters c = k_means(colors, n, seed, work); n == 2 || c.silhouette > clusters.silhouette + 0.005)
        clusters = std::move(c);
  }
  std::vector<int> order(clusters.centers.size()), cls(order.size());
  for (std::size_t c = 0; c < order.size(); ++c) order[c] = static_cast<int>(c);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return clusters.weights[a] > clusters.weights[b]; });
  for (std::size_t c = 0; c < order.size(); ++c) cls[order[c]] = static_cast<int>(c);
  s.profiles.classes = 1;
  for (std::size_t i = 0; i < profiles.size(); ++i) {
    profiles[i].cls = cls[clusters.nearest(colors[i])];
    s.labels.classes[i] = profiles[i].cls;
    s.profiles.classes = std::max(s.profiles.classes, profiles[i].cls + 1);
  }
}

// Separate phases differ strongly compared with the usual difference between neighboring patches. In a
// photograph of a rough surface, texture and shadow are about as strong as the difference of stones and sand.
Method fitting_method(const std::vector<Mosaic>& sections) {
  double apart = 0, usual = 0;
  for (const auto& m : sections) apart += m.spread, usual += m.contrast;
  return apart < 5 * usual ? Method::Regions : Method::Clusters;
}

Vec3f binder_color(const Ground& ground, const Hint& hint) {
  switch (hint.kind) {
    case Hint::Kind::Darkest:
      return ground.clusters.centers.front();
    case Hint::Kind::Lightest:
      return ground.clusters.centers.back();
    default:
      return hint.color;
  }
}

}  // namespace

Segmentation segment(const Image& image, const SegmentOptions& options, const Work& work) {
  check_image(image);
  Segmentation s;
  std::vector<Mosaic> mosaics;
  for (int i = 0; i < image.sections; ++i)
    mosaics.push_back(
        make_mosaic(image, i, work.part(0.6 * i / image.sections, 0.6 * (i + 1) / image.sections)));
  s.method = options.method == Method::Auto ? fitting_method(mosaics) : options.method;
  s.ground = find_ground(mosaics, options.clusters, options.binder, options.split.strength,
                         s.method == Method::Clusters, options.seed, work.part(0.6, 0.7));
  s.labels.width = image.width, s.labels.height = image.height, s.labels.sections = image.sections;
  s.labels.pixel_size = image.pixel_size;
  std::vector<float> coverage;
  const Vec3f binder = binder_color(s.ground, options.binder);
  const Vec3f* hinted = options.binder.kind == Hint::Kind::Auto ? nullptr : &binder;
  for (const auto& m : mosaics) {
    Particles2D found = s.method == Method::Regions
                            ? find_particles_by_regions(m, options.likeness, hinted, options.split, work)
                            : find_particles(m, s.ground, options.split, work);
    const std::int32_t before = s.labels.count();
    std::int32_t count = 0;
    for (const auto l : found.labels) {
      count = std::max(count, l);
      s.labels.ids.push_back(l == 0 ? 0 : l + before);
    }
    s.labels.classes.resize(before + count, 0);
    coverage.insert(coverage.end(), found.coverage.begin(), found.coverage.end());
    s.min_area = found.min_area;
    s.specks += found.specks, s.speck_pixels += found.speck_pixels, s.holes += found.holes;
  }
  if (s.labels.classes.empty())
    throw Error("no-particles",
                "no particles are left: " + std::to_string(s.specks) + " parts are smaller than min_area (" +
                    fmt::format("{:g}", s.min_area) + " pixels)",
                "lower min_area, or set binder to the binder's color");
  s.profiles = measure_profiles(image, s.labels, coverage, work.part(0.8, 1));
  if (options.color_classes != 1) classify(s, options.color_classes, options.seed, work);
  return s;
}

Segmentation measure_labels(const Image& image, const Labels& labels, const SegmentOptions& options,
                            const Work& work) {
  check_image(image);
  if (labels.width != image.width || labels.height != image.height || labels.sections != image.sections)
    throw Error("size-mismatch",
                "the labels have " + std::to_string(labels.width) + " × " + std::to_string(labels.height) +
                    " pixels in " + std::to_string(labels.sections) + " sections, but the image has " +
                    std::to_string(image.width) + " × " + std::to_string(image.height) + " pixels in " +
                    std::to_string(image.sections),
                "connect labels of the same image");
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
    if (number[id] == 0)
      classes.push_back(labels.classes[id - 1]), number[id] = static_cast<std::int32_t>(classes.size());
    id = number[id];
  }
  s.labels.classes = std::move(classes);
  if (s.labels.classes.empty()) throw Error("no-particles", "the labels contain no particles");
  std::vector<float> coverage;
  const std::size_t size = static_cast<std::size_t>(image.width) * image.height;
  for (int i = 0; i < labels.sections; ++i) {
    const auto first = s.labels.ids.begin() + static_cast<std::ptrdiff_t>(size * i);
    const auto share =
        smooth_coverage({first, first + static_cast<std::ptrdiff_t>(size)}, image.width, image.height, work);
    coverage.insert(coverage.end(), share.begin(), share.end());
  }
  s.profiles = measure_profiles(image, s.labels, coverage, work);
  if (options.color_classes != 1) classify(s, options.color_classes, options.seed, work);
  return s;
}

}  // namespace terrazzo::segment
