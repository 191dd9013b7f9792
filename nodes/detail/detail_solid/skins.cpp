#include "nodes/detail/detail_solid/skins.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/data/indices.h"
#include "nodes/data/luminance.h"
#include "nodes/detail/detail_solid/fill.h"
#include "nodes/detail/detail_solid/shadows.h"

namespace terrazzo::detail_solid {
namespace {

constexpr double kLeastPixels = 100;     // of a stone
constexpr double kCut = 4;               // times as many of a stone that the border cuts
constexpr double kLeastSeen = 40;        // of them, away from its outline
constexpr double kMostPixels = 8 << 20;  // of all skins: 96 MiB
constexpr double kVisible = 0.7;         // share of its silhouette that nothing hides
constexpr float kShadow = -1.1F;         // shade of what lies in the shadow of another stone
constexpr double kShadowed = 0.1;        // share of a stone on which too much of a shadow falls
constexpr double kOwnForm = 0.6;         // share of light and shade in what a stone's form has alone
constexpr float kInside = 1.5F;          // pixels inside outlines that the camera mixes with what is behind
constexpr double kMargin = 0.25;         // around the visible part, in its larger extent
constexpr int kRings = 12;               // from the outline to the middle
using Plane = Eigen::Matrix<double, 6, 1>;

struct Box {
  int left = 1 << 30, top = 1 << 30, right = -1, bottom = -1;  // the last ones included
  double pixels = 0;
  int margin() const { return round_up(kMargin * std::max(right - left + 1, bottom - top + 1)); }
  double with_margin() const {
    return double(right - left + 1 + 2 * margin()) * (bottom - top + 1 + 2 * margin());
  }
  void add(int x, int y) {
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
    ++pixels;
  }
};

// A stone on its way to a skin. Arrays are ordered row by row from the top, over the stone's box and a
// margin.
struct Stone {
  Detail::Skin skin;
  std::vector<std::uint8_t> seen;  // 1: shows the stone, away from its outline
  std::vector<float> ring;         // 0 at the outline, 1 at the deepest place of the stone
  std::size_t size() const { return seen.size(); }
};

// The depth of each pixel below the outline, in pixels.
cv::Mat depth_in(const std::vector<std::uint8_t>& inside, int width, int height) {
  cv::Mat padded = cv::Mat::zeros(height + 2, width + 2, CV_8U);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) padded.at<std::uint8_t>(y + 1, x + 1) = inside[pixel_at(x, y, width)];
  cv::Mat depth;
  cv::distanceTransform(padded, depth, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return depth(cv::Rect(1, 1, width, height)).clone();
}

Stone cut_out(const Image& image, const Labels& labels, const Profile& profile, int id, const Box& box) {
  Stone stone;
  Detail::Skin& skin = stone.skin;
  const int margin = box.margin();
  const int left = box.left - margin;
  const int top = box.top - margin;
  skin.width = box.right - box.left + 1 + 2 * margin;
  skin.height = box.bottom - box.top + 1 + 2 * margin;
  skin.size = static_cast<float>(std::sqrt(4 * std::max(profile.whole, profile.area) / std::numbers::pi));
  skin.color = profile.color;
  skin.profile = id;
  skin.corner = Vec2(left, image.height - top) * image.pixel_size;
  const std::size_t pixels = pixels_in(skin.width, skin.height);
  std::vector<std::uint8_t> inside(pixels, 0);
  skin.shade.assign(pixels, Vec3f::Zero());
  Vec2 sum = Vec2::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  for (int y = 0; y < skin.height; ++y)
    for (int x = 0; x < skin.width; ++x) {
      const int u = left + x;
      const int v = top + y;
      if (u < 0 || v < 0 || u >= image.width || v >= image.height) continue;
      if (labels.ids[labels.index(u, v, profile.section)] != id) continue;
      const std::size_t i = pixel_at(x, y, skin.width);
      inside[i] = 1;
      skin.shade[i] = Detail::skin_shade(image.at(u, v, profile.section), skin.color);
      const Vec2 at(x + 0.5, y + 0.5);
      sum += at;
      squares += at * at.transpose();
    }
  constexpr double kOfAPixel = 1.0 / 12;
  const Vec2 center = sum / box.pixels;
  skin.center = center.cast<float>();
  skin.spread = (squares / box.pixels - center * center.transpose() + kOfAPixel * Eigen::Matrix2d::Identity())
                    .cast<float>();
  const cv::Mat depth = depth_in(inside, skin.width, skin.height);
  const float deepest = *std::max_element(depth.begin<float>(), depth.end<float>());
  for (std::size_t i = 0; i < pixels; ++i) {
    const float d = depth.at<float>(static_cast<int>(i));
    stone.seen.push_back(d > kInside);
    stone.ring.push_back(std::min(1.0F, (d - kInside) / std::max(1.0F, deepest - kInside)));
  }
  return stone;
}

template <class F>
void each_seen(const Stone& stone, F&& use) {
  for (std::size_t i = 0; i < stone.size(); ++i)
    if (stone.seen[i]) use(i);
}

// Terms of a quadratic about the center, in standard deviations of the silhouette.
Plane terms_at(const Stone& stone, std::size_t i) {
  const Detail::Skin& skin = stone.skin;
  const double x = (i % skin.width + 0.5 - skin.center.x()) / std::sqrt(skin.spread(0, 0));
  const double y = (i / skin.width + 0.5 - skin.center.y()) / std::sqrt(skin.spread(1, 1));
  Plane terms;
  terms << 1, x, y, x * x, x * y, y * y;
  return terms;
}

// The quadratic in luminance that fits a stone's shade best.
Plane form_of(const Stone& stone) {
  Eigen::Matrix<double, 6, 6> squares = Eigen::Matrix<double, 6, 6>::Identity() * 1e-6;
  Plane right = Plane::Zero();
  each_seen(stone, [&](std::size_t i) {
    const Plane terms = terms_at(stone, i);
    squares += terms * terms.transpose();
    right += terms * double(luminance_of(stone.skin.shade[i]));
  });
  return squares.ldlt().solve(right);
}

// Light and shade of a stone's form change slowly across it, and View makes them again: what all stones have,
// and a share of what one has alone. The rest is its own, such as broken faces and stains.
void remove_form(std::vector<Stone>& stones) {
  std::vector<Plane> forms;
  Plane sum = Plane::Zero();
  for (const Stone& stone : stones) {
    forms.push_back(form_of(stone));
    sum += forms.back();
  }
  const Plane usual = sum / std::max<double>(1, count_of(stones));
  for (std::size_t k = 0; k < stones.size(); ++k) {
    const Plane form = usual + kOwnForm * (forms[k] - usual);
    each_seen(stones[k], [&](std::size_t i) {
      stones[k].skin.shade[i] -= Vec3f::Constant(static_cast<float>(form.dot(terms_at(stones[k], i))));
    });
  }
}

double seen_pixels(const Stone& stone) { return std::count(stone.seen.begin(), stone.seen.end(), 1); }

// Whether enough of a stone is away from its outline, and outside of shadows that others cast on it.
bool shows_itself(const Stone& stone) {
  double dark = 0;
  each_seen(stone, [&](std::size_t i) { dark += luminance_of(stone.skin.shade[i]) < kShadow; });
  const double all = seen_pixels(stone);
  return all >= kLeastSeen && dark <= kShadowed * all;
}

// What all stones have in common from the outline inwards is shade, too: neighbors hide the sky there.
void remove_rims(std::vector<Stone>& stones) {
  std::vector<double> sum(kRings, 0), count(kRings, 1e-9);
  const auto ring_of = [](float ring) { return std::min(kRings - 1, round_down(ring * kRings)); };
  for (const Stone& stone : stones)
    each_seen(stone, [&](std::size_t i) {
      const int k = ring_of(stone.ring[i]);
      sum[k] += luminance_of(stone.skin.shade[i]);
      ++count[k];
    });
  std::vector<float> mean;
  for (int k = 0; k < kRings; ++k) mean.push_back(static_cast<float>(sum[k] / count[k]));
  for (Stone& stone : stones)
    each_seen(stone, [&](std::size_t i) {
      stone.skin.shade[i] -= Vec3f::Constant(Detail::at_distance(mean, stone.ring[i] * kRings));
    });
}

// Leaves out dark places at a stone's outline: shadows of its neighbors, or parts of these. All stones
// together tell how dark is unusual.
void leave_out_shadows(std::vector<Stone>& stones) {
  constexpr float kUnusual = 2.5F;  // standard deviations
  std::vector<float> differences;
  for (const Stone& stone : stones)
    each_seen(stone,
              [&](std::size_t i) { differences.push_back(std::abs(luminance_of(stone.skin.shade[i]))); });
  if (differences.empty()) return;
  const float dark = -kUnusual * kOfNormal * median(std::move(differences));
  for (Stone& stone : stones) {
    const int width = stone.skin.width, height = stone.skin.height;
    cv::Mat outside(height, width, CV_8U), shadow(height, width, CV_8U);
    for (std::size_t i = 0; i < stone.size(); ++i) {
      outside.data[i] = !stone.seen[i];
      shadow.data[i] = luminance_of(stone.skin.shade[i]) < dark;
    }
    const cv::Mat left_out = outside_with_shadows(outside, shadow);
    each_seen(stone, [&](std::size_t i) { stone.seen[i] = !left_out.data[i]; });
  }
}

// Removes shadows, then form and rims. Stones of which nothing is in the light are left out.
void clean(std::vector<Stone>& stones, const Work& work) {
  constexpr int kRounds = 3;  // shadows hide in the form of stones until some of them are known
  for (int round = 0; round < kRounds; ++round) {
    std::erase_if(stones, [](const Stone& stone) { return seen_pixels(stone) < kLeastSeen; });
    std::vector<Stone> trial = stones;
    work.check();
    remove_form(trial);
    remove_rims(trial);
    leave_out_shadows(trial);
    for (std::size_t k = 0; k < stones.size(); ++k) stones[k].seen = std::move(trial[k].seen);
  }
  std::erase_if(stones, [](const Stone& stone) { return !shows_itself(stone); });
  remove_form(stones);
  remove_rims(stones);
}

// Of slopes of the shade along the light, relief has three eighths of its power and those across it one
// eighth, if waves run in all directions and those at an angle have the square of its cosine; stains have
// half in each. So the ratio of both tells how strong relief is.
Detail::Relief relief_of(const std::vector<Stone>& stones, const Vec2& light) {
  constexpr double kMostRatio = 2.8;  // near 3, relief alone
  constexpr float kCenter = 0.3F;     // ring from which shadows of neighbors no longer matter
  Detail::Relief relief;
  if (!(light.norm() > 0)) return relief;
  relief.light = light.normalized().cast<float>();
  double along = 0, across = 0;
  for (const Stone& stone : stones) {
    const Detail::Skin& skin = stone.skin;
    const auto inside = [&](std::size_t i) { return stone.seen[i] && stone.ring[i] >= kCenter; };
    for (int y = 1; y + 1 < skin.height; ++y)
      for (int x = 1; x + 1 < skin.width; ++x) {
        const std::size_t right = pixel_at(x + 1, y, skin.width), left = pixel_at(x - 1, y, skin.width);
        const std::size_t upper = pixel_at(x, y - 1, skin.width), lower = pixel_at(x, y + 1, skin.width);
        if (!inside(right) || !inside(left) || !inside(upper) || !inside(lower)) continue;
        const Eigen::Vector2f slope(luminance_of(skin.shade[right]) - luminance_of(skin.shade[left]),
                                    luminance_of(skin.shade[upper]) - luminance_of(skin.shade[lower]));
        const float a = slope.dot(relief.light);
        along += a * a;
        across += slope.squaredNorm() - a * a;
      }
  }
  const double ratio = across > 0 ? std::clamp(along / across, 1.0, kMostRatio) : 1;
  relief.strength = static_cast<float>(4 * (ratio - 1) / (3 - ratio));
  return relief;
}

// Beyond the outline, and where something hides or shadows the stone, its texture continues.
void continue_texture(Stone& stone, std::uint64_t seed, const Work& work) {
  PartialPicture picture{stone.skin.width, stone.skin.height, std::move(stone.skin.shade), stone.seen};
  fill_picture(picture, seed, work);
  stone.skin.shade = std::move(picture.value);
}

std::vector<Box> boxes_of(const Labels& labels) {
  std::vector<Box> boxes(labels.count());
  for (int section = 0; section < labels.sections; ++section)
    for (int y = 0; y < labels.height; ++y)
      for (int x = 0; x < labels.width; ++x)
        if (const std::int32_t id = labels.ids[labels.index(x, y, section)]; id > 0) boxes[id - 1].add(x, y);
  return boxes;
}

// Stones that are large enough and mostly visible. Of those that the border cuts, the texture continues.
std::vector<std::size_t> usable_stones(const Labels& labels, const Profiles& profiles,
                                       const std::vector<Box>& boxes) {
  std::vector<std::size_t> usable;
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const Profile& p = profiles.profiles[k];
    if (p.section < 0 || p.section >= labels.sections)
      throw Error("size-mismatch",
                  fmt::format("profile {} is in section {} of {}", k + 1, p.section + 1, labels.sections),
                  "use labels and profiles of the same segmentation");
    if (p.area > 0 && p.color.allFinite() &&
        boxes[k].pixels >= (p.touches_border ? kCut : 1) * kLeastPixels && p.area >= kVisible * p.whole)
      usable.push_back(k);
  }
  return usable;
}

}  // namespace

