// Histograms on the device, their maps, and the finish.
#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/solids/synthesis/blockwise/gl_run.h"
#include "nodes/solids/synthesis/whole/finish.h"

namespace terrazzo::solids {
namespace {

constexpr std::size_t kCopies = 16;  // of each histogram, as in the shaders

// The map of counted values to its target.
ValueMap finished(Remap& map, const Remap::Counts& counts) {
  map.finish(counts);
  return ValueMap(Remap(map.low(), map.scale(), map.bins()));
}

}  // namespace

void BlockGl::Run::use_values(unsigned program, std::size_t channel, const Remap& map) {
  gl_.use(program);
  field_.bind(0);
  gl_.set("voxels", static_cast<int>(voxels_));
  gl_.set("size", region_.field.size);
  gl_.set("channel", static_cast<int>(channel));
  gl_.set("map_low", map.low());
  gl_.set("map_scale", map.scale());
}

void BlockGl::Run::map_values(std::size_t channel, const Remap& map, const Vec3i& first, const Vec3i& last) {
  maps_.fill(map.bins());
  use_values(gl_.map, channel, map);
  maps_.bind(6);
  gl_.dispatch(first, last, work_.quiet());
  const Vec3i originals(tables_.voxels[0], tables_.voxels[1], tables_.voxels[2]);
  copy_beyond(field_, channel * voxels_, region_.field.size, originals);
}

std::vector<Remap::Counts> BlockGl::Run::counted(std::size_t maps) {
  std::vector<std::uint32_t> all(kCopies * maps * Remap::kBins);
  counts_.read(0, all);
  std::vector<Remap::Counts> out(maps, Remap::Counts(Remap::kBins, 0));
  for (std::size_t i = 0; i < all.size(); ++i) out[i / Remap::kBins % maps][i % Remap::kBins] += all[i];
  return out;
}

ValueMap BlockGl::Run::measured_values(std::size_t channel, const TorusBox& box, const Quantiles& wanted) {
  Remap map(wanted);
  counts_.resize(kCopies * Remap::kBins * sizeof(std::uint32_t));
  counts_.clear();
  use_values(gl_.count, channel, map);
  counts_.bind(2);
  const Vec3i from(lines_[0].from, lines_[1].from, lines_[2].from);
  gl_.dispatch(box.lo - from, box.hi - from, work_.quiet());
  return finished(map, counted(1)[0]);
}

void BlockGl::Run::split_bands(const NeighborField& f, std::size_t channel, const std::vector<Remap>& maps,
                               bool counting, const TorusBox& box) {
  const std::size_t axis = f.axis;
  const int ua = kSliceColumns[axis], va = kSliceRows[axis];
  const Vec3i& stored = region_.field.size;
  const Vec3i steps(1, stored.x(), stored.x() * stored.y());
  const auto turned = [&](const Vec3i& v) { return Vec3i(v[ua], v[va], v[f.axis]); };
  const Vec3i from(lines_[0].from, lines_[1].from, lines_[2].from);
  gl_.use(gl_.finish);
  field_.bind(0);
  sum_.bind(1);
  counts_.bind(2);
  maps_.bind(6);
  gl_.set("voxels", static_cast<int>(voxels_));
  gl_.set("channel", static_cast<int>(channel));
  gl_.set("size", turned(stored));
  gl_.set("stride", turned(steps));
  gl_.set("counting", static_cast<int>(counting));
  gl_.set("share", finish_share(region_.families.size()));
  for (std::size_t b = 0; b < maps.size(); ++b) {
    gl_.set(fmt::format("map_low[{}]", b), maps[b].low());
    gl_.set(fmt::format("map_scale[{}]", b), maps[b].scale());
  }
  constexpr int kTile = 16;  // as in the shader
  gl_.dispatch(turned(box.lo - from), turned(box.hi - from), work_.quiet(), kTile);
}

void BlockGl::Run::finish_round(const BlockFinish& finish, std::size_t channel, const TorusBox& box,
                                FinishMaps& maps) {
  const auto& families = region_.families;
  if (finish.measured)
    for (const NeighborField& f : families) {
      std::vector<Remap> bands;
      for (const Quantiles& wanted : finish.bands[f.exemplar][channel]) bands.emplace_back(wanted);
      counts_.resize(kCopies * bands.size() * Remap::kBins * sizeof(std::uint32_t));
      counts_.clear();
      split_bands(f, channel, bands, true, *finish.measured);
      const auto counts = counted(bands.size());
      maps.bands.emplace_back();
      for (std::size_t b = 0; b < bands.size(); ++b)
        maps.bands.back().push_back(finished(bands[b], counts[b]));
    }
  field_.copy(channel * voxels_ * sizeof(float), sum_, 0, voxels_ * sizeof(float));
  for (std::size_t k = 0; k < families.size(); ++k) {
    std::vector<Remap> bands;
    std::vector<Remap::Bin> bins;
    for (const ValueMap& m : maps.bands[k]) {
      bands.push_back(m.map());
      bins.insert(bins.end(), m.map().bins().begin(), m.map().bins().end());
    }
    maps_.fill(bins);
    split_bands(families[k], channel, bands, false, box);
  }
  sum_.copy(0, field_, channel * voxels_ * sizeof(float), voxels_ * sizeof(float));
  if (finish.measured)
    maps.values.push_back(measured_values(channel, *finish.measured, finish.values[channel]));
  map_values(channel, maps.values[0].map(), Vec3i::Zero(), region_.field.size);
}

void BlockGl::Run::finish(const BlockFinish& finish, const Work& work) {
  const std::size_t rounds = finish.boxes.size();
  if (finish.measured) finish.maps.assign(channels_, std::vector<FinishMaps>(rounds));
  sum_.resize(voxels_ * sizeof(float));
  counts_.resize(sizeof(std::uint32_t));  // bound even where nothing is counted
  maps_.resize(sizeof(Remap::Bin));       // likewise where nothing is mapped
  for (std::size_t c = 0; c < channels_; ++c)
    for (std::size_t r = 0; r < rounds; ++r) {
      finish_round(finish, c, finish.boxes[r], finish.maps[c][r]);
      work.done(c * rounds + r + 1, channels_ * rounds);
    }
}

}  // namespace terrazzo::solids
