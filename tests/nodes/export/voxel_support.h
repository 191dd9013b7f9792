// A small volume of which every value is known.
#pragma once

#include "nodes/data/particles.h"
#include "nodes/data/volume.h"

namespace terrazzo::test {

// −1 (binder) and 0 to 6, in no simple order. Particle 4 has no voxel.
inline std::int32_t formula_id(int x, int y, int z) {
  const int v = (7 * x + 3 * y + 5 * z) % 8 - 1;
  return v == 4 ? -1 : v;
}
inline float formula_density(int x, int y, int z) { return static_cast<float>(x + 0.25 * y - 2 * z); }

// A periodic volume of 6 × 5 × 4 voxels of 0.25 mm: id (int32), density (float), Cd (vec3s), source (vec3i).
inline Volume formula_volume() {
  initialize_openvdb();
  Volume v;
  v.resolution = Vec3i(6, 5, 4);
  auto id = openvdb::Int32Grid::create(-1);
  auto density = openvdb::FloatGrid::create(0);
  auto color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  auto source = openvdb::Vec3IGrid::create(openvdb::Vec3i(0));
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x) {
        const openvdb::Coord at(x, y, z);
        if (formula_id(x, y, z) >= 0) id->tree().setValue(at, formula_id(x, y, z));
        density->tree().setValue(at, formula_density(x, y, z));
        color->tree().setValue(at, openvdb::Vec3s(0.5f, 0.25f * float(x), float(z)));
        source->tree().setValue(at, openvdb::Vec3i(x, y, z));
      }
  id->setName("id");
  density->setName("density");
  color->setName("Cd");
  source->setName("source");
  for (const openvdb::GridBase::Ptr& g : {openvdb::GridBase::Ptr(id), openvdb::GridBase::Ptr(density),
                                          openvdb::GridBase::Ptr(color), openvdb::GridBase::Ptr(source)})
    g->setTransform(voxel_transform(0.25)), v.grids.push_back(g);
  return v;
}

// The seven particles of that volume: classes 0, 1, 2, 0, …; particle 3 is a void.
inline Particles formula_particles() {
  Particles p;
  p.box = Vec3(1.5, 1.25, 1);
  p.resize(7);
  for (int i = 0; i < 7; ++i) {
    p.cls[i] = i % 3;
    p.size[i] = 0.5;
  }
  p.voids.assign(7, 0);
  p.voids[3] = 1;
  return p;
}

}  // namespace terrazzo::test
