#include "nodes/common/texture/cooccurrence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/periodic.h"

namespace terrazzo {

std::vector<Vec3i> cooccurrence_offsets(int extent, int scales) {
  std::vector<Vec3i> out;
  std::set<std::pair<int, int>> known;
  for (int s = 0; s < scales; ++s)
    for (int y = 0; y <= extent; ++y)
      for (int x = -extent; x <= extent; ++x) {
        if (y == 0 && x <= 0) continue;
        const int dx = x * (1 << s), dy = y * (1 << s);
        if (known.emplace(dx, dy).second) out.emplace_back(dx, dy, 0);
      }
  return out;
}

Vec3i offset_across(int axis, const Vec3i& p) {
  if (axis == 0) return {0, p.x(), -p.y()};
  if (axis == 1) return {p.x(), 0, -p.y()};
  return {p.x(), -p.y(), 0};
}

Cooccurrence measure_cooccurrence(const LevelField& field, int levels, const std::vector<Vec3i>& offsets,
                                  bool periodic, const Work& work) {
  Cooccurrence out;
  out.levels = levels;
  out.offsets = offsets;
  const auto table = static_cast<std::size_t>(levels) * levels;
  out.counts.assign(offsets.size() * table, 0);
  out.pairs.assign(offsets.size(), 0);
  const Vec3i n = field.size;
  if (field.at.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw Error("too-large",
                fmt::format("{} pixels exceed the range of the co-occurrence counts", field.at.size()));
  work.parallel(offsets.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t d = begin; d < end; ++d) {
      const Vec3i o = offsets[d];
      std::int32_t* counts = out.counts.data() + d * table;
      for (int z = 0; z < n.z(); ++z)
        for (int y = 0; y < n.y(); ++y) {
          if (y % 256 == 0) work.check();
          int ry = y + o.y(), rz = z + o.z();
          if (periodic) {
            ry = wrap_index(ry, n.y());
            rz = wrap_index(rz, n.z());
          } else if (ry < 0 || ry >= n.y() || rz < 0 || rz >= n.z())
            continue;
          const std::uint8_t* home = &field.at[field.index(0, y, z)];
          const std::uint8_t* remote = &field.at[field.index(0, ry, rz)];
          for (int x = 0; x < n.x(); ++x) {
            int rx = x + o.x();
            if (rx < 0 || rx >= n.x()) {
              if (!periodic) continue;
              rx = wrap_index(rx, n.x());
            }
            if (home[x] < levels && remote[rx] < levels)
              ++counts[static_cast<std::size_t>(home[x]) * levels + remote[rx]];
          }
        }
      for (std::size_t i = 0; i < table; ++i) out.pairs[d] += counts[i];
    }
  });
  return out;
}

Cooccurrence measure_cooccurrence(const std::vector<LevelField>& sections, int levels,
                                  const std::vector<Vec3i>& offsets, const Work& work) {
  Cooccurrence out;
  for (const auto& section : sections) {
    Cooccurrence one = measure_cooccurrence(section, levels, offsets, false, work);
    if (out.offsets.empty()) {
      out = std::move(one);
      continue;
    }
    for (std::size_t i = 0; i < one.counts.size(); ++i) out.counts[i] += one.counts[i];
    for (std::size_t d = 0; d < one.pairs.size(); ++d) out.pairs[d] += one.pairs[d];
  }
  return out;
}

std::vector<std::int32_t> scaled_counts(const Cooccurrence& c, std::size_t offset, std::int64_t pairs) {
  const auto table = static_cast<std::size_t>(c.levels) * c.levels;
  const std::int64_t have = c.pairs[offset];
  if (have <= 0)
    throw Error("no-pairs",
                fmt::format("no two pixels of the texture have the offset ({}, {})", c.offsets[offset].x(),
                            c.offsets[offset].y()),
                "use a larger texture, or reduce extent or scales");
  std::vector<std::int32_t> out(table);
  std::vector<std::pair<std::int64_t, std::size_t>> rest(table);
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < table; ++i) {
    const std::int64_t product = c.counts[offset * table + i] * pairs;  // below 2⁶²
    out[i] = product / have;
    rest[i] = {-(product % have), i};
    sum += out[i];
  }
  // Largest remainders first, so that the counts sum to `pairs`.
  std::sort(rest.begin(), rest.end());
  for (std::size_t k = 0; sum < pairs; ++k, ++sum) ++out[rest[k].second];
  return out;
}

double cooccurrence_error(const Cooccurrence& a, const Cooccurrence& b) {
  const auto table = static_cast<std::size_t>(a.levels) * a.levels;
  double sum = 0;
  for (std::size_t d = 0; d < a.offsets.size(); ++d) {
    if (a.pairs[d] == 0 || b.pairs[d] == 0) continue;
    const double ka = 1.0 / a.pairs[d], kb = 1.0 / b.pairs[d];
    for (std::size_t i = d * table; i < (d + 1) * table; ++i) {
      const double e = a.counts[i] * ka - b.counts[i] * kb;
      sum += e * e;
    }
  }
  return sum;
}

}  // namespace terrazzo
