#include "nodes/photograph/synthetic_photo/palette.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/common/texture/noise.h"

namespace terrazzo::synthetic_photo {
namespace {

Vec3f from_lab(double l, double a, double b) {
  return oklab_to_linear(Vec3f(static_cast<float>(l), static_cast<float>(a), static_cast<float>(b)))
      .cwiseMax(0.004f)
      .cwiseMin(0.95f);
}
// `by`: standard deviation of lightness; `hue`: of both chroma axes, relative to that.
Vec3f shifted(const Vec3f& color, Random& r, double by, double hue) {
  const Vec3f lab = linear_to_oklab(color);
  return from_lab(std::clamp(lab[0] + by * r.normal(), 0.08, 0.97), lab[1] + 0.8 * hue * by * r.normal(),
                  lab[2] + hue * by * r.normal());
}
double ramp(double lo, double hi, double v) {
  const double t = std::clamp((v - lo) / (hi - lo), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

Vec3f Texture::operator()(const Vec3& p) const {
  double t = 0;
  const Vec3 q = p / scale;
  switch (kind) {
    case Kind::Plain:
      break;
    case Kind::Grain:
      t = ramp(-0.1, 0.4, turbulence(seed, q * 4, 2));
      break;
    case Kind::Blotches:
      t = ramp(-0.05, 0.25, turbulence(seed, q, 3));
      break;
    case Kind::Veins:
      t = 1 - ramp(0.0, 0.09, std::abs(turbulence(seed, q * 0.6, 3)));
      break;
    case Kind::Layers:
      t = 0.5 + 0.5 * std::sin(6 * (q.x() + 0.5 * turbulence(seed, q * 0.5, 2)));
      break;
    case Kind::Cells: {
      const Cell cell = cellular(seed, q * 2.5);
      t = ramp(0.3, 0.7, cell.shade);
      break;
    }
  }
  Vec3f c = color + static_cast<float>(t * strength) * (second - color);
  if (speckle > 0)
    c *= static_cast<float>(std::max(0.15, 1 + speckle * 2.2 * noise(seed + 7, p / speckle_scale)));
  if (vein_width > 0) {
    const double d = vein.dot(p) - vein_offset + 0.25 * mottle_scale * noise(seed + 13, p / mottle_scale);
    c += static_cast<float>(1 - ramp(0.6, 1.2, std::abs(d) / vein_width)) * (vein_color - c);
  }
  if (flecks > 0 && noise(seed + 11, p / fleck_scale) > 0.65 - flecks) c *= fleck_gain;
  if (mottle > 0)
    c *= static_cast<float>(std::max(0.3, 1 + mottle * turbulence(seed + 9, p / mottle_scale, 4)));
  return c * static_cast<float>(std::clamp(1 + tone.dot(p), 0.5, 1.6));
}

PhotoPalette::PhotoPalette(Random& r, Surroundings where, bool gray) : gray_(gray), where_(where) {
  if (where == Surroundings::Outcrop) {
    make_outcrop(r);
    return;
  }
  if (where == Surroundings::Microscope) {
    make_phases(r);
    return;
  }
  const bool outdoors = where == Surroundings::Outdoors;
  // Most stone is grayish or between yellow and red; the chips of a terrazzo may have any hue.
  vivid_ = r.uniform() < (outdoors ? 0.03 : 0.2) ? r.uniform(0.2, 0.8) : r.uniform() < 0.3 ? 0.08 : 0;
  hue_ = outdoors ? r.uniform(0.03, 0.25) : 0.3;
  chroma_ = outdoors ? r.uniform(0.004, 0.022) : r.uniform(0.008, 0.035);
  ground_ = natural(r, 0.25 * vivid_);
  if (outdoors && !gray && r.uniform() < 0.6) {  // sand and clay
    const double hue = 1.35 + 0.2 * r.normal(), chroma = r.uniform(0.015, 0.06);
    ground_ = from_lab(r.uniform(0.35, 0.85), chroma * std::cos(hue), chroma * std::sin(hue));
  }
  const int kinds = 1 + static_cast<int>(r.below(gray ? 3 : 6));
  for (int i = 0; i < kinds; ++i) kinds_.push_back(natural(r, vivid_));
  spread_ = r.uniform(0.01, 0.12);
  liveliness_ = r.uniform() * r.uniform(0.2, 1.0);
  near_ground_ = r.uniform() < 0.65 ? r.uniform(0, outdoors ? 0.8 : 0.9) : 0;
  if (!gray && r.uniform() < 0.3) {
    // Hue alone tells some stones from the ground.
    const float level = r.uniform(0.5, 1), ground = linear_to_oklab(ground_)[0];
    for (Vec3f& kind : kinds_) {
      const Vec3f lab = linear_to_oklab(kind);
      kind = from_lab(lab[0] + level * (ground - lab[0]), 1.4 * lab[1], 1.4 * lab[2]);
    }
    near_ground_ *= 0.3;
  }
  // One kind alone must be told from the ground.
  if (kinds == 1 && (linear_to_oklab(kinds_[0]) - linear_to_oklab(ground_)).norm() < 0.12f) {
    Vec3f lab = linear_to_oklab(ground_);
    lab[0] += lab[0] > 0.5f ? -0.25f : 0.25f;
    kinds_[0] = from_lab(lab[0], lab[1], lab[2]);
  }
}

void PhotoPalette::make_phases(Random& r) {
  ground_ = natural(r, 0.1);
  const Vec3f lab = linear_to_oklab(ground_);
  const int kinds = r.uniform() < 0.7 ? 1 : 2;
  for (int i = 0; i < kinds; ++i) {
    double apart = r.uniform() < 0.5 ? r.uniform(0.05, 0.15) : r.uniform(0.1, 0.5);
    if (r.uniform() < 0.5) apart = -apart;
    if (lab[0] + apart < 0.15 || lab[0] + apart > 0.95) apart = -apart;
    const Vec3f own = linear_to_oklab(natural(r, 0.1));
    kinds_.push_back(from_lab(lab[0] + apart, own[1], own[2]));
  }
  spread_ = r.uniform(0, 0.015);
  hue_ = 0.1;
  liveliness_ = r.uniform() * r.uniform(0, 0.3);
  near_ground_ = 0;
}

void PhotoPalette::make_outcrop(Random& r) {
  const double l = r.uniform(0.45, 0.75), hue = 1.4 + 0.25 * r.normal(), chroma = r.uniform(0.005, 0.05);
  const auto color = [&](double lightness, double a, double b) {
    return from_lab(std::clamp(lightness, 0.2, 0.93), gray_ ? 0 : a, gray_ ? 0 : b);
  };
  ground_ = color(l, chroma * std::cos(hue), chroma * std::sin(hue));
  hue_ = r.uniform(0.05, 0.3);
  chroma_ = 0.01;
  spread_ = r.uniform(0.02, 0.07);
  liveliness_ = r.uniform(0.1, 0.6);
  near_ground_ = r.uniform(0, 0.4);
  const double apart = r.uniform(0.03, 0.1);
  for (int kinds = 3 + static_cast<int>(r.below(4)); kinds > 0; --kinds) {
    const double lightness = r.uniform() < 0.15 ? r.uniform(0.3, 0.9) : l + apart * r.normal();
    kinds_.push_back(color(lightness, 0.004 * r.normal(), r.uniform(-0.025, 0.035)));
  }
}

Vec3f PhotoPalette::natural(Random& r, double vivid) const {
  const double l = r.uniform(0.22, 0.95);
  if (gray_) return from_lab(l, 0, 0);
  if (r.uniform() < vivid) {
    const double chroma = r.uniform(0.04, 0.16), hue = r.uniform(0, 6.2832);
    return from_lab(l, chroma * std::cos(hue), chroma * std::sin(hue));
  }
  const double chroma = std::abs(r.normal()) * chroma_;
  const double hue = r.uniform() < 0.7 ? 1.25 + 0.35 * r.normal() : 4.4 + 0.7 * r.normal();
  return from_lab(l, chroma * std::cos(hue), chroma * std::sin(hue));
}

Texture PhotoPalette::texture(Random& r, const Vec3f& color, double radius, double liveliness) const {
  Texture t;
  t.color = color;
  t.seed = r.bits();
  t.second = r.uniform() < 0.75 ? shifted(color, r, 0.12, hue_) : natural(r, 0.3 * vivid_);
  t.kind = r.uniform() < 0.35 ? Texture::Kind::Plain : static_cast<Texture::Kind>(1 + r.below(5));
  t.scale = std::max(3.0, radius * r.uniform(0.15, 1.2));
  t.strength = liveliness * r.uniform(0.1, 1);
  t.speckle = r.uniform() < 0.7 ? liveliness * r.uniform(0, 0.5) : 0;
  t.speckle_scale = r.uniform(1.2, 6);
  return t;
}

Texture PhotoPalette::stone(Random& r, double radius) const {
  Texture t = particle(r, radius);
  // Strong patterns are rare among stones that lie about.
  if (r.uniform() < 0.9) t.strength *= 0.35;
  if (r.uniform() < 0.6) {
    const double turn = r.uniform(0, 6.2832);
    t.tone = Vec3(std::cos(turn), std::sin(turn), 0) * (r.uniform(0, 0.3) / radius);
  }
  t.mottle = r.uniform() < 0.7 ? r.uniform(0, 0.7) * r.uniform(0.1, 1) : 0;
  t.mottle_scale = std::max(4.0, radius * r.uniform(0.2, 1.5));
  if (r.uniform() < 0.4) {
    t.flecks = r.uniform(0.05, 0.4);
    t.fleck_scale = r.uniform(2, std::max(3.0, 0.12 * radius));
    t.fleck_gain = r.uniform() < 0.5 ? r.uniform(0.5, 0.9) : r.uniform(1.1, 1.7);
  }
  if (r.uniform() < 0.12) {
    const double turn = r.uniform(0, 6.2832), tilt = r.uniform(-0.6, 0.6);
    t.vein = Vec3(std::cos(turn), std::sin(turn), tilt).normalized();
    t.vein_offset = radius * r.uniform(-0.6, 0.6);
    t.vein_width = std::max(1.0, radius * r.uniform(0.01, 0.12));
    if (r.uniform() < 0.3) {  // a crack
      t.vein_width = std::max(1.0, radius * r.uniform(0.01, 0.03));
      t.vein_color = 0.25f * t.color;
    } else
      t.vein_color = r.uniform() < 0.7 ? from_lab(r.uniform(0.75, 0.95), 0, 0.01) : natural(r, vivid_);
  }
  return t;
}

Texture PhotoPalette::ground(Random& r) const {
  Texture t = texture(r, ground_, r.uniform(10, 200),
                      where_ == Surroundings::Microscope ? liveliness_ : std::max(0.15, liveliness_));
  if (where_ != Surroundings::Microscope) t.speckle = std::max(t.speckle, r.uniform(0, 0.35));
  if ((where_ == Surroundings::Outdoors || where_ == Surroundings::Outcrop) && r.uniform() < 0.7)
    t.strength *= 0.4;
  return t;
}

Texture PhotoPalette::clay(Random& r) const {
  Texture t;
  t.color = shifted(ground_, r, 0.08, hue_);
  t.second = shifted(ground_, r, 0.1, hue_);
  t.seed = r.bits();
  t.kind = r.uniform() < 0.5 ? Texture::Kind::Plain : Texture::Kind::Blotches;
  t.scale = r.uniform(10, 120);
  t.strength = r.uniform(0, 0.8);
  t.mottle = r.uniform(0, 0.4);
  t.mottle_scale = r.uniform(10, 100);
  t.speckle = r.uniform(0, 0.15);
  t.speckle_scale = r.uniform(1.2, 5);
  return t;
}

Texture PhotoPalette::particle(Random& r, double radius) const {
  Vec3f base = kinds_[r.below(kinds_.size())];
  if (r.uniform() < near_ground_)
    base = base + static_cast<float>(
                      (where_ == Surroundings::Workshop ? r.uniform(0.4, 0.95) : r.uniform(0.3, 0.85))) *
                      (ground_ - base);
  return texture(r, shifted(base, r, spread_, hue_), radius, liveliness_);
}

}  // namespace terrazzo::synthetic_photo
