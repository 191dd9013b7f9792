#include "nodes/photograph/segment/measure/view.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/stereology/silhouette.h"
#include "nodes/data/indices.h"
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

// Logarithm of luminance, limited where it is dark.
std::vector<float> log_luminance(const Image& image, int section) {
  const std::size_t size = pixels_in(image.width, image.height), before = size * section;
  std::vector<float> light(size);
  for (std::size_t i = 0; i < size; ++i)
    light[i] = std::max(0.0F, image.pixels[before + i].dot(Vec3f(0.2126F, 0.7152F, 0.0722F)));
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
  return out;
}

bool at_border(std::span<const std::int32_t> pixels, int width, int height) {
  return std::any_of(pixels.begin(), pixels.end(), [&](std::int32_t i) {
    const int x = i % width, y = i / width;
    return x == 0 || y == 0 || x == width - 1 || y == height - 1;
  });
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
      ++out.judged;
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

void set_view(Profiles& profiles, View view, const ViewEvidence& evidence) {
  profiles.view = view;
  if (view != View::Surface) return;
  profiles.light = evidence.light;
  for (Profile& p : profiles.profiles) p.whole = std::max(p.area, whole_silhouette(p.contour));
}

}  // namespace terrazzo::segment
