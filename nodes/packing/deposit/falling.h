// Rigid bodies that fall onto a floor at z = 0, in a space that is periodic in x and y (Bullet Physics).
#pragma once

#include <memory>
#include <vector>

#include "nodes/data/linear.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::packing {

// A mesh as Bullet sees it: a ball, or a body with few corners, as large as the convex hull of the mesh.
struct FallingShape {
  double radius = 0;          // of a ball, mm; 0: no ball
  std::vector<Vec3> corners;  // mm; at most 42
  double margin = 0;          // mm, around the hull of the corners
  double reach = 0;           // mm, from the origin to the farthest point

  // The mesh has its centroid at the origin. Throws Error "bad-shape" if it is too thin, and those of
  // convex_hull().
  explicit FallingShape(const Mesh&);
};

// Lengths in mm. The same calls give the same bits, whatever the number of threads.
class FallingBodies {
 public:
  // `period`: along x and y, above the largest body's diameter; `usual`: diameter of a usual body.
  FallingBodies(const Vec2& period, double usual);
  ~FallingBodies();

  // `scale`: of the shape. Bodies that overlap push each other away.
  void add(const FallingShape&, double scale, const Vec3& position, const Quat& orientation);
  // A sixtieth of the time in which a usual body falls by five of its diameters. Throws Cancelled soon after
  // the work is canceled.
  void step(const Work& = {});
  // From now on friction with the air slows the bodies down.
  void calm();

  // Root of the mean squared speed, in usual diameters per second of free fall with 10 diameters/s².
  double speed() const;
  double fastest() const;                 // of all bodies, in the same unit
  Vec3 position(std::size_t body) const;  // x and y in [0, period)
  Quat orientation(std::size_t body) const;

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace terrazzo::packing
