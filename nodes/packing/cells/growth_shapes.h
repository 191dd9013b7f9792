// The shapes that particles have before they grow, with few enough triangles.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::tessellation {

struct GrowthShape {
  Mesh mesh;
  std::vector<Vec3> outposts;  // its farthest vertices along many directions
};

// Each particle gets a mesh of its own, so the shapes are simplified: within 0.5 % of their size. Those below
// half the largest size get meshes that are only as fine as those of this size, in mm: within 1, 2 or 4 % of
// their own. If all particles together would have more than `most` triangles, those below a larger size do:
// the smallest one that keeps the limit.
class GrowthShapes {
 public:
  static constexpr double kMost = 2.5e6;

  void prepare(const Shapes&, const Particles&, const Work& work = {}, double most = kMost);
  const GrowthShape& of(std::size_t particle) const { return *of_[particle]; }
  std::size_t triangles() const;  // of all particles

 private:
  std::map<std::pair<std::int32_t, int>, GrowthShape> prepared_;  // by shape and level of detail; kept
  std::vector<const GrowthShape*> of_;

  void make_finest(const Shapes&, const Particles&, const Work&);
  const GrowthShape& at(const Shapes&, std::int32_t shape, int level, const Work&);
  void assign(const Shapes&, const Particles&, double fine, const Work&);
};

}  // namespace terrazzo::tessellation
