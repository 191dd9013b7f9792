#include "nodes/solids/synthesis/blockwise/blocks.h"

#include <utility>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/solids/synthesis/whole/measures.h"

namespace terrazzo::solids {
namespace {

// Crops the families to a box; slices count from the box's first.
std::vector<NeighborField> families_in(const TorusBox& box, const BlockRegion& region) {
  std::vector<NeighborField> out;
  for (const NeighborField& f : region.families) {
    const std::size_t axis = f.axis;
    const int ua = kSliceColumns[axis], va = kSliceRows[axis];
    const TorusLine &u = region.lines[ua], &v = region.lines[va];
    const int i = first_patch(box.lo[ua], u.period) - u.first,
              j = first_patch(box.lo[va], v.period) - v.first;
    NeighborField part;
    part.axis = f.axis;
    part.exemplar = f.exemplar;
    part.slices = box.hi[f.axis] - box.lo[f.axis];
    part.columns = first_patch(box.hi[ua], u.period) - u.first - i;
    part.rows = first_patch(box.hi[va], v.period) - v.first - j;
    for (int s = 0; s < part.slices; ++s)
      for (int y = 0; y < part.rows; ++y) {
        const auto row =
            f.at.begin() +
            ((static_cast<std::ptrdiff_t>(s) + box.lo[f.axis] - region.lines[axis].from) * f.rows + j + y) *
                f.columns;
        part.at.insert(part.at.end(), row + i, row + i + part.columns);
      }
    out.push_back(std::move(part));
  }
  return out;
}

// Crops a dense array of a region's voxels to a box.
template <class T>
std::vector<T> crop(const TorusBox& box, const BlockRegion& region, const std::vector<T>& all) {
  std::vector<T> out;
  if (all.empty()) return out;
  out.reserve(voxels(box.size()));
  for (int z = box.lo.z(); z < box.hi.z(); ++z)
    for (int y = box.lo.y(); y < box.hi.y(); ++y) {
      const auto row =
          all.begin() + ((static_cast<std::ptrdiff_t>(z) - region.lines[2].from) * region.field.size.y() + y -
                         region.lines[1].from) *
                            region.field.size.x();
      out.insert(out.end(), row + (box.lo.x() - region.lines[0].from),
                 row + (box.hi.x() - region.lines[0].from));
    }
  return out;
}

}  // namespace

TorusBox block_box(const SolidOptions& s) {
  const Vec3i at(s.block % s.blocks.x(), s.block / s.blocks.x() % s.blocks.y(),
                 s.block / s.blocks.x() / s.blocks.y());
  TorusBox box;
  for (int a = 0; a < 3; ++a) {
    box.lo[a] = at[a] * s.size[a] / s.blocks[a];
    box.hi[a] = (at[a] + 1) * s.size[a] / s.blocks[a];
    box.closed[a] = s.blocks[a] == 1;
  }
  return box;
}

namespace {

void find_similar_above(const WholeLevel& whole, std::vector<Pyramid>& pyramids, const Work& work) {
  for (auto& p : pyramids)
    for (std::size_t l = static_cast<std::size_t>(whole.level) + 1; l < p.size(); ++l)
      find_similar(p[l], work.quiet());
}

// Crops the result to the block that the settings name, and measures its matches.
void hand_over(BlockRegion&& region, const SolidOptions& s, SolidResult& out, const Work& work) {
  const TorusBox box = block_box(s);
  out.size = box.size();
  out.origin = box.lo;
  out.measures = measure_copies(families_in(box, region), work);
  region.families.clear();
  out.field = {out.size, std::vector<std::vector<float>>(region.field.channel.size())};
  work.parallel(region.field.channel.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      out.field.channel[c] = crop(box, region, region.field.channel[c]);
      region.field.channel[c] = {};
    }
  });
  out.sources.texel = crop(box, region, out.sources.texel);
  out.sources.exemplar = crop(box, region, out.sources.exemplar);
  out.sources.features = crop(box, region, out.sources.features);
}

}  // namespace

BlockBase measure_base(const std::vector<SolidExemplar>& working, std::vector<Pyramid>& pyramids,
                       std::vector<NeighborField> families, const SolidOptions& s, SolidResult& out,
                       const Work& work) {
  const std::vector<int> iterations = iterations_of(s, out.levels);
  BlockBase base{{whole_level(s, out.levels), std::move(families), std::move(out.field)}, {}};
  find_similar_above(base.whole, pyramids, work);
  BlockLevels local(working, pyramids, s, iterations, out.axes.channels, base.whole);
  local.measure(nullptr, work);
  base.statistics = local.statistics();
  base.whole.field = {};
  return base;
}

void make_block(const std::vector<SolidExemplar>& working, std::vector<Pyramid>& pyramids,
                const BlockBase& base, const SolidOptions& s, BlockGl* gl, SolidResult& out,
                const Work& work) {
  const std::vector<int> iterations = iterations_of(s, out.levels);
  find_similar_above(base.whole, pyramids, work);
  BlockLevels local(working, pyramids, s, iterations, out.axes.channels, base.whole, gl);
  local.set_statistics(base.statistics);
  hand_over(local.make(block_box(s), s.sources ? &out.sources : nullptr, work), s, out, work.quiet());
}

void make_block(const std::vector<SolidExemplar>& working, std::vector<Pyramid>& pyramids,
                std::vector<NeighborField> families, const SolidOptions& s, BlockGl* gl, SolidResult& out,
                const Work& work) {
  const std::vector<int> iterations = iterations_of(s, out.levels);
  WholeLevel whole{whole_level(s, out.levels), std::move(families), std::move(out.field)};
  find_similar_above(whole, pyramids, work);
  BlockLevels local(working, pyramids, s, iterations, out.axes.channels, whole, gl);
  BlendSources* const sources = s.sources ? &out.sources : nullptr;
  auto everywhere = local.measure(sources, work.part(0, 0.4));
  whole.field = {};
  BlockRegion made =
      everywhere ? std::move(*everywhere) : local.make(block_box(s), sources, work.part(0.4, 1));
  work.progress(1, "measures");
  hand_over(std::move(made), s, out, work.quiet());
}

}  // namespace terrazzo::solids
