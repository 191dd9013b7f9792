#include "nodes/solids/synthesis/reference_2011/optimize.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/exemplar/patch_tree.h"
#include "nodes/solids/synthesis/matching/cover.h"
#include "runtime/random.h"

namespace terrazzo::solids {
namespace {

constexpr int kBins = 16;
constexpr float kEpsilon = 2;  // of the nearest-neighbor search

// Sixteen bins per channel, in units of the mean bin.
struct Histogram {
  std::vector<float> lo, scale;              // per channel
  std::vector<std::array<float, kBins>> at;  // per channel

  int bin(std::size_t c, float v) const { return std::clamp<int>((v - lo[c]) * scale[c], 0, kBins - 1); }
};

Histogram histogram_of(const ExemplarLevel& e) {
  Histogram h;
  const std::size_t n = e.usable.size();
  for (std::size_t c = 0; c < static_cast<std::size_t>(e.channels); ++c) {
    float lo = e.texels[c], hi = lo;
    for (std::size_t i = 0; i < n; ++i) {
      lo = std::min(lo, e.texels[4 * i + c]);
      hi = std::max(hi, e.texels[4 * i + c]);
    }
    h.lo.push_back(lo);
    h.scale.push_back(kBins / std::max(hi - lo, 1e-12f));
    h.at.push_back({});
    for (std::size_t i = 0; i < n; ++i)
      h.at[c][h.bin(c, e.texels[4 * i + c])] += static_cast<float>(kBins) / n;
  }
  return h;
}

void search_trees(const SolidField& field, const std::vector<const ExemplarLevel*>& exemplars,
                  const std::vector<PatchTree>& trees, std::vector<NeighborField>& families,
                  const Work& work) {
  for (std::size_t k = 0; k < families.size(); ++k) {
    NeighborField& f = families[k];
    const ExemplarLevel& e = *exemplars[f.exemplar];
    const PatchTree& tree = trees[f.exemplar];
    const std::size_t dims = e.space.dims;
    const std::size_t pitch = static_cast<std::size_t>(f.width + kPatch - 1) * e.channels;
    const double n = families.size();
    work.part(k / n, (static_cast<double>(k) + 1) / n)
        .parallel(f.slices, 1, [&](std::size_t begin, std::size_t end) {
          std::vector<float> picture, features(dims * f.columns);
          std::vector<PatchTree::Hit> hits;
          for (std::size_t s = begin; s < end; ++s) {
            read_slice(field, f.axis, s, picture);
            for (int j = 0; j < f.rows; ++j) {
              work.check();
              project(e.space, &picture[(2 * j) * pitch], pitch, 2, f.columns, features.data());
              for (int i = 0; i < f.columns; ++i) {
                tree.nearest(
                    &features[i * dims], 1, kEpsilon, 1 << 30, [](std::uint32_t) { return true; }, hits);
                const std::size_t at = (s * static_cast<std::size_t>(f.rows) + static_cast<std::size_t>(j)) *
                                           static_cast<std::size_t>(f.columns) +
                                       i;
                f.at[at] = hits[0].item;
                f.weight[at] = hits[0].distance2;
              }
            }
          }
        });
  }
}

// A texel over a voxel, or a cluster of them.
struct Texel {
  std::array<float, 3> value;
  float weight;
};

// Merges clusters whose centers are within `window` of each other until none are left to merge. Returns the
// mean of the heaviest cluster.
std::array<float, 3> dominant_cluster(std::vector<Texel>& t, float window) {
  const float limit = window * window;
  for (bool merged = true; merged;) {
    merged = false;
    for (std::size_t i = 0; i < t.size(); ++i)
      for (std::size_t j = i + 1; j < t.size();) {
        float far = 0;
        for (int c = 0; c < 3; ++c) far += (t[i].value[c] - t[j].value[c]) * (t[i].value[c] - t[j].value[c]);
        if (far > limit) {
          ++j;
          continue;
        }
        const float w = t[i].weight + t[j].weight;
        for (int c = 0; c < 3; ++c)
          t[i].value[c] = (t[i].value[c] * t[i].weight + t[j].value[c] * t[j].weight) / w;
        t[i].weight = w;
        t[j] = t.back();
        t.pop_back();
        merged = true;
      }
  }
  return std::max_element(t.begin(), t.end(),
                          [](const Texel& a, const Texel& b) { return a.weight < b.weight; })
      ->value;
}

}  // namespace

void optimize_by_reference(const std::vector<const ExemplarLevel*>& exemplars,
                           std::vector<NeighborField>& families, int iterations, double exponent,
                           double window, std::uint64_t seed, SolidField& field, const Work& work) {
  std::vector<PatchTree> trees;
  std::vector<Histogram> wanted;
  for (const auto* e : exemplars) {
    trees.emplace_back(e->features.data(), e->space.dims, e->starts);
    wanted.push_back(histogram_of(*e));
  }
  const std::size_t n = field.channel[0].size(), channels = field.channel.size();
  const Vec3i& size = field.size;
  const std::array<std::vector<PatchCover>, 3> cover = {patch_covers(size.x()), patch_covers(size.y()),
                                                        patch_covers(size.z())};
  const float unit = static_cast<float>(kBins) / n;
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0u);
  for (int it = 0; it < iterations; ++it) {
    const Work step = work.part(static_cast<double>(it) / iterations, (it + 1.0) / iterations);
    search_trees(field, exemplars, trees, families, step.part(0, 0.8));
    for (auto& f : families)
      for (auto& w : f.weight) w = std::pow(std::max(w, 1e-6f), static_cast<float>((exponent - 2) / 2));
    // The solid's histogram, in each exemplar's bins.
    std::vector<Histogram> have = wanted;
    for (auto& h : have)
      for (std::size_t c = 0; c < channels; ++c) {
        h.at[c].fill(0);
        for (const float v : field.channel[c]) h.at[c][h.bin(c, v)] += unit;
      }
    Random random(seed, 0x70, static_cast<std::uint64_t>(it));
    for (std::size_t i = n - 1; i > 0; --i) std::swap(order[i], order[random.below(i + 1)]);
    const float reach =
        window * std::pow(0.1, iterations > 1 ? static_cast<double>(it) / (iterations - 1) : 1);
    std::vector<Texel> texels;
    std::size_t visited = 0;
    for (const std::uint32_t voxel : order) {
      if (++visited % 4096 == 0) work.check();
      const int at[3] = {static_cast<int>(voxel % size.x()),
                         static_cast<int>(voxel / static_cast<std::uint32_t>(size.x()) % size.y()),
                         static_cast<int>(voxel / static_cast<std::uint32_t>(size.x()) / size.y())};
      texels.clear();
      for (const NeighborField& f : families) {
        const ExemplarLevel& e = *exemplars[f.exemplar];
        const Histogram &want = wanted[f.exemplar], &now = have[f.exemplar];
        const int u = kSliceColumns[f.axis], v = kSliceRows[f.axis];
        const PatchCover &cu = cover[u][at[u]], &cv = cover[v][at[v]];
        for (int b = 0; b < cv.count; ++b)
          for (int a = 0; a < cu.count; ++a) {
            const std::size_t patch =
                (static_cast<std::size_t>(at[f.axis]) * static_cast<std::size_t>(f.rows) +
                 static_cast<std::size_t>(cv.patch[b])) *
                    static_cast<std::size_t>(f.columns) +
                cu.patch[a];
            const std::size_t source =
                f.at[patch] + static_cast<std::size_t>(cv.offset[b] * e.width + cu.offset[a]);
            Texel t{{0, 0, 0}, f.weight[patch]};
            float excess = 1;
            for (std::size_t c = 0; c < channels; ++c) {
              t.value[c] = e.texels[4 * source + c];
              const std::size_t bin = want.bin(c, t.value[c]);
              excess += std::max(0.0f, now.at[c][bin] - want.at[c][bin]);
            }
            t.weight /= excess;
            texels.push_back(t);
          }
      }
      const auto value = dominant_cluster(texels, reach);
      for (std::size_t c = 0; c < channels; ++c) {
        float& old = field.channel[c][voxel];
        for (auto& h : have) {
          h.at[c][h.bin(c, old)] -= unit;
          h.at[c][h.bin(c, value[c])] += unit;
        }
        old = value[c];
      }
    }
    step.progress(1);
  }
}