Outsides find_skins(const Image& image, const Labels& labels, const Profiles& profiles, std::uint64_t seed,
                    const Work& work) {
  if (profiles.view != View::Surface) return {};
  if (profiles.profiles.size() != labels.classes.size())
    throw Error(
        "size-mismatch",
        fmt::format("there are {} profiles, and {} in the labels", profiles.profiles.size(), labels.count()),
        "use labels and profiles of the same segmentation");
  const std::vector<Box> boxes = boxes_of(labels);
  const std::vector<std::size_t> usable = usable_stones(labels, profiles, boxes);
  double pixels = 0;
  for (const std::size_t k : usable) pixels += boxes[k].with_margin();
  const std::size_t step = round_up(std::max(1.0, pixels / kMostPixels));  // every second stone, and so on
  std::vector<Stone> stones;
  for (std::size_t n = 0; n < usable.size(); n += step) {
    work.check();
    const std::size_t k = usable[n];
    stones.push_back(cut_out(image, labels, profiles.profiles[k], static_cast<int>(k) + 1, boxes[k]));
  }
  clean(stones, work);
  Outsides out;
  out.relief = relief_of(stones, profiles.light);
  work.parallel(stones.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) continue_texture(stones[k], seed + k, work.quiet());
  });
  for (Stone& stone : stones) out.skins.push_back(std::move(stone.skin));
  return out;
}

}  // namespace terrazzo::detail_solid
