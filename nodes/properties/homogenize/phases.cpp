#include "nodes/properties/homogenize/phases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/grid_choice.h"
#include "runtime/memory.h"

namespace terrazzo::homogenize {
namespace {

std::vector<std::string> usual_grids(bool of_particles) {
  return of_particles ? std::vector<std::string>{"id"} : std::vector<std::string>{"phase", "id", "density"};
}

// Calls visit(first voxel, values) for each plane, on all threads.
template <class Visit>
void each_plane(const VoxelSource& source, const VoxelBox& box, const Work& work, Visit&& visit) {
  const bool whole = source.whole() || source.yes_no();
  work.parallel(box.size.z(), 1, [&](std::size_t z, std::size_t) {
    std::vector<std::int32_t> numbers(whole ? box.plane() : 0);
    std::vector<double> values(box.plane());
    if (whole) {
      source.read(z, z + 1, numbers.data());
      std::copy(numbers.begin(), numbers.end(), values.begin());
    } else {
      std::vector<float> real(box.plane());
      source.read(z, z + 1, real.data());
      std::copy(real.begin(), real.end(), values.begin());
    }
    visit(z, values);
  });
}

enum class Meaning {
  Phases,     // each number is a phase
  Particles,  // indices of particles, whose classes are the phases
  Labels,     // negative numbers are the binder, the others particles
  Coverage,   // inside from one half on
  LevelSet,   // inside where negative
};

struct Legend {
  Meaning meaning = Meaning::Phases;
  std::vector<std::string> names;
  std::map<double, std::uint8_t> of_number;
  std::vector<std::uint8_t> of_particle;
};

// What occurs in a grid.
struct Numbers {
  double least = INFINITY, most = -INFINITY;
  std::optional<double> fraction;  // one that is not whole
  std::set<double> some;           // all, or kMostPhases + 1 of them

