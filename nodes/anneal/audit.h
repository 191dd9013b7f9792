// The independent check of a packing: exact on triangles, sharing nothing with the contact code that made it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::anneal {

struct Penetration {
  std::int32_t a, b;  // particles
  double depth;       // mm
  double relative;    // of the smaller one's size
};

struct AuditResult {
  std::vector<Penetration> found;  // in the order of a, then b
  double worst = 0;                // largest `relative`
  std::size_t pairs = 0;           // neighbours that were tested
};

// Every pair of particles whose bounding balls meet, in all periodic images: triangles against triangles
// through a box tree a shape, then containment of one in the other. The depth of a pair is the largest of two
// exact measures: how deep a vertex or a triangle's centre of one lies inside the other, and the least
// translation that parts two crossing triangles. Bodies nearer to each other than `gap` (mm) count as
// penetrating by what is missing.
class Auditor {
 public:
  struct Solid;                            // a shape's box tree
  explicit Auditor(const Shapes& shapes);  // keeps a reference
  ~Auditor();
  AuditResult operator()(const Particles& particles, double gap = 0, const Work& work = {});

 private:
  const Shapes& shapes_;
  std::vector<std::unique_ptr<Solid>> solids_;  // of the shapes met so far
};

// Once.
AuditResult audit(const Shapes& shapes, const Particles& particles, double gap = 0, const Work& work = {});

}  // namespace terrazzo::anneal
