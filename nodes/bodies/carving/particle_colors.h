// The colors of particles and binder, optionally with a photograph's fine detail.
#pragma once

#include <vector>

#include "nodes/common/texture/color.h"
#include "nodes/data/particles.h"
#include "nodes/detail/residual/residual_field.h"
#include "nodes/detail/residual/skins.h"

namespace terrazzo::carving {

class ParticleColors {
 public:
  // The residual and the skins may be null; otherwise they must outlive this object.
  explicit ParticleColors(const Particles& particles, const residual::ResidualField* residual = nullptr,
                          const residual::Skins* skins = nullptr)
      : residual_(residual), skins_(skins) {
    const auto add = [&](const Vec3f& c) {
      flat_.push_back(c.cwiseMax(0.0f).cwiseMin(1.0f));
      encoded_.push_back(linear_to_srgb(flat_.back()));
    };
    // A point in a void is on its wall, except for rounding.
    for (std::size_t i = 0; i < particles.count(); ++i)
      add(particles.is_void(i) ? particles.binder_color : particles.color[i]);
    add(particles.binder_color);
  }

  // Color at a point in mm, of a particle or, if that is −1, of the binder. `sharp` adds the particle's skin
  // or, if it has none, the detail, in encoded values, as it was measured. Skins can be lighter than 1.
  Vec3f at(const Vec3f& mm, int particle, bool sharp) const {
    const std::size_t i = particle < 0 ? flat_.size() - 1 : static_cast<std::size_t>(particle);
    if (sharp && skins_) {
      if (particle < 0 && skins_->has_ground()) return skins_->ground(mm, flat_[i]);
      if (particle >= 0 && !skins_->bare(particle)) return in_skin(mm, particle);
    }
    if (!residual_ || !sharp) return flat_[i];
    return srgb_to_linear((encoded_[i] + residual_->at(mm, particle)).cwiseMax(0.0f).cwiseMin(1.0f));
  }

 private:
  // Skins can be lighter than 1, where sRGB's encoding is not defined.
  Vec3f in_skin(const Vec3f& mm, int particle) const {
    const Vec3f color = skins_->at(mm, particle, flat_[particle]);
    const float lost = skins_->lost_grain(particle);
    if (!residual_ || lost <= 0) return color;
    const Vec3f grain = lost * residual_->at(mm, particle);
    return srgb_to_linear((linear_to_srgb(color.cwiseMin(1.0f)) + grain).cwiseMax(0.0f).cwiseMin(1.0f));
  }

  std::vector<Vec3f> flat_, encoded_;  // the binder's last
  const residual::ResidualField* residual_;
  const residual::Skins* skins_;
};

}  // namespace terrazzo::carving
