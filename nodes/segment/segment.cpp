#include "nodes/segment/segment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/components.h"
#include "nodes/data/equal_size.h"
#include "nodes/segment/coverage.h"
#include "nodes/segment/measure.h"
#include "nodes/segment/network_particles.h"

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

// Objects that the network recognizes, unless they are so small that they may be a mistake.
void ignore_objects(const std::vector<std::uint8_t>& found, int section, const Image& image,
                    IgnoredPixels& ignored, std::vector<FoundObject>& objects) {
  const Components parts =
      connected_components({found.begin(), found.end()}, image.width, image.height, true);
  std::vector<FoundObject> boxes(parts.count(), {section, image.width, image.height, -1, -1, 0});
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (const auto k = parts.ids[static_cast<std::size_t>(y) * image.width + x]; k > 0) {
        FoundObject& b = boxes[k - 1];
        b.left = std::min(b.left, x), b.right = std::max(b.right, x);
        b.top = std::min(b.top, y), b.bottom = std::max(b.bottom, y);
        ++b.pixels;
      }
  const auto smallest =
      std::max<std::int64_t>(200, static_cast<std::int64_t>(image.width) * image.height / 1000);
  const std::size_t before = objects.size();
  for (const FoundObject& b : boxes)
    if (b.pixels >= smallest) objects.push_back(b);
  if (objects.size() == before) return;
  ignored.resize(image.pixels.size(), 0);
  for (std::size_t i = 0; i < parts.ids.size(); ++i)
    if (const auto k = parts.ids[i]; k > 0 && boxes[k - 1].pixels >= smallest)
      ignored[image.index(0, 0, section) + i] = 1;
}

// Removes labels from ignored pixels, then those without pixels or with too little confidence, and renumbers
// the rest.
void drop_labels(Segmentation& s, std::vector<double>& confidence, const IgnoredPixels& ignored,
                 double least) {
  std::vector<std::uint8_t> used(s.labels.classes.size() + 1, 0);
  for (std::size_t i = 0; i < s.labels.ids.size(); ++i) {
    if (!ignored.empty() && ignored[i]) s.labels.ids[i] = 0;
    used[s.labels.ids[i]] = 1;
  }
  std::vector<std::int32_t> number(used.size(), 0);
  std::int32_t count = 0;
  for (std::size_t k = 1; k < used.size(); ++k) {
    if (!used[k]) continue;
    if (confidence[k - 1] < least) {
      ++s.unlikely;
      continue;
    }
    confidence[count] = confidence[k - 1], s.labels.classes[count] = s.labels.classes[k - 1];
    number[k] = ++count;
  }
  confidence.resize(count), s.labels.classes.resize(count);
  for (auto& id : s.labels.ids) id = number[id];
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

// The particles of all sections by one method, and what the network thinks of them.
struct Attempt {
  Labels labels;
  std::vector<float> coverage;
  std::vector<double> confidence;
  double min_area = 0;
  std::int64_t specks = 0, speck_pixels = 0, holes = 0;

  void add(Particles2D found, const std::vector<double>& judged) {
    const std::int32_t before = labels.count();
    for (const auto l : found.labels) labels.ids.push_back(l == 0 ? 0 : l + before);
    labels.classes.resize(before + judged.size(), 0);
    confidence.insert(confidence.end(), judged.begin(), judged.end());
    coverage.insert(coverage.end(), found.coverage.begin(), found.coverage.end());
    min_area = found.min_area;
    specks += found.specks, speck_pixels += found.speck_pixels, holes += found.holes;
  }

  // What is expected to be right and what was found in all, each particle counted by the length of its
  // outline: by area, one boulder would decide, by number, the crumbs.
  struct Weight {
    double right = 0, found = 0;
  };
  Weight weight() const {
    std::vector<double> area(confidence.size(), 0);
    for (const auto id : labels.ids)
      if (id > 0) ++area[id - 1];
    Weight w;
    for (std::size_t k = 0; k < area.size(); ++k)
      w.right += std::sqrt(area[k]) * confidence[k], w.found += std::sqrt(area[k]);
    return w;
  }
};

}  // namespace

