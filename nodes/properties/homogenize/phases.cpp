#include "nodes/properties/homogenize/phases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "graph/diagnostic.h"
#include "runtime/memory.h"

namespace terrazzo::homogenize {
namespace {

std::string chosen_grid(const Volume& volume, const std::string& name) {
  const auto all = grid_names(volume);
  const auto has = [&](const std::string& n) { return std::find(all.begin(), all.end(), n) != all.end(); };
  if (!name.empty()) {
    if (has(name)) return name;
    throw Error("no-such-grid",
                fmt::format("the volume has no grid '{}' (its grids: {})", name, fmt::join(all, ", ")),
                "choose one of them")
        .parameter("grid");
  }
  for (const char* usual : {"phase", "id", "density"})
    if (has(usual)) return usual;
  if (all.size() == 1) return all[0];
  throw Error(
      "several-grids",
      fmt::format("the volume has no grid phase, id or density (its grids: {})", fmt::join(all, ", ")),
      "name one of them with grid")
      .parameter("grid");
}

// The values of planes z0 … z1 − 1 as numbers.
void read_planes(const VoxelSource& source, int z0, int z1, std::vector<std::int32_t>& whole,
                 std::vector<float>& real) {
  if (!source.whole() && !source.yes_no()) return source.read(z0, z1, real.data());
  source.read(z0, z1, whole.data());
  std::copy(whole.begin(), whole.end(), real.begin());
}

// Calls visit(first voxel, values) for ranges of planes, on all threads.
template <class Visit>
void each_range(const VoxelSource& source, const VoxelBox& box, const Work& work, Visit&& visit) {
  work.parallel(box.size.z(), 4, [&](std::size_t begin, std::size_t end) {
    const std::size_t count = (end - begin) * box.plane();
    std::vector<std::int32_t> whole(source.whole() || source.yes_no() ? count : 0);
    std::vector<float> values(count);
    read_planes(source, begin, end, whole, values);
    visit(begin * box.plane(), values);
  });
}

// What the numbers of a grid mean.
struct Legend {
  std::vector<std::string> names;
  std::map<float, std::uint8_t> of_number;  // if the phases are numbers
  std::vector<std::uint8_t> of_particle;    // if they are classes of particles
  bool inside_outside = false;              // if the grid is a level set or a coverage
  bool level_set = false;
};

std::string too_many() { return fmt::format("more than {} different numbers", kMostPhases); }

// The numbers that occur, at most kMostPhases + 1 of them.
std::map<float, std::uint8_t> numbers_of(const VoxelSource& source, const VoxelBox& box, const Work& work) {
  std::map<float, std::uint8_t> all;
  std::vector<std::vector<float>> found((box.size.z() + 3) / 4);
  each_range(source, box, work, [&](std::size_t first, const std::vector<float>& values) {
    std::vector<float>& mine = found[first / box.plane() / 4];
    float last = std::numeric_limits<float>::quiet_NaN();
    for (const float v : values) {
      if (v == last) continue;
      last = v;
      const auto at = std::lower_bound(mine.begin(), mine.end(), v);
      if (at != mine.end() && *at == v) continue;
      if (mine.size() <= kMostPhases) mine.insert(at, v);
    }
  });
  for (const auto& part : found)
    for (const float v : part)
      if (all.size() <= kMostPhases) all.emplace(v, 0);
  return all;
}

Legend legend_of_particles(const Particles& particles) {
  Legend out;
  out.names.push_back("binder");
  std::map<std::int32_t, std::uint8_t> slot;
  for (std::size_t i = 0; i < particles.count(); ++i)
    if (!particles.is_void(i)) slot.emplace(particles.cls[i], 0);
  if (slot.size() + 2 > kMostPhases)
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
  Legend out;
  out.level_set = source.level_set();
  auto numbers = numbers_of(source, box, work);
  const bool negative = numbers.begin()->first < 0,
             fractions = std::any_of(
                 numbers.begin(), numbers.end(), [](const auto&n) { return n.first != std::round(n.first); });
  if (out.level_set || (fractions && !negative && numbers.rbegin()->first <= 1)) {
    out.inside_outside = true;
    out.names = {"outside", "inside"};
    return out;
  }
  if (fractions)
    throw Error(
        "not-phases",
        fmt::format(
            "grid '{}' contains fractions such as {:.6g}, so it is neither phases nor a coverage from 0 to 1",
            source.name(),
            std::find_if(numbers.begin(), numbers.end(),
                         [](const auto& n) { return n.first != std::round(n.first); })
                ->first),
        "segment it into phases first")
        .parameter("grid");
  if (expected == 2 && negative) {
    out.inside_outside = true;
    out.names = {"binder", "particles"};
    return out;
  }
  if (numbers.size() > kMostPhases)
    throw Error("too-many-phases", fmt::format("grid '{}' contains {}", source.name(), too_many()),
                "give two values, for the binder and the particles, or connect the particles, whose classes "
                "become the "
                "phases")
        .parameter("grid");
  for (auto& [number, slot] : numbers) {
    slot = out.names.size();
    out.names.push_back(fmt::format("{}", number));
  }
  out.of_number = std::move(numbers);
  return out;
}

std::uint8_t phase_of(const Legend& legend, float v, bool labels) {
  if (legend.inside_outside) return legend.level_set ? v < 0 : labels ? v >= 0 : v >= 0.5F;
  if (legend.of_particle.empty()) return legend.of_number.at(v);
  return v < 0 ? 0 : legend.of_particle[static_cast<std::size_t>(v)];
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
  const VoxelSource source(volume, chosen_grid(volume, name), out.box);
  if (source.components() != 1)
    throw Error("not-a-scalar", fmt::format("grid '{}' contains vectors", source.name()),
                "choose a grid of single numbers")
        .parameter("grid");
  require_memory(out.box.count(), memory, "the phases of the volume");
  const bool labels = source.whole() && !source.yes_no();
  if (particles && !labels)
    throw Error("missing-input", fmt::format("grid '{}' has no indices of particles", source.name()),
                "connect the volume of Voxelize, or disconnect the particles");
  const Legend legend =
      particles ? legend_of_particles(*particles) : legend_of_numbers(source, out.box, expected, work);
  out.names = legend.names;
  out.phase.resize(out.box.count());
  each_range(source, out.box, work, [&](std::size_t first, const std::vector<float>& values) {
    float last = std::numeric_limits<float>::quiet_NaN();
    std::uint8_t phase = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] != last) {
        last = values[i];
        if (particles && last >= static_cast<float>(particles->count()))
          throw Error("size-mismatch",
                      fmt::format("the grid {} contains particle {}, but there are only {} particles",
                                  source.name(), last, particles->count()),
                      "connect the particles from which the volume was made");
        phase = phase_of(legend, last, labels);
      }
      out.phase[first + i] = phase;
    }
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
    for (int z = begin; z < static_cast<int>(end); ++z)
      for (int y = 0; y < m.y(); ++y)
        for (int x = 0; x < m.x(); ++x)
          out.phase[voxel_at(x, y, z, m)] = map.phase[voxel_at(source(x, 0), source(y, 1), source(z, 2), n)];
  });
  set_fractions(out);
  return out;
}

}  // namespace terrazzo::homogenize
