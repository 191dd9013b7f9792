#include "nodes/export/regions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"

namespace terrazzo::exporting {
namespace {

// Number of voxels of each particle at its index, and of the binder last.
std::vector<std::size_t> count_voxels(const VoxelSource& id, const VoxelBox& box, const Work& work) {
  std::vector<std::size_t> voxels;
  std::size_t binder = 0;
  std::vector<std::int32_t> plane(box.plane());
  for (int z = 0; z < box.size.z(); ++z) {
    work.check();
    work.progress(double(z) / box.size.z());
    id.read(z, z + 1, plane.data());
    for (const std::int32_t v : plane) {
      if (v < 0) {
        ++binder;
        continue;
      }
      if (static_cast<std::size_t>(v) >= voxels.size()) {
        constexpr std::int32_t kMost = 100'000'000;
        if (v > kMost)
          throw Error("too-many-labels",
                      fmt::format("the grid id contains {}; at most {} is supported", v, kMost));
        voxels.resize(std::max<std::size_t>(voxels.size() * 2, static_cast<std::size_t>(v) + 1));
      }
      ++voxels[v];
    }
  }
  while (!voxels.empty() && voxels.back() == 0) voxels.pop_back();
  voxels.push_back(binder);
  return voxels;
}

}  // namespace

std::string Region::name() const {
  switch (is) {
    case Is::Binder:
      return "BINDER";
    case Is::Particle:
      return "PARTICLE_" + std::to_string(particle);
    case Is::Void:
      return particle < 0 ? "VOIDS" : "VOID_" + std::to_string(particle);
    case Is::Phase:
      return "PHASE_" + std::to_string(cls);
  }
  return {};
}

Regions find_regions(const VoxelSource& id, const VoxelBox& box, const Particles* particles, RegionKind kind,
                     const Work& work) {
  if (!id.whole() || id.components() != 1)
    throw Error("no-id", "the grid id does not contain whole numbers", "connect Voxelize.volume");
  if (kind == RegionKind::Phases && !particles)
    throw Error("missing-input", "phases are the classes of particles, but particles is not connected",
                "connect particles, or set regions: particles")
        .parameter("regions");
  const auto voxels = count_voxels(id, box, work);
  const std::size_t seen = voxels.size() - 1;
  if (particles && seen > particles->count())
    throw Error("size-mismatch",
                fmt::format("the grid id contains particle {}, but there are only {} particles", seen - 1,
                            particles->count()),
                "connect the particles from which the volume was made");
  const auto is_void = [&](std::size_t p) { return particles && particles->is_void(p); };
  std::int32_t last_class = 0;  // of solid particles
  if (particles)
    for (std::size_t p = 0; p < particles->count(); ++p) {
      if (is_void(p)) continue;
      constexpr std::int32_t kMostClasses = 65536;
      if (particles->cls[p] < 0 || particles->cls[p] >= kMostClasses)
        throw Error("bad-particles", fmt::format("particle {} has the class {}; classes are 0 to {}", p,
                                                 particles->cls[p], kMostClasses - 1));
      last_class = std::max(last_class, particles->cls[p]);
    }
  Regions out;
  out.all.push_back({.voxels = voxels.back()});
  if (kind == RegionKind::Phases) {
    for (std::int32_t c = 0; c <= last_class; ++c)
      out.all.push_back({.is = Region::Is::Phase, .cls = c, .phase = 1 + c});
    if (particles->void_count() > 0) out.all.push_back({.is = Region::Is::Void, .phase = 2 + last_class});
  }
  for (std::size_t p = 0; p < seen; ++p) {
    const std::int32_t index = p;
    const std::int32_t cls = particles ? particles->cls[p] : -1;
    const std::int32_t phase = is_void(p) ? 2 + last_class : particles ? 1 + cls : 1;
    out.phase_number.push_back(phase);
    if (kind == RegionKind::Phases) {
      out.of_particle.push_back(phase);
      out.all[phase].voxels += voxels[p];
    } else if (voxels[p] == 0) {
      out.of_particle.push_back(-1);
    } else {
      out.of_particle.push_back(out.all.size());
      out.all.push_back({is_void(p) ? Region::Is::Void : Region::Is::Particle, index, cls, phase, voxels[p]});
    }
  }
  return out;
}

Regions selected_regions(const Regions& regions, const std::function<bool(const Region&)>& keep) {
  Regions out = regions;
  out.all.clear();
  std::vector<std::int32_t> number(regions.all.size(), 0);
  for (std::size_t r = 0; r < regions.all.size(); ++r)
    if (keep(regions.all[r])) {
      number[r] = out.all.size();
      out.all.push_back(regions.all[r]);
    }
  for (std::int32_t& n : out.of_particle)
    if (n >= 0) n = number[n];
  return out;
}

Table region_table(const Regions& regions, const VoxelBox& box, const Particles* particles) {
  Table table;
  table.columns = {"number",
                   "name",
                   "kind",
                   "particle",
                   "class",
                   "phase",
                   "voxels",
                   "volume mm³",
                   "fraction",
                   "size mm",
                   "equivalent diameter mm",
                   "color_r",
                   "color_g",
                   "color_b"};
  const double voxel = box.spacing.prod();
  for (std::size_t n = 0; n < regions.all.size(); ++n) {
    const Region& r = regions.all[n];
    const char* kind = r.is == Region::Is::Binder  ? "binder"
                       : r.is == Region::Is::Void  ? "void"
                       : r.is == Region::Is::Phase ? "phase"
                                                   : "particle";
    std::vector<Table::Cell> row;
    row.reserve(table.columns.size());
    const auto add = [&](double v, bool known = true) {
      if (known)
        row.emplace_back(v);
      else
        row.emplace_back(std::string());
    };
    add(double(n));
    row.emplace_back(r.name());
    row.emplace_back(std::string(kind));
    add(r.particle, r.particle >= 0);
    add(r.cls, r.cls >= 0);
    add(r.phase);
    add(double(r.voxels));
    add(double(r.voxels) * voxel);
    add(double(r.voxels) / double(box.count()));
    const bool one = particles && r.particle >= 0;
    add(one ? particles->size[r.particle] : 0, one);
    add(std::cbrt(6 / std::numbers::pi * double(r.voxels) * voxel), r.particle >= 0);
    const bool colored = particles && (one || r.is == Region::Is::Binder);
    Vec3f color = Vec3f::Zero();
    if (colored) color = one ? particles->color[r.particle] : particles->binder_color;
    for (int k = 0; k < 3; ++k) add(color[k], colored);
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace terrazzo::exporting
