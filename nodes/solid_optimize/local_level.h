// Levels made in parts: each part is a function of the level below, of statistics fixed before, and of its
// place alone, so that it is the same whatever else is made, and in whatever order.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "nodes/solid_optimize/levels.h"
#include "nodes/solid_optimize/local_finish.h"
#include "nodes/solid_optimize/local_gl.h"

namespace terrazzo::solid_optimize {

// The finest level that is made whole, as by_coherence leaves it.
struct WholeLevel {
  int level = 0;
  std::vector<MatchFamily> families;
  SolidField field;
};

// Voxels of the level below whose patches the carried matches of a part come from.
LocalBox box_below(const LocalBox& part, const Vec3i& level, const Vec3i& below);
// Where a level's statistics are measured, the same whatever part is wanted: along short axes everywhere.
LocalBox probe_box(const Vec3i& level, const LocalLimits&);

class LocalLevels {
 public:
  // `iterations` of each level. All that is passed must outlive it. `gl` makes parts in its stead, but for
  // the finish.
  LocalLevels(const std::vector<SolidExemplar>& working, const std::vector<Pyramid>&, const SolidSettings&,
              const std::vector<int>& iterations, int channels, const WholeLevel&, LocalGl* gl = nullptr);

  // Fixes the statistics of all levels above the whole one. Once, before anything is made. Where the probe is
  // all of the finest level, that is made then, with `sources` as make() takes them.
  // The whole level's field is needed for this alone.
  std::optional<LocalRegion> measure(BlendSources* sources, const Work&);
  // Of each level; what was measured once will do for another object of the same exemplars and settings.
  const std::vector<LevelStatistics>& statistics() const { return statistics_; }
  void set_statistics(std::vector<LevelStatistics> s) { statistics_ = std::move(s); }
  // A part of the finest level. `sources` may be null; its arrays get the shape of the region's field.
  LocalRegion make(const LocalBox&, BlendSources* sources, const Work&) const;

 private:
  enum class Upto { Matches, Blend, Finish };
  // Matches of a level below another, and a field where a probe was asked for.
  struct Below {
    LocalLines lines;
    bool whole = false;  // it is whole_, and `made` is empty
    LocalRegion made;
    int patch(int axis, int number) const;
    int slice(int axis, int voxel) const;
  };

  Vec3i size(int level) const;
  // A part of a level. Where `core` is not null, `measured` gets what lies there, else it is null, too.
  LocalRegion run(int level, const LocalBox& wanted, Upto, const LevelStatistics&, LevelStatistics* measured,
                  const LocalBox* core, BlendSources* sources, const Work&) const;
  Below below(int level, const LocalBox& part, const LocalBox* core, const Work&) const;
  void carry(int level, const Below&, LocalRegion&, const Work&) const;
  // Of the values in the probe, per channel: after each blending, and after each round of the finish.
  struct Targets {
    std::vector<Quantiles> values, finished;
  };
  // The same place in the level below.
  LocalBox core_below(int level, const LocalBox& core) const;
  Targets targets_in(int level, const LocalBox& core, const Below&) const;

  LocalGl* gl_;
  const std::vector<SolidExemplar>& working_;
  const std::vector<Pyramid>& pyramids_;
  const SolidSettings& settings_;
  const std::vector<int>& iterations_;
  const WholeLevel& whole_;
  int levels_, channels_;
  std::vector<std::vector<std::vector<Quantiles>>> bands_;  // [exemplar][channel][band]
  std::vector<Quantiles> finished_;                         // [channel]: of all planes' exemplars
  std::vector<LevelStatistics> statistics_;                 // [level]
};

}  // namespace terrazzo::solid_optimize