  void add(double v) {
    least = std::min(least, v);
    most = std::max(most, v);
    if (!fraction && v != std::round(v)) fraction = v;
    if (some.size() <= kMostPhases) some.insert(v);
  }
};

Numbers numbers_of(const VoxelSource& source, const VoxelBox& box, const Work& work) {
  std::vector<Numbers> planes(box.size.z());
  each_plane(source, box, work, [&](std::size_t z, const std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (i == 0 || values[i] != values[i - 1]) planes[z].add(values[i]);
  });
  Numbers out;
  for (const Numbers& plane : planes) {
    out.least = std::min(out.least, plane.least);
    out.most = std::max(out.most, plane.most);
    if (!out.fraction) out.fraction = plane.fraction;
    for (const double v : plane.some)
      if (out.some.size() <= kMostPhases) out.some.insert(v);
  }
  return out;
}

Legend legend_of_particles(const Particles& particles) {
  Legend out;
  out.meaning = Meaning::Particles;
  out.names.push_back("binder");
  std::map<std::int32_t, std::uint8_t> slot;
  for (std::size_t i = 0; i < particles.count(); ++i)
    if (!particles.is_void(i)) slot.emplace(particles.cls[i], 0);
  if (slot.size() + 1 + (particles.void_count() > 0) > kMostPhases)
    throw Error("too-many-phases",
                fmt::format("the particles have {} classes; at most {} phases are supported", slot.size(),
                            kMostPhases),
                "use fewer classes");
  for (auto& [cls, number] : slot) {
    number = out.names.size();
    out.names.push_back(fmt::format("class {}", cls));
  }
  const std::uint8_t hole = out.names.size();
  if (particles.void_count() > 0) out.names.push_back("void");
  for (std::size_t i = 0; i < particles.count(); ++i)
    out.of_particle.push_back(particles.is_void(i) ? hole : slot[particles.cls[i]]);
  return out;
}

Legend legend_of_numbers(const VoxelSource& source, const VoxelBox& box, std::size_t expected,
                         const Work& work) {
  if (source.level_set()) return {Meaning::LevelSet, {"outside", "inside"}, {}, {}};
  const Numbers numbers = numbers_of(source, box, work);
  if (numbers.fraction && numbers.least >= 0 && numbers.most <= 1)
    return {Meaning::Coverage, {"outside", "inside"}, {}, {}};
  if (numbers.fraction)
    throw Error(
        "not-phases",
        fmt::format(
            "grid '{}' contains numbers from {:.6g} to {:.6g}, such as {:.6g}, so it is neither phases "
            "nor a coverage from 0 to 1",
            source.name(), numbers.least, numbers.most, *numbers.fraction),
        "segment it into phases first")
        .parameter("grid");
  if (expected == 2 && numbers.least < 0) return {Meaning::Labels, {"binder", "particles"}, {}, {}};
  if (numbers.some.size() > kMostPhases)
    throw Error(
        "too-many-phases",
        fmt::format("grid '{}' contains more than {} different numbers", source.name(), kMostPhases),
        "give two values, for the binder and the particles, or connect the particles, whose classes become "
        "the phases")
        .parameter("grid");
  Legend out;
  for (const double v : numbers.some) {
    out.of_number.emplace(v, out.names.size());
    out.names.push_back(fmt::format("{}", v));
  }
  return out;
}

std::uint8_t phase_of(const Legend& legend, double v, const std::string& grid) {
  switch (legend.meaning) {
    case Meaning::Labels:
      return v >= 0;
    case Meaning::Coverage:
      return v >= 0.5;
    case Meaning::LevelSet:
      return v < 0;
    case Meaning::Phases:
      return legend.of_number.at(v);
    case Meaning::Particles:
      break;
  }
  if (v < 0) return 0;
  const std::size_t i = v;
  if (i < legend.of_particle.size()) return legend.of_particle[i];
  throw Error("size-mismatch",
              fmt::format("the grid {} contains particle {}, but there are only {} particles", grid, i,
                          legend.of_particle.size()),
              "connect the particles from which the volume was made")
      .parameter("grid");
}

void set_fractions(PhaseMap& map) {
  std::vector<std::size_t> voxels(map.count(), 0);
  for (const std::uint8_t p : map.phase) ++voxels[p];
  map.fraction.clear();
  for (const std::size_t n : voxels) map.fraction.push_back(static_cast<double>(n) / map.phase.size());
}

}  // namespace

PhaseMap read_phases(const Volume& volume, const std::string& name, const Particles* particles,
                     std::size_t expected, std::uint64_t memory, const Work& work) {
  PhaseMap out;
  out.box = voxel_box(volume);
  const VoxelSource source(volume, grid_to_read(volume, name, usual_grids(particles != nullptr)), out.box);
  if (source.components() != 1)
    throw Error("not-a-scalar", fmt::format("grid '{}' contains vectors", source.name()),
                "choose a grid of single numbers")
        .parameter("grid");
  require_memory(out.box.count() + 256.0 * out.box.plane(), memory, "the phases of the volume");
  const bool labels = source.whole() && !source.yes_no();
  if (particles && !labels)
    throw Error("missing-input", fmt::format("grid '{}' has no indices of particles", source.name()),
                "connect the volume of Voxelize, or disconnect the particles")
        .parameter("grid");
  const Legend legend =
      particles ? legend_of_particles(*particles) : legend_of_numbers(source, out.box, expected, work);
  out.names = legend.names;
  out.phase.resize(out.box.count());
  each_plane(source, out.box, work, [&](std::size_t z, const std::vector<double>& values) {
    std::uint8_t* to = out.phase.data() + z * out.box.plane();
    for (std::size_t i = 0; i < values.size(); ++i)
      to[i] = i > 0 && values[i] == values[i - 1] ? to[i - 1] : phase_of(legend, values[i], source.name());
  });
  set_fractions(out);
  return out;
}

PhaseMap halved(const PhaseMap& map, const Work& work) {
  PhaseMap out;
  out.box = map.box;
  out.names = map.names;
  const Vec3i &n = map.box.size, m = (n.array() + 1) / 2;
  out.box.size = m;
  for (int a = 0; a < 3; ++a) out.box.spacing[a] *= static_cast<double>(n[a]) / m[a];
  out.phase.resize(voxels_in(m));
  const auto source = [&](int i, int a) { return std::min(n[a] - 1, round_down((i + 0.5) * n[a] / m[a])); };
  work.parallel(m.z(), 4, [&](std::size_t begin, std::size_t end) {
    for (int z = begin, stop = end; z < stop; ++z)
      for (int y = 0; y < m.y(); ++y)
        for (int x = 0; x < m.x(); ++x)
          out.phase[voxel_at(x, y, z, m)] = map.phase[voxel_at(source(x, 0), source(y, 1), source(z, 2), n)];
  });
  set_fractions(out);
  return out;
}

}  // namespace terrazzo::homogenize
