#include "nodes/photograph/segment/measure/view.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/stereology/silhouette.h"
#include "nodes/data/indices.h"
#include "nodes/data/luminance.h"
#include "nodes/photograph/segment/color/split.h"
#include "nodes/photograph/segment/measure/pixel_lists.h"

namespace terrazzo::segment {
namespace {

// Particles with a smaller radius of the largest inner disc are not judged, pixels.
constexpr float kLeastDepth = 7;
// The rim, the ring within it and the middle, as shares of the depth. The ring begins where the camera's blur
// ends, pixels.
constexpr float kRim = 0.2F, kRing = 0.45F, kMiddle = 0.6F, kBlur = 3;
constexpr float kRise = 0.01F;         // least difference between neighboring zones, of ln luminance
constexpr std::size_t kFewPixels = 8;  // of a zone
// Share of shaded particles from which a picture shows a surface, and the fewest particles. Measured on 96
// drawn pictures of banks, heaps, outcrops and sections (results, Views).
constexpr double kShaded = 0.3;
constexpr int kFewJudged = 5;
// Of mixed_view(): the fewest particles of a half, and standard errors that chance exceeds in one picture of
// some thousands.
constexpr int kFewInHalf = 20;
constexpr double kSureDifference = 3.5;

// Logarithm of luminance, limited where it is dark.
std::vector<float> log_luminance(const Image& image, int section) {
  const std::size_t size = pixels_in(image.width, image.height), before = size * section;
  std::vector<float> light(size);
  for (std::size_t i = 0; i < size; ++i) light[i] = std::max(0.0F, luminance_of(image.pixels[before + i]));
  std::vector<float> sorted = light;
  const auto ninth = sorted.begin() + static_cast<std::ptrdiff_t>(size * 9 / 10);
  std::nth_element(sorted.begin(), ninth, sorted.end());
  const float dark = 0.02F * *ninth + 1e-6F;
  for (float& v : light) v = std::log(v + dark);
  return light;
}

struct OneParticle {
  bool judged = false, shaded = false;
  Vec2 slope = Vec2::Zero();
  Vec2 at = Vec2::Zero();  // centroid of the pixels, from the upper left corner
};

// The plane through the values, by least squares: its slope per radius, right and upwards.
Vec2 slope_of(std::span<const std::int32_t> pixels, int width, const std::vector<float>& light) {
  const double n = pixels.size(), radius = std::sqrt(n / std::numbers::pi);
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  const int x0 = pixels[0] % width, y0 = pixels[0] / width;
  for (const std::int32_t i : pixels) {
    const Eigen::Vector3d basis(1, (i % width - x0) / radius, (y0 - i / width) / radius);
    a += basis * basis.transpose();
    b += basis * light[i];
  }
  return a.ldlt().solve(b).tail<2>();
}

OneParticle judge(std::span<const std::int32_t> pixels, int width, const std::vector<float>& light,
                  const std::vector<float>& depth2) {
  OneParticle out;
  float deepest = 0;
  for (const std::int32_t i : pixels) deepest = std::max(deepest, depth2[i]);
  deepest = std::sqrt(deepest);
  if (deepest < kLeastDepth) return out;
  std::vector<float> rim, ring, middle;
  for (const std::int32_t i : pixels) {
    const float depth = std::sqrt(depth2[i]), share = depth / deepest;
    if (share < kRim)
      rim.push_back(light[i]);
    else if (share < kRing && depth >= kBlur)
      ring.push_back(light[i]);
    else if (share >= kMiddle)
      middle.push_back(light[i]);
  }
  if (std::min({rim.size(), ring.size(), middle.size()}) < kFewPixels) return out;
  const float inner = median(std::move(middle)), between = median(std::move(ring));
  out.judged = true;
  out.shaded = inner - between > kRise && between - median(std::move(rim)) > kRise;
  out.slope = slope_of(pixels, width, light);
  for (const std::int32_t i : pixels) out.at += Vec2(i % width, i / width);
  out.at /= pixels.size();
  return out;
}

bool at_border(std::span<const std::int32_t> pixels, int width, int height) {
  return std::any_of(pixels.begin(), pixels.end(), [&](std::int32_t i) {
    const int x = i % width, y = i / width;
    return x == 0 || y == 0 || x == width - 1 || y == height - 1;
  });
}

void count_shading(const OneParticle& p, int width, int height, ViewEvidence& out) {
  const std::size_t side = p.at.x() < 0.5 * width ? 0 : 1, level = p.at.y() < 0.5 * height ? 2 : 3;
  for (const std::size_t half : {side, level}) {
    ++out.halves[half].judged;
    out.halves[half].shaded += p.shaded;
  }
  ++out.judged;
}

// How many standard errors the shares of shaded particles differ by, if both were equal.
double shading_difference(const ShadingCount& a, const ShadingCount& b) {
  const double n = a.judged, m = b.judged, all = (a.shaded + b.shaded) / (n + m);
  const double error = std::sqrt(all * (1 - all) * (1 / n + 1 / m));
  return error > 0 ? std::abs(a.shaded / n - b.shaded / m) / error : 0;
}

}  // namespace

ViewEvidence view_evidence(const Image& image, const Labels& labels, const Work& work) {
  const std::size_t size = pixels_in(image.width, image.height);
  ViewEvidence out;
  std::vector<double> right, up;
  int shaded = 0;
  for (int section = 0; section < image.sections; ++section) {
    const std::span<const std::int32_t> ids(labels.ids.data() + size * section, size);
    const PixelLists lists(ids);
    const std::vector<float> light = log_luminance(image, section);
    const std::vector<float> depth2 =
        squared_distance({ids.begin(), ids.end()}, image.width, image.height, false, work.quiet());
    std::vector<OneParticle> all(lists.count());
    work.parallel(all.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const auto pixels = lists.of(k);
        if (!pixels.empty() && !at_border(pixels, image.width, image.height))
          all[k] = judge(pixels, image.width, light, depth2);
      }
    });
    for (const OneParticle& p : all) {
      if (!p.judged) continue;
      count_shading(p, image.width, image.height, out);
      shaded += p.shaded;
      right.push_back(p.slope.x());
      up.push_back(p.slope.y());
    }
  }
  if (out.judged == 0) return out;
  out.shaded = static_cast<double>(shaded) / out.judged;
  out.light = {median(std::move(right)), median(std::move(up))};
  return out;
}

