#include "nodes/packing/measure3d/raster.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/coverage.h"
#include "nodes/common/geometry/grid/grid_choice.h"
#include "runtime/memory.h"

namespace terrazzo::measure3d {
namespace {

// The values of planes z0 … z1 − 1. Distances become coverages; `voxel`: mean edge of a voxel, mm.
std::vector<float> read_values(const VoxelSource& source, int z0, int z1, std::size_t plane, double voxel) {
  std::vector<float> values;
  if (source.yes_no()) {
    std::vector<std::int32_t> flags((z1 - z0) * plane);
    source.read(z0, z1, flags.data());
    values.assign(flags.begin(), flags.end());
  } else {
    values.resize((z1 - z0) * plane);
    source.read(z0, z1, values.data());
  }
  if (source.level_set())
    for (float& v : values) v = coverage_of(v, voxel);
  return values;
}

}  // namespace

Raster read_raster(const Volume& volume, const std::string& name, const Particles* particles, Phase phase,
                   std::optional<double> threshold, std::uint64_t memory, const Work& work) {
  Raster out;
  out.box = voxel_box(volume);
  const VoxelSource source(volume, grid_to_read(volume, name, {"id", "density"}), out.box);
  if (source.components() != 1)
    throw Error("not-a-scalar", fmt::format("grid '{}' contains vectors", source.name()),
                "choose a grid of single numbers")
        .parameter("grid");
  const bool labels = source.whole() && !source.yes_no();
  const double least = threshold.value_or(labels ? 0 : 0.5);
  if (phase == Phase::Voids && !(labels && particles))
    throw Error("missing-input", "voids are known only from labels and the particles they belong to",
                "connect particles, and a volume with the grid id")
        .parameter("phase");
  require_memory(static_cast<double>(out.box.count()) * (labels ? 5 : 1), memory, "the voxels of the volume");
  out.in.resize(out.box.count());
  if (labels) out.ids.resize(out.box.count());
  const std::size_t plane = out.box.plane();
  const double voxel = std::cbrt(out.box.spacing.prod());
  using Sum = std::pair<std::size_t, std::int32_t>;  // voxels in the phase, largest label
  const Sum sum = work.reduce<Sum>(
      out.box.size.z(), 4, {0, -1},
      [&](std::size_t begin, std::size_t end) {
        Sum part{0, -1};
        std::vector<float> values;
        if (labels)
          source.read(begin, end, out.ids.data() + begin * plane);
        else
          values = read_values(source, begin, end, plane, voxel);
        for (std::size_t i = begin * plane; i < end * plane; ++i) {
          bool in = false;
          if (labels) {
            std::int32_t& id = out.ids[i];
            if (id < least) id = -1;
            part.second = std::max(part.second, id);
            const bool hole = particles && id >= 0 && static_cast<std::size_t>(id) < particles->count() &&
                              particles->is_void(id);
            in = phase == Phase::Binder ? id < 0 : id >= 0 && hole == (phase == Phase::Voids);
          } else {
            in = (values[i - begin * plane] >= least) == (phase == Phase::Particles);
          }
          out.in[i] = in;
          part.first += in;
        }
        return part;
      },
      [](Sum a, const Sum& b) { return Sum(a.first + b.first, std::max(a.second, b.second)); });
  out.inside = sum.first;
  if (particles && labels && sum.second >= 0 && static_cast<std::size_t>(sum.second) >= particles->count())
    throw Error("size-mismatch",
                fmt::format("the grid {} contains particle {}, but there are only {} particles",
                            source.name(), sum.second, particles->count()),
                "connect the particles from which the volume was made");
  return out;
}

}  // namespace terrazzo::measure3d
