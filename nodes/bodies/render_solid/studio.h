// The light for rendering solids: a pale dome, one large soft lamp, a pale floor. All of it is neutral, so
// that a gray solid stays gray, and scaled so that a white surface facing up is white: radiances are in units
// of the light reflected by an unshadowed white floor.
#pragma once

#include <array>

#include "nodes/data/linear.h"

namespace terrazzo::render_solid {

class Studio {
 public:
  struct Settings {
    float lamp_share = 0.65f;      // fraction of the light on a surface facing up
    float lamp_azimuth = -1.67f;   // radians from +x towards +y
    float lamp_elevation = 0.95f;  // radians
    float lamp_sharpness = 30;  // κ of the lamp's von Mises–Fisher lobe: its radius is about 1/√κ radians
    float horizon = 0.85f, zenith = 1.15f;  // the dome's radiance, relative
    float floor = 0.34f;                    // radiance of the unshadowed floor as a light on the solid
    float background = 0.82f;               // radiance of the unshadowed floor as seen by the camera
    bool has_floor = true;  // else the dome continues below with radiance `floor`, and nothing is shadowed
  };
  explicit Studio(const Settings&);
  // Radiance 1 from all directions, without lamp and floor: a convex body then shows exactly its albedo.
  static Studio furnace();

  const Settings& settings() const { return settings_; }
  // Irradiance over π of an unoccluded surface, including the lamp.
  float irradiance(const Vec3f& normal) const;
  // Radiance from a direction, without the lamp; the floor is unshadowed.
  float radiance(const Vec3f& direction) const {
    return direction.z() < 0 ? settings_.floor : horizon_ + (zenith_ - horizon_) * direction.z();
  }
  // Radiance including the lamp, for mirror reflections.
  float mirrored(const Vec3f& direction) const;
  // A direction to the lamp, distributed like its light. A surface receives lamp() · cos θ from it
  // (irradiance over π).
  Vec3f to_lamp(float u, float v) const;
  float lamp() const { return lamp_; }

 private:
  Settings settings_;
  Vec3f direction_, across_, along_;  // to the lamp, and two perpendicular directions
  float lamp_ = 0, horizon_ = 0, zenith_ = 0, tail_ = 0;
  static constexpr int kSteps = 256;
  std::array<float, kSteps + 1> by_height_{};  // dome and floor, over the normal's z from −1 to 1
  std::array<float, kSteps + 1> by_angle_{};   // lamp, over the cosine between the normal and its middle
};

// A cosine-distributed direction around the unit `normal`.
Vec3f cosine_direction(const Vec3f& normal, float u, float v);

}  // namespace terrazzo::render_solid