SolidField resample(const SolidField& in, const Vec3i& size, const Work& work) {
  SolidField out;
  out.size = size;
  const std::size_t n = voxels_in(size);
  for (const auto& from : in.channel) {
    std::vector<float> to(n);
    work.parallel(size.z(), 4, [&](std::size_t begin, std::size_t end) {
      const auto place = [&](int axis, int i, int* whole, float& part) {
        const double p = (i + 0.5) * in.size[axis] / size[axis] - 0.5, f = std::floor(p);
        whole[0] = (static_cast<int>(f) + in.size[axis]) % in.size[axis];
        whole[1] = (whole[0] + 1) % in.size[axis];
        part = p - f;
      };
      for (std::size_t z = begin; z < end; ++z)
        for (int y = 0; y < size.y(); ++y)
          for (int x = 0; x < size.x(); ++x) {
            int wx[2], wy[2], wz[2];
            float px, py, pz;
            place(0, x, wx, px);
            place(1, y, wy, py);
            place(2, static_cast<int>(z), wz, pz);
            float sum = 0;
            for (int k = 0; k < 8; ++k)
              sum += (k & 1 ? px : 1 - px) * (k & 2 ? py : 1 - py) * (k & 4 ? pz : 1 - pz) *
                     from[(static_cast<std::size_t>(wz[k >> 2]) * static_cast<std::size_t>(in.size.y()) +
                           static_cast<std::size_t>(wy[k >> 1 & 1])) *
                              static_cast<std::size_t>(in.size.x()) +
                          wx[k & 1]];
            to[(z * static_cast<std::size_t>(size.y()) + static_cast<std::size_t>(y)) *
                   static_cast<std::size_t>(size.x()) +
               x] = sum;
          }
    });
    out.channel.push_back(std::move(to));
  }
  return out;
}

}  // namespace terrazzo::solids
