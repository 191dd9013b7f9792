#include "nodes/photograph/segment/outline/contacts.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/components.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/segment/neighbors.h"
#include "nodes/photograph/segment/outline/coverage.h"

namespace terrazzo::segment {
namespace {

constexpr int kReach = 3;                  // pixels
constexpr std::int64_t kFewest = 5;        // pixels of an opening that no other binder touches
constexpr float kNoise = 4, kTexture = 2;  // the least contrast, in standard deviations

// Weighted sums over pixels of one label.
struct Sums {
  double weight = 0, squares = 0;
  Eigen::Vector3d seen = Eigen::Vector3d::Zero();
  Eigen::Vector3d light = Eigen::Vector3d::Zero();
  void add(const Sums& s, double factor) {
    weight += factor * s.weight;
    squares += factor * s.squares;
    seen += factor * s.seen;
    light += factor * s.light;
  }
  double variance() const { return std::max(0.0, squares / weight - (seen / weight).squaredNorm()); }
};

class Contacts {
 public:
  Contacts(const Image& image, int section, const LabImage& patch_colors,
           const std::vector<std::int32_t>& labels, const Work& work)
      : width_(image.width), height_(image.height), labels_(labels), seen_(patch_colors) {
    noise_ = noise_of(seen_);
    const bool gray = std::all_of(seen_.pixels.begin(), seen_.pixels.end(), [](const Vec3f& p) {
      return std::abs(p[1]) < 2e-3f && std::abs(p[2]) < 2e-3f;
    });
    // A pixel shared by two colors has their mean in linear light, or in the encoded values of a signal.
    const Vec3f* first = image.pixels.data() + image.index(0, 0, section);
    light_.assign(first, first + seen_.pixels.size());
    if (gray)
      for (auto& p : light_) p = linear_to_srgb(p);
    look_around(work);
  }

  // Pixels of particles near another particle.
  const std::vector<std::size_t>& pixels() const { return near_; }
  bool has_binder() const { return whole_[0].weight > 20; }

  // The share of the particle in its pixel's color, or 1 if it cannot be told from the binder.
  float share(std::size_t i) const {
    const Sums own = around(i, labels_[i], 6, 6), binder = around(i, 0, 12, 6);
    const double apart = (own.seen / own.weight - binder.seen / binder.weight).squaredNorm();
    const double texture = (own.variance() + binder.variance()) / 2;
    if (apart < kTexture * kTexture * texture || apart < kNoise * kNoise * noise_ * noise_) return 1;
    const Eigen::Vector3d b = binder.light / binder.weight;
    const Eigen::Vector3d axis = own.light / own.weight - b;
    if (axis.squaredNorm() < 1e-12) return 1;
    return (light_[i].cast<double>() - b).dot(axis) / axis.squaredNorm();
  }

 private:
  // The image's blur mixes colors at outlines, so pixels count more the deeper they are in their label.
  void look_around(const Work& work) {
    depth_.assign(labels_.size(), 0);
    std::vector<std::uint8_t> near(labels_.size(), 0);
    work.quiet().parallel(height_, 16, [&](std::size_t begin, std::size_t end) {
      for (int y = begin; y < static_cast<int>(end); ++y)
        for (int x = 0; x < width_; ++x) {
          const std::size_t i = at(x, y);
          int deep = kReach + 1;
          for (int v = std::max(0, y - kReach); v <= std::min(height_ - 1, y + kReach); ++v)
            for (int u = std::max(0, x - kReach); u <= std::min(width_ - 1, x + kReach); ++u) {
              const auto other = labels_[at(u, v)];
              if (other == labels_[i]) continue;
              deep = std::min(deep, std::max(std::abs(u - x), std::abs(v - y)));
              if (other > 0 && labels_[i] > 0) near[i] = 1;
            }
          const float d = static_cast<float>(deep - 1) / kReach;
          depth_[i] = d * d + 1e-6f;
        }
    });
    whole_.resize(1);
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      const std::size_t k = labels_[i];
      if (k >= whole_.size()) whole_.resize(k + 1);
      whole_[k].add(one(i), depth_[i]);
      if (near[i]) near_.push_back(i);
    }
  }

  Sums one(std::size_t i) const {
    const Eigen::Vector3d c = seen_.pixels[i].cast<double>();
    return {1, c.squaredNorm(), c, light_[i].cast<double>()};
  }

