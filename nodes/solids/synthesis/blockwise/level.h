// Levels made in parts. A part depends only on the level below, on statistics fixed before, and on its place,
// so it is the same whatever else is made and in whatever order.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "nodes/solids/synthesis/blockwise/finish.h"
#include "nodes/solids/synthesis/blockwise/gl.h"
#include "nodes/solids/synthesis/whole/levels.h"

namespace terrazzo::solids {

// The finest level that is made whole, as by_coherence leaves it.
struct WholeLevel {
  int level = 0;
  std::vector<NeighborField> families;
  SolidField field;
};

// The voxels of the level below whose patches provide the carried matches of a part.
TorusBox box_below(const TorusBox& part, const Vec3i& level, const Vec3i& below);
// Where a level's statistics are measured, whatever part is wanted. Along short axes this is the whole axis.
TorusBox probe_box(const Vec3i& level, const BlockwiseLimits&);

class BlockLevels {
 public:
  // `iterations` has one entry per level. All arguments must outlive this object. If `gl` is set, it makes
  // the parts, except for the last blend and the finish where sources are kept.
  BlockLevels(const std::vector<SolidExemplar>& working, const std::vector<Pyramid>&, const SolidOptions&,
              const std::vector<int>& iterations, int channels, const WholeLevel&, BlockGl* gl = nullptr);

  // Fixes the statistics of all levels above the whole one. Call it once, before make(). If the probe is the
  // whole finest level, returns that level, with `sources` as in make(). Only this needs the whole level's
  // field.
  std::optional<BlockRegion> measure(BlendSources* sources, const Work&);
  // Per level. Statistics can be passed to another object with the same exemplars and settings.
  const std::vector<LevelStatistics>& statistics() const { return statistics_; }
  void set_statistics(std::vector<LevelStatistics> s) { statistics_ = std::move(s); }
  // Makes a part of the finest level. `sources` may be null; its arrays get the shape of the region's field.
  BlockRegion make(const TorusBox&, BlendSources* sources, const Work&) const;

 private:
  enum class Upto { Matches, Blend, Finish };
  // Matches of the level below, and its field if a probe was asked for.
  struct Below {
    TorusLines lines;
    bool whole = false;  // it is whole_, and `made` is empty
    BlockRegion made;
    int patch(int axis, int number) const;
    int slice(int axis, int voxel) const;
  };

  Vec3i size(int level) const;
  // Makes a part of a level. If `core` is not null, the statistics there are stored in `measured`, which is
  // null otherwise.
  BlockRegion run(int level, const TorusBox& wanted, Upto, const LevelStatistics&, LevelStatistics* measured,
                  const TorusBox* core, BlendSources* sources, const Work&) const;
  Below below(int level, const TorusBox& part, const TorusBox* core, const Work&) const;
  void carry(int level, const Below&, BlockRegion&, const Work&) const;
  // Target distributions of the probe's values, per channel: after each blend, and after each round of the
  // finish.
  struct Targets {
    std::vector<Quantiles> values, finished;
  };
  // The same place in the level below.
  TorusBox core_below(int level, const TorusBox& core) const;
  Targets targets_in(int level, const TorusBox& core, const Below&) const;

  BlockGl* gl_;
  const std::vector<SolidExemplar>& working_;
  const std::vector<Pyramid>& pyramids_;
  const SolidOptions& settings_;
  const std::vector<int>& iterations_;
  const WholeLevel& whole_;
  int levels_, channels_;
  std::vector<std::vector<std::vector<Quantiles>>> bands_;  // [exemplar][channel][band]
  std::vector<Quantiles> finished_;                         // [channel]: mixture of all planes' exemplars
  std::vector<LevelStatistics> statistics_;                 // [level]
};

}  // namespace terrazzo::solids
