#include "nodes/bodies/carving/paint.h"

#include <cmath>

#include "nodes/bodies/carving/color_field.h"
#include "nodes/bodies/carving/particle_colors.h"
#include "nodes/bodies/carving/particle_index.h"

namespace terrazzo::carving {
namespace {

class FieldPaint : public Paint {
 public:
  FieldPaint(const ColorField& field, double repeat, const Placement& placement, bool layer)
      : field_(field),
        resolution_(field.resolution().cast<float>()),
        turn_(placement.turn),
        shift_(placement.shift.cwiseProduct(resolution_)),
        layer_(layer ? 0.5f : 0.0f) {
    voxels_per_unit_ = resolution_.maxCoeff() * static_cast<float>(repeat);
    plain_ = turn_ == Eigen::Matrix3f::Identity() && shift_ == Vec3f::Zero();
  }
  Vec3f at(const Vec3f& point, const Vec3f& face, bool sharp) const override {
    Vec3f voxel = point * voxels_per_unit_ - layer_ * face;
    if (!plain_) voxel = turn_ * voxel + shift_;
    return sharp ? field_.sharp(voxel) : field_.at(voxel);
  }
  Vec3f period() const override { return resolution_ / resolution_.maxCoeff(); }

 private:
  const ColorField& field_;
  Vec3f resolution_;
  Eigen::Matrix3f turn_;
  Vec3f shift_;
  float layer_, voxels_per_unit_;
  bool plain_;
};

class ParticlePaint : public Paint {
 public:
  ParticlePaint(const Particles& particles, const Shapes& shapes, double repeat, const Placement& placement,
                const residual::ResidualField* residual)
      : index_(particles, shapes),
        box_(particles.box.cast<float>()),
        turn_(placement.turn),
        shift_(placement.shift.cwiseProduct(box_)),
        colors_(particles, residual) {
    mm_per_unit_ = box_.maxCoeff() * static_cast<float>(repeat);
  }
  Vec3f at(const Vec3f& point, const Vec3f& face, bool sharp) const override {
    // Just below the surface, where cut particles border on their binder.
    const Vec3f p = turn_ * (point * mm_per_unit_ - (1e-4f * mm_per_unit_) * face) + shift_;
    return colors_.at(p, index_.at(p), sharp);
  }
  Vec3f period() const override { return box_ / box_.maxCoeff(); }

 private:
  ParticleIndex index_;
  Vec3f box_;
  Eigen::Matrix3f turn_;
  Vec3f shift_;
  float mm_per_unit_;
  ParticleColors colors_;
};

}  // namespace

Placement Placement::of(const Vec3& degrees, const Vec3& shift) {
  constexpr double kD = 0.017453292519943295;
  Placement placement;
  placement.turn = (Eigen::AngleAxisd(kD * degrees.z(), Vec3::UnitZ()) *
                    Eigen::AngleAxisd(kD * degrees.y(), Vec3::UnitY()) *
                    Eigen::AngleAxisd(kD * degrees.x(), Vec3::UnitX()))
                       .toRotationMatrix()
                       .cast<float>();
  placement.shift = shift.cast<float>();
  return placement;
}

std::unique_ptr<Paint> field_paint(const ColorField& field, double repeat, const Placement& placement,
                                   bool layer) {
  return std::make_unique<FieldPaint>(field, repeat, placement, layer);
}

std::unique_ptr<Paint> particle_paint(const Particles& particles, const Shapes& shapes, double repeat,
                                      const Placement& placement, const residual::ResidualField* residual) {
  return std::make_unique<ParticlePaint>(particles, shapes, repeat, placement, residual);
}

}  // namespace terrazzo::carving
