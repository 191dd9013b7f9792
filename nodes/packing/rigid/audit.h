// The independent check of a packing: exact on triangles, sharing no code with the contact search.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::packing {

struct Penetration {
  std::int32_t a, b;  // particles
  double depth;       // mm
  double relative;    // depth relative to the size of the smaller particle
};

struct AuditResult {
  std::vector<Penetration> found;  // ordered by a, then b
  double worst = 0;                // largest `relative`
  std::size_t pairs = 0;           // number of neighbors tested
  std::size_t tests = 0;           // work done, in about the unit of the contact search (Budget)
};

// Tests every pair of particles whose bounding spheres meet, in all periodic images: triangles against
// triangles through one BVH per shape, then containment of one in the other. The depth of a pair is the
// larger of two exact measures: the depth of a vertex or triangle center of one inside the other, and the
// shortest translation that separates two intersecting triangles. Bodies closer than `gap` (mm) count as
// penetrating by the difference. Between calls it remembers the pairs, and does not test again those of which
// neither particle has moved.
class Auditor {
 public:
  struct Solid;                            // a shape's BVH
  explicit Auditor(const Shapes& shapes);  // keeps a reference
  ~Auditor();
  AuditResult operator()(const Particles& particles, double gap = 0, const Work& work = {});

 private:
  const Shapes& shapes_;
  std::vector<std::unique_ptr<Solid>> solids_;  // of the shapes used so far
  Particles last_;                              // as of the last call
  double last_gap_ = 0;
  std::vector<Penetration> last_found_;
};

// A single audit.
AuditResult audit(const Shapes& shapes, const Particles& particles, double gap = 0, const Work& work = {});

}  // namespace terrazzo::packing
