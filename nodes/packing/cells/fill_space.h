// From a distribution and shapes to particles that fill space, by a Laguerre tessellation or by growth.
#pragma once

#include <functional>

#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/packing/cells/laguerre.h"
#include "nodes/packing/rigid/population/population.h"

namespace terrazzo::tessellation {

enum class Method { Laguerre, Grow };
enum class CrystalAxes { None, Uniform, Fiber };

// Growth of this many particles takes about 50 s on two cores and 1.3 GB.
inline constexpr std::int64_t kMostGrown = 25'000;

// At most a minute on two cores, mostly less.
inline constexpr double kUsualEffort = 5e10;

struct FillOptions {
  Method method = Method::Laguerre;
  packing::PopulationOptions population;
  LaguerreOptions grains;       // growth uses only gap (nothing: 0), gap_variation and roundness
  double start_fraction = 0.6;  // largest volume fraction at which growth begins
  int iterations = 600;         // of packing before growth
  int corrections = 2;          // see section_fit.h
  CrystalAxes axes = CrystalAxes::None;
  double spread = 10;            // of a fiber's axes about z, degrees
  double effort = kUsualEffort;  // see Effort
  // Called if the filling is canceled, before Cancelled is thrown: with the last complete result (`grown`),
  // or with particles of the given shapes that are packed but not grown yet. Not called if there is neither.
  std::function<void(const Particles&, const Shapes&, bool grown)> interrupted;
};

struct FillResult {
  Particles particles;  // shape i belongs to particle i, at scale 1
  Shapes shapes;
  std::vector<int> size_class;
  std::vector<double> wanted;    // volume of each particle, mm³
  std::vector<double> expected;  // particles of each size class
  double requested_fraction = 0, fraction = 0;
  double left_out_fraction = 0;  // the part of the request that is left to the binder; see Population
  double worst = 0;              // largest relative error of a volume, apart from a common factor
  double mean_error = 0;         // mean of the same
  double gap = 0;                // mean thickness of the binder between neighbors, mm
  double roundness = 0;          // of edges, before those without room for it became sharper
  double faces = 0;              // mean number of faces (Laguerre)
  double flat = 0;               // share of the surface that is flat contact (growth)
  double packed_fraction = 0;    // where growth began
  // Misfit of profile sizes between the sections of the result and those that the distribution stands for: at
  // first, after corrections, and what one section of the box would have by chance.
  double misfit_before = 0, misfit_after = 0, misfit_by_chance = 0;
  double effort = 0;  // used, as a share of the limit; 1 or more: something ended early
  std::vector<std::string> notes;
};

// Throws the errors of populate() and laguerre_grains(), and Error "open-mesh" if a grain is not closed.
FillResult fill_space(const SizeDistribution& distribution, const Shapes& shapes, const FillOptions& options,
                      const Work& work = {});

// One row per particle: class, wanted and actual volume, size, surface, mean caliper diameter, sphericity.
Table particle_table(const Shapes& shapes, const Particles& particles, const std::vector<double>& wanted);
Image fill_figure(const SizeDistribution& distribution, const FillResult& result);

}  // namespace terrazzo::tessellation