View judged_view(const ViewEvidence& e, double area_fraction) {
  if (e.judged >= kFewJudged && e.shaded >= kShaded) return View::Surface;
  return area_fraction >= kNoBinder ? View::Filling : View::Section;
}

std::optional<MixedView> mixed_view(const ViewEvidence& e) {
  static constexpr std::array<const char*, 4> kNames = {"left", "right", "upper", "lower"};
  std::optional<MixedView> out;
  double most = kSureDifference;
  for (const std::size_t first : {0, 2}) {
    std::size_t surface = first, cut = first + 1;
    if (std::min(e.halves[surface].judged, e.halves[cut].judged) < kFewInHalf) continue;
    const auto looks_like_stones = [&](std::size_t half) {
      return e.halves[half].shaded >= kShaded * e.halves[half].judged;
    };
    if (looks_like_stones(surface) == looks_like_stones(cut)) continue;
    if (looks_like_stones(cut)) std::swap(surface, cut);
    const double differs = shading_difference(e.halves[surface], e.halves[cut]);
    if (differs <= most) continue;
    most = differs;
    out = MixedView{kNames[surface], kNames[cut], e.halves[surface], e.halves[cut]};
  }
  return out;
}

void set_view(Profiles& profiles, View view, const ViewEvidence& evidence) {
  profiles.view = view;
  if (view != View::Surface) return;
  profiles.light = evidence.light;
  for (Profile& p : profiles.profiles) p.whole = std::max(p.area, whole_silhouette(p.contour));
}

}  // namespace terrazzo::segment
