// The surface that a finish leaves of a plane through a packing, column by column.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "nodes/bodies/carving/particle_index.h"
#include "nodes/bodies/carving/ray_scene.h"
#include "nodes/bodies/cutting/planes.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/textures/texture_set/broken_face.h"

namespace terrazzo::texture_set {

// In the order of the parameter's words.
enum class FinishKind { Polished, Honed, Broken, Weathered, Loose };

struct Finish {
  FinishKind kind = FinishKind::Polished;
  // mm. Honed, weathered: how far the binder is worn below the plane; if negative, the particles. Broken:
  // standard deviation of the face in the binder.
  double relief = 0;
  double grain = 1;  // mm, mean size of the particles, the scale of a broken face
  std::uint64_t seed = 1;
};

// Every material is worn down to a level below the plane: the surface is the highest point of a column that
// no level removes. Polished: one plane. Honed and weathered: the softer material lies lower, and particles
// below the plane emerge. Broken: the level of the binder is a rough face; particles whose center is below it
// stay whole, others leave sockets. Loose: particles whose center is below the plane, alone. Voids are open.
class FinishedSurface {
 public:
  // The layout has one plane, which is a tile. Throws the errors of carving::check_shown.
  FinishedSurface(const Particles&, const Shapes&, const section::SectionLayout&, const Finish&,
                  const Work& = {});

  struct Point {
    float height = 0;            // mm above the plane
    std::int32_t particle = -1;  // at the surface; −1: binder
    bool worn = true;            // by the finish; else a natural surface, such as the wall of a void
  };
  // At (u, v) of the plane's window, mm.
  Point at(double u, double v) const;

 private:
  void find_depths(const Shapes&);
  void add_images(const Shapes&, const Work&);
  double level(int particle, double height, double face) const;
  // Height of the nearest surface below (u, v, from); −∞ without one.
  double next_below(const carving::RayScene*, const Vec3& foot, double from) const;

  const Particles& particles_;
  section::SectionPlane plane_;
  double width_, height_;
  Finish finish_;
  carving::ParticleIndex index_;
  std::optional<BrokenFace> face_;
  std::vector<double> center_;   // of each particle, mm above the plane
  std::vector<double> face_at_;  // height of a broken face or the plane at each particle's center
  std::vector<double> radius_;   // of each particle
  double top_ = 0, bottom_ = 0;  // mm, of the columns
  double period_ = 1;            // along the plane's normal
  float unit_ = 1;               // mm per world unit of the scenes
  std::unique_ptr<carving::RayScene> scene_;  // null if nothing but the plane can be seen
  std::unique_ptr<carving::RayScene> whole_;  // the particles that stay whole
};

}  // namespace terrazzo::texture_set