Segmentation segment(const Image& photo, const SegmentOptions& options, const Work& work) {
  check_image(photo);
  Segmentation s;
  IgnoredPixels ignored = options.ignored;
  const int sections = photo.sections;
  s.method = options.method;
  if (s.method == Method::Auto && options.scribbles.particles && options.scribbles.binder)
    s.method = Method::Scribbles;
  // Who knows the binder or the number of clusters has chosen the method.
  if (s.method == Method::Auto && (options.binder.kind != Hint::Kind::Auto || options.clusters > 0))
    s.method = Method::Clusters;
  const bool network = s.method == Method::Auto || s.method == Method::Network;
  std::optional<Network> own;
  const Network* given = options.network;
  if (network && !given) given = &own.emplace(built_in_model());
  // The maps of a stack can exceed its memory many times over, so those of large stacks are made again when
  // needed.
  const bool keep = photo.pixels.size() <= (16u << 20);
  std::vector<std::shared_ptr<const NetworkView>> views(sections);
  const auto view_of = [&](int i, const Work& part) {
    if (views[i]) return views[i];
    auto view = std::make_shared<const NetworkView>(photo, i, *given, part);
    if (keep) views[i] = view;
    return std::shared_ptr<const NetworkView>(view);
  };
  Attempt by_network;
  if (network)
    for (int i = 0; i < sections; ++i) {
      const auto view = view_of(i, work.part(0.4 * i / sections, 0.4 * (i + 1) / sections));
      NetworkOptions how;
      if (options.split.min_area >= 0) how.min_area = options.split.min_area;
      auto found = view->find_particles(how, work.quiet());
      by_network.add(std::move(found.particles), found.confidence);
      ignore_objects(view->not_material(), i, photo, ignored, s.not_material);
    }
  Image covered;
  if (!ignored.empty()) {
    covered = photo;
    for (int i = 0; i < sections; ++i) cover_ignored(covered, i, ignored);
  }
  const Image& image = ignored.empty() ? photo : covered;

  const auto by_color_or_edge = [&](Method method) {
    std::vector<Mosaic> mosaics;
    for (int i = 0; i < sections; ++i)
      mosaics.push_back(
          make_mosaic(image, i, work.part(0.4 + 0.3 * i / sections, 0.4 + 0.3 * (i + 1) / sections)));
    // Separate phases differ strongly compared with the usual difference between neighboring patches.
    double apart = 0, usual = 0;
    for (const auto& m : mosaics) apart += m.spread, usual += m.contrast;
    s.distinct_phases = apart >= 5 * usual;
    s.ground = find_ground(mosaics, options.clusters, options.binder, options.split.strength,
                           method == Method::Clusters, options.seed, work.part(0.7, 0.75));
    const Vec3f binder = binder_color(s.ground, options.binder);
    const Vec3f* hinted = options.binder.kind == Hint::Kind::Auto ? nullptr : &binder;
    Attempt a;
    for (int i = 0; i < sections; ++i) {
      Particles2D found =
          method == Method::Regions
              ? find_particles_by_regions(mosaics[i], options.likeness, hinted, options.split, work)
              : find_particles(mosaics[i], s.ground, options.split, work);
      const std::int32_t count = *std::max_element(found.labels.begin(), found.labels.end());
      const std::vector<double> judged = network ? view_of(i, work.quiet())->confidence(found.labels, count)
                                                 : std::vector<double>(count, 1.0);
      a.add(std::move(found), judged);
    }
    return a;
  };
  const auto by_scribbles = [&] {
    const ScribbleForest forest(image, 0, options.scribbles, options.seed, work.part(0, 0.2));
    Attempt a;
    for (int i = 0; i < sections; ++i) {
      const ScribbleMaps maps =
          forest.classify(image, i, work.part(0.2 + 0.6 * i / sections, 0.2 + 0.6 * (i + 1) / sections));
      Particles2D found =
          find_particles_by_scribbles(maps, image.width, image.height, options.split, work.quiet());
      const std::int32_t count = *std::max_element(found.labels.begin(), found.labels.end());
      if (options.scribbles.not_material) {
        ignored.resize(photo.pixels.size(), 0);
        for (std::size_t k = 0; k < maps.not_material.size(); ++k)
          if (maps.not_material[k] > 0.5f) ignored[photo.index(0, 0, i) + k] = 1;
      }
      // How clearly the trees agree: 0 where half of them say particle, 1 where all do.
      std::vector<double> sum(count, 0), pixels(count, 0);
      for (std::size_t k = 0; k < found.labels.size(); ++k)
        if (const auto id = found.labels[k]; id > 0)
          sum[id - 1] += std::max(0.0f, 2 * maps.particle[k] - 1), ++pixels[id - 1];
      for (std::int32_t k = 0; k < count; ++k) sum[k] /= std::max(1.0, pixels[k]);
      a.add(std::move(found), sum);
    }
    return a;
  };
  Attempt best;
  if (s.method == Method::Auto) {
    Attempt clusters = by_color_or_edge(Method::Clusters);
    best = std::move(by_network);
    // The average precision to expect, right / (found + missed), if at least what the better method gets
    // right is there.
    const Attempt::Weight c = clusters.weight(), n = best.weight();
    const double there = std::max(c.right, n.right);
    const auto precision = [&](const Attempt::Weight& w) {
      return w.right > 0 ? w.right / (w.found + there - w.right) : 0;
    };
    s.reliability = {precision(c), precision(n)};
    // The network is the judge of its own particles, so where the phases differ clearly in color it has to be
    // much better, and elsewhere a little: the outlines of clusters are finer.
    const double lead = s.distinct_phases ? 1.6 : 1.1;
    s.method = Method::Network;
    if (!clusters.labels.classes.empty() && lead * s.reliability.clusters > s.reliability.network)
      best = std::move(clusters), s.method = Method::Clusters;
  } else {
    best = network                         ? std::move(by_network)
           : s.method == Method::Scribbles ? by_scribbles()
                                           : by_color_or_edge(s.method);
  }
  s.labels = std::move(best.labels);
  s.labels.width = image.width, s.labels.height = image.height, s.labels.sections = sections;
  s.labels.pixel_size = image.pixel_size;
  s.min_area = best.min_area, s.specks = best.specks, s.speck_pixels = best.speck_pixels,
  s.holes = best.holes;
  drop_labels(s, best.confidence, ignored, options.min_confidence);
  if (s.labels.classes.empty())
    throw Error(
        "no-particles",
        "no particles are left: " + std::to_string(s.specks) + " parts are smaller than min_area (" +
            fmt::format("{:g}", s.min_area) + " pixels), and " + std::to_string(s.unlikely) +
            " are below min_confidence",
        "lower min_area or min_confidence, set binder to the binder's color, or choose another method");
  s.profiles = measure_profiles(photo, s.labels, best.coverage, ignored, work.part(0.8, 1));
  for (std::size_t k = 0; k < s.profiles.profiles.size(); ++k)
    s.profiles.profiles[k].confidence = best.confidence[k];
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
    if (number[id] == 0)
      classes.push_back(labels.classes[id - 1]), number[id] = static_cast<std::int32_t>(classes.size());
    id = number[id];
  }
  s.labels.classes = std::move(classes);
  std::vector<double> confidence(s.labels.classes.size(), 1.0);
  drop_labels(s, confidence, options.ignored, 0);
  if (s.labels.classes.empty()) throw Error("no-particles", "the labels contain no particles");
  std::vector<float> coverage;
  const std::size_t size = static_cast<std::size_t>(image.width) * image.height;
  for (int i = 0; i < labels.sections; ++i) {
    const auto first = s.labels.ids.begin() + static_cast<std::ptrdiff_t>(size * i);
    const auto share =
        smooth_coverage({first, first + static_cast<std::ptrdiff_t>(size)}, image.width, image.height, work);
    coverage.insert(coverage.end(), share.begin(), share.end());
  }
  s.profiles = measure_profiles(image, s.labels, coverage, options.ignored, work);
  if (options.color_classes != 1) classify(s, options.color_classes, options.seed, work);
  return s;
}

}  // namespace terrazzo::segment
