#include "nodes/solids/synthesis/blockwise/search.h"

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/matching/candidates.h"
#include "runtime/random.h"

namespace terrazzo::solids {
namespace {

constexpr int kReach = 3;  // patches; the previous iteration's matches are stored at least that far out

struct BlockTask {
  const ExemplarLevel& e;
  const NeighborField& f;
  const TorusLine &u, &v;
  std::array<int, 2> columns, rows;  // from, to
  int slice;
  std::uint32_t place;  // hash of key and slice
  Penalties penalties;
  const float* picture;  // the slice, channels interleaved
  std::uint32_t* next;   // matches of the family
  float* weight;         // weights of the family
  float* features;       // features of one row of patches
};

TERRAZZO_INLINE void search_body(const BlockTask& t) {
  const ExemplarLevel& e = t.e;
  const int dims = e.space.dims, columns = t.f.columns;
  const std::size_t pitch = static_cast<std::size_t>(t.u.to - t.u.from) * e.channels;
  const std::size_t plane = static_cast<std::size_t>(columns) * t.f.rows;
  for (int j = t.rows[0]; j < t.rows[1]; ++j) {
    const float* line = t.picture + (t.v.start[j] - t.v.from) * pitch;
    // Where the period is odd, two patches start one voxel apart.
    for (int i = t.columns[0], end; i < t.columns[1]; i = end) {
      for (end = i + 1; end < t.columns[1] && t.u.start[end] == t.u.start[end - 1] + 2; ++end) {
      }
      project(e.space, line + static_cast<std::ptrdiff_t>(t.u.start[i] - t.u.from) * e.channels, pitch, 2,
              end - i, t.features + static_cast<std::ptrdiff_t>(i - t.columns[0]) * dims);
    }
    const std::uint32_t row =
        mix32(static_cast<std::uint32_t>(wrapped(t.v.first + j, patches_around(t.v.period))) ^ t.place);
    for (int i = t.columns[0]; i < t.columns[1]; ++i) {
      const std::size_t n = t.slice * plane + pixel_at(i, j, columns);
      const std::uint32_t* at = &t.f.at[n];
      const int u = t.u.start[i], v = t.v.start[j];
      const FourInts goes_on = {at[-1] + (u - t.u.start[i - 1]), at[1] + (u - t.u.start[i + 1]),
                                at[-columns] + ((v - t.v.start[j - 1]) * e.width),
                                at[columns] + ((v - t.v.start[j + 1]) * e.width)};
      Best best(e, t.features + static_cast<std::ptrdiff_t>(i - t.columns[0]) * dims, t.penalties, goes_on,
                *at);
      for (int r = 1; r <= kReach; ++r) {
        best.shifted(at[-r], u - t.u.start[i - r], 0);
        best.shifted(at[r], u - t.u.start[i + r], 0);
        best.shifted(at[-r * columns], 0, v - t.v.start[j - r]);
        best.shifted(at[r * columns], 0, v - t.v.start[j + r]);
      }
      best.consider(*(at - plane));
      best.consider(*(at + plane));
      best.similar();
      std::uint32_t draw =
          mix32(static_cast<std::uint32_t>(wrapped(t.u.first + i, patches_around(t.u.period))) ^ row);
      best.around(16, [&] {
        const std::uint32_t bits = mix32(draw += 0x9e3779b9u);
        return std::array<std::uint64_t, 2>{bits & 0xffffu, bits >> 16};
      });
      t.next[n] = best.at;
      t.weight[n] = best.distance;
    }
  }
}
TERRAZZO_AVX2 void search_avx2(const BlockTask& t) { search_body(t); }
void search_plain(const BlockTask& t) { search_body(t); }

// Reads a slice of the stored voxels, channels interleaved.
void read_stored(const SolidField& field, int axis, int slice, std::vector<float>& out) {
  const int u = kSliceColumns[axis], v = kSliceRows[axis];
  const std::size_t step[3] = {1, static_cast<std::size_t>(field.size.x()),
                               pixels_in(field.size.x(), field.size.y())};
  const std::size_t channels = field.channel.size(), w = field.size[u], h = field.size[v];
  out.resize(w * h * channels);
  for (std::size_t c = 0; c < channels; ++c) {
    const float* from = field.channel[c].data() + slice * step[axis];
    for (std::size_t y = 0; y < h; ++y)
      for (std::size_t x = 0; x < w; ++x) out[(y * w + x) * channels + c] = from[y * step[v] + x * step[u]];
  }
}

}  // namespace

std::uint32_t search_key(std::uint64_t seed, int iteration, int axis) {
  return Random(seed, 0x5000 + static_cast<std::uint64_t>(iteration) * 3 + axis).bits();
}

NeighborField block_family(const TorusLines& lines, int axis, int exemplar) {
  NeighborField f;
  const TorusLine &u = lines[kSliceColumns[axis]], &v = lines[kSliceRows[axis]], &s = lines[axis];
  f.axis = axis;
  f.exemplar = exemplar;
  f.slices = s.to - s.from;
  f.columns = u.patches();
  f.rows = v.patches();
  f.width = u.to - u.from;
  f.height = v.to - v.from;
  f.at.resize(static_cast<std::size_t>(f.slices) * f.columns * f.rows);
  f.weight.assign(f.at.size(), 1.0f);
  return f;
}

void search_locally(const std::vector<const ExemplarLevel*>& exemplars,
                    const std::vector<std::vector<float>>& penalty, const TorusBox& box,
                    const SearchOptions& settings, BlockRegion& region, const Work& work) {
  static const bool avx2 = has_avx2();
  for (std::size_t k = 0; k < region.families.size(); ++k) {
    NeighborField& f = region.families[k];
    const std::size_t axis = f.axis, of = f.exemplar;
    const TorusLine &u = region.lines[kSliceColumns[axis]], &v = region.lines[kSliceRows[axis]],
                    &s = region.lines[axis];
    const ExemplarLevel& e = *exemplars[of];
    const auto columns = u.patches_over(box, kSliceColumns[axis]),
               rows = v.patches_over(box, kSliceRows[axis]);
    const std::uint32_t key = search_key(settings.seed, settings.iteration, f.axis);
    std::vector<std::uint32_t> next = f.at;
    work.part(static_cast<double>(k) / region.families.size(),
              (static_cast<double>(k) + 1) / region.families.size())
        .parallel(box.hi[f.axis] - box.lo[f.axis], 1, [&](std::size_t begin, std::size_t end) {
          std::vector<float> picture,
              features(static_cast<std::size_t>(columns[1] - columns[0]) * e.space.dims);
          for (std::size_t i = begin; i < end; ++i) {
            const int slice = box.lo[f.axis] + static_cast<int>(i);
            read_stored(region.field, f.axis, slice - s.from, picture);
            const BlockTask task{e,
                                 f,
                                 u,
                                 v,
                                 columns,
                                 rows,
                                 slice - s.from,
                                 mix32(static_cast<std::uint32_t>(wrapped(slice, s.period)) ^ key),
                                 {penalty[of].data(), settings.copying},
                                 picture.data(),
                                 next.data(),
                                 f.weight.data(),
                                 features.data()};
            avx2 ? search_avx2(task) : search_plain(task);
          }
        });
    f.at.swap(next);
  }
}

namespace {

// Copies each element of a dense array from original(k) along three axes, wherever that differs from its own
// place.
template <class T>
void copy_originals(const std::array<std::vector<int>, 3>& original, std::vector<T>& array,
                    const Work& work) {
  const std::size_t n0 = original[0].size(), n1 = original[1].size();
  const auto copied = [&](int axis, std::size_t k) { return original[axis][k] != static_cast<int>(k); };
  work.parallel(original[2].size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t z = begin; z < end; ++z)
      for (std::size_t y = 0; y < n1; ++y) {
        T* to = &array[(z * n1 + y) * n0];
        const T* from = &array[(original[2][z] * n1 + original[1][y]) * n0];
        const bool row = copied(2, z) || copied(1, y);
        for (std::size_t x = 0; x < n0; ++x)
          if (row || copied(0, x)) to[x] = from[original[0][x]];
      }
  });
}

bool any_closed(const TorusLines& lines) { return lines[0].closed || lines[1].closed || lines[2].closed; }

std::vector<int> originals(int n, bool patches, const TorusLine& line) {
  std::vector<int> out;
  for (int k = 0; k < n; ++k) out.push_back(patches ? line.original_patch(k) : line.original_voxel(k));
  return out;
}

}  // namespace

void copy_beyond(const TorusLines& lines, NeighborField& f, const Work& work) {
  if (!any_closed(lines)) return;
  const std::size_t axis = f.axis;
  const std::array<std::vector<int>, 3> from = {originals(f.columns, true, lines[kSliceColumns[axis]]),
                                                originals(f.rows, true, lines[kSliceRows[axis]]),
                                                originals(f.slices, false, lines[axis])};
  copy_originals(from, f.at, work);
  copy_originals(from, f.weight, work);
}

void copy_beyond(const TorusLines& lines, std::vector<float>& voxels, const Work& work) {
  if (!any_closed(lines)) return;
  std::array<std::vector<int>, 3> from;
  for (std::size_t a = 0; a < 3; ++a) from[a] = originals(lines[a].to - lines[a].from, false, lines[a]);
  copy_originals(from, voxels, work);
}

}  // namespace terrazzo::solids
