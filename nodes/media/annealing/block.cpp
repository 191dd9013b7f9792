#include "nodes/media/annealing/block.h"

#include <algorithm>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::annealing {
namespace {

// A seam is made with that many more layers on both sides, whose ends match less.
constexpr int kApron = 8;
static_assert(Block::kSeam >= Level::kFrozen);
static_assert(Block::kSeam >= kApron + 4);  // a seam starts from half as many coarser layers, rounded
constexpr int kWide = 2 * (Block::kSeam + kApron);

void copy_layers(const Slab& from, Slab& to, int first, int count) {
  const std::size_t slice = pixels_in(to.size.x(), to.size.y());
  std::copy_n(from.phase.begin() + static_cast<std::ptrdiff_t>((first - from.first) * slice), count * slice,
              to.phase.begin() + static_cast<std::ptrdiff_t>((first - to.first) * slice));
}

Slab empty_slab(const Vec3i& like, const Layers& layers) {
  Slab out{layers.first, {like.x(), like.y(), layers.count}, {}};
  out.phase.resize(voxels_in(out.size));
  return out;
}

}  // namespace

Slab part_of(const Slab& slab, const Layers& layers) {
  Slab out = empty_slab(slab.size, layers);
  copy_layers(slab, out, layers.first, layers.count);
  return out;
}

Block::Block(Descent& descent, const CoarseSolid& coarse, int blocks, int block, std::uint64_t seed)
    : descent_(descent),
      blocks_(blocks),
      block_(block),
      seed_(seed),
      stride_(coarse.stride),
      below_{0, coarse.size, coarse.phase},
      above_(below_),
      slab_(below_) {}

AnnealedLevel Block::refine(int stride, const Work& work) {
  const int layers = layers_of(blocks_, block_, descent_.size_at(stride).z()).count;
  const double share = 1.0 * kWide / (layers + 2 * kWide);
  below_ = seam(below_, stride, block_, work.part(0, share));
  above_ = seam(above_, stride, block_ + 1, work.part(share, 2 * share));
  const Layers free{below_.first + 2 * kSeam, above_.first - below_.first - 2 * kSeam};
  Slab inner = descent_.enlarge(slab_, stride_, stride,
                                {free.first - Level::kFrozen, free.count + 2 * Level::kFrozen});
  copy_layers(below_, inner, inner.first, Level::kFrozen);
  copy_layers(above_, inner, above_.first, Level::kFrozen);
  const AnnealedLevel out =
      descent_.anneal(inner, stride, Ends::Frozen, stream(blocks_ + block_),
                      stride == 1 ? missing_counts() : std::vector<std::int64_t>(), work.part(2 * share, 1));
  slab_ = empty_slab(inner.size, {below_.first, free.count + 4 * kSeam});
  copy_layers(below_, slab_, below_.first, 2 * kSeam);
  copy_layers(above_, slab_, above_.first, 2 * kSeam);
  copy_layers(inner, slab_, free.first, free.count);
  stride_ = stride;
  return out;
}

std::uint64_t Block::stream(int part) const { return mix64(seed_) + part + 1; }

// The layers that blocks `k − 1` and `k` share. The last block meets the first.
Slab Block::seam(const Slab& coarse, int stride, int k, const Work& work) {
  const int layers = descent_.size_at(stride).z(), turn = k == blocks_ ? layers : 0;
  Slab start = coarse;
  if (turn > 0 && coarse.first > 0) start.first -= descent_.size_at(stride_).z();
  const int cut = layers_of(blocks_, k % blocks_, layers).first;
  Slab wide = descent_.enlarge(start, stride_, stride, {cut - kWide / 2, kWide});
  descent_.anneal(wide, stride, Ends::Open, stream(k % blocks_), {}, work);
  Slab out = part_of(wide, {cut - kSeam, 2 * kSeam});
  out.first += turn;
  return out;
}

// Voxels of each phase beside the halves of the seams that belong to the block.
std::vector<std::int64_t> Block::missing_counts() const {
  const int layers = above_.first - below_.first;
  auto out =
      descent_.counts(static_cast<std::int64_t>(voxels_in({below_.size.x(), below_.size.y(), layers})));
  const auto subtract = [&](const Slab& half) {
    for (const std::uint8_t p : half.phase) out[p] = std::max<std::int64_t>(0, out[p] - 1);
  };
  subtract(part_of(below_, {below_.first + kSeam, kSeam}));
  subtract(part_of(above_, {above_.first, kSeam}));
  return out;
}

}  // namespace terrazzo::annealing