  // The label's pixels within `reach`; where they weigh less than `least`, all of its pixels complete them.
  Sums around(std::size_t i, std::int32_t label, int reach, double least) const {
    const int x = i % width_, y = i / width_;
    Sums s;
    for (int v = std::max(0, y - reach); v <= std::min(height_ - 1, y + reach); ++v)
      for (int u = std::max(0, x - reach); u <= std::min(width_ - 1, x + reach); ++u)
        if (const std::size_t j = at(u, v); labels_[j] == label) s.add(one(j), depth_[j]);
    const Sums& all = whole_[label];
    if (s.weight < least) s.add(all, (least - s.weight) / all.weight);
    return s;
  }

  std::size_t at(int x, int y) const { return pixel_at(x, y, width_); }

  int width_, height_;
  const std::vector<std::int32_t>& labels_;
  const LabImage& seen_;
  float noise_ = 0;
  std::vector<Vec3f> light_;
  std::vector<float> depth_;
  std::vector<Sums> whole_;  // of each label
  std::vector<std::size_t> near_;
};

// Closes openings of a few pixels that do not reach other binder.
void close_specks(const std::vector<std::int32_t>& before, std::vector<std::int32_t>& labels, int width,
                  int height) {
  std::vector<std::int32_t> binder(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) binder[i] = labels[i] == 0;
  const Components parts = connected_components(binder, width, height, true);
  std::vector<std::uint8_t> keeps(parts.count() + 1, 0);
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (const auto k = parts.ids[i]; k > 0 && (before[i] == 0 || parts.sizes[k - 1] >= kFewest)) keeps[k] = 1;
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (const auto k = parts.ids[i]; k > 0 && !keeps[k]) labels[i] = before[i];
}

// Leaves the largest part of each particle, or all of it if too little is left.
void keep_particles(const std::vector<std::int32_t>& before, std::vector<std::int32_t>& labels, int width,
                    int height) {
  const Components parts = connected_components(labels, width, height, false);
  const auto count = static_cast<std::size_t>(*std::max_element(before.begin(), before.end())) + 1;
  std::vector<std::int32_t> largest(count, 0);
  std::vector<std::int64_t> all(count, 0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    ++all[before[i]];
    if (const auto k = parts.ids[i]; k > 0)
      if (auto& l = largest[labels[i]]; l == 0 || parts.sizes[k - 1] > parts.sizes[l - 1]) l = k;
  }
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto id = before[i];
    if (id == 0) continue;
    const std::int64_t left = largest[id] == 0 ? 0 : parts.sizes[largest[id] - 1];
    if (2 * left < all[id])
      labels[i] = id;
    else if (parts.ids[i] != largest[id])
      labels[i] = 0;
  }
}

}  // namespace

void open_contacts(const Image& image, int section, const LabImage& patch_colors,
                   std::vector<std::int32_t>& labels, std::vector<float>& coverage, const Work& work) {
  const Contacts contacts(image, section, patch_colors, labels, work);
  if (contacts.pixels().empty() || !contacts.has_binder()) return;
  const std::vector<std::size_t>& near = contacts.pixels();
  std::vector<float> shares(near.size());
  work.parallel(near.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) shares[k] = contacts.share(near[k]);
  });
  const std::vector<std::int32_t> before = labels;
  for (std::size_t k = 0; k < near.size(); ++k)
    if (shares[k] < 0.5f) labels[near[k]] = 0;
  close_specks(before, labels, image.width, image.height);
  keep_particles(before, labels, image.width, image.height);
  for (std::size_t k = 0; k < near.size(); ++k) {
    const std::size_t i = near[k];
    bool beside_binder = false;
    neighbors(i, image.width, image.height, [&](std::size_t j) { beside_binder |= labels[j] == 0; });
    if (labels[i] == 0)
      coverage[i] = sided(shares[k], false);
    else if (beside_binder)
      coverage[i] = sided(std::min(coverage[i], shares[k]), true);
  }
  for (std::size_t i = 0; i < labels.size(); ++i)  // pieces that were cut off
    if (labels[i] == 0 && before[i] != 0) coverage[i] = sided(coverage[i], false);
}

}  // namespace terrazzo::segment
