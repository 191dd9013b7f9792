#include "nodes/common/stereology/profile_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/indices.h"

namespace terrazzo {

ProfileSweep::ProfileSweep(const Mesh& mesh)
    : mesh_(mesh),
      order_(mesh),
      flat_(1e-4 * mesh_bounding_radius(mesh, mesh.vertices.empty() ? Vec3(Vec3::Zero()) : mesh.vertices[0])),
      sides_(mesh.triangles.size()) {
  struct Side {
    std::int32_t low, high;
    std::size_t triangle;
    int side;
  };
  std::vector<Side> sides;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
      sides.push_back({low, high, t, k});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    return a.triangle < b.triangle;
  });
  std::int32_t edge = -1;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (i == 0 || sides[i].low != sides[i - 1].low || sides[i].high != sides[i - 1].high) ++edge;
    sides_[sides[i].triangle][sides[i].side] = edge;
  }
  parts_ = DisjointSets(static_cast<std::size_t>(edge) + 1);
  loop_of_edge_.resize(edge + 1);
  times_middle_.resize(mesh.vertices.size());
}

void ProfileSweep::start(const Vec3& direction) {
  order_.set(direction);
  ranked_.clear();
  bucket_.assign(order_.count() + 1, 0);
  std::fill(times_middle_.begin(), times_middle_.end(), 0);
  for (const Triangle& t : mesh_.triangles) {
    const RankedTriangle& r = ranked_.emplace_back(order_, t);
    ++times_middle_[r.middle];
    ++bucket_[order_.rank(r.low) + 1];
  }
  for (std::size_t b = 1; b < bucket_.size(); ++b) bucket_[b] += bucket_[b - 1];
  by_low_.resize(ranked_.size());
  for (std::size_t t = 0; t < ranked_.size(); ++t) by_low_[bucket_[order_.rank(ranked_[t].low)]++] = t;
  next_ = 0;
  active_.clear();
  ranges_.clear();
}

const std::vector<ProfileRange>& ProfileSweep::sweep(const Vec3& direction) {
  start(direction);
  // Around a regular vertex the neighbors change between lower and higher twice, so it is the middle vertex
  // of exactly two triangles.
  std::int32_t bottom = 0;
  for (std::int32_t r = 1; r < order_.count(); ++r)
    if (times_middle_[order_.vertex(r)] != 2) {
      add_slab(bottom, r);
      bottom = r;
    }
  return ranges_;
}

void ProfileSweep::add_slab(std::int32_t bottom, std::int32_t top) {
  std::erase_if(active_, [&](std::int32_t t) { return order_.rank(ranked_[t].high) <= bottom; });
  while (next_ < by_low_.size() && order_.rank(ranked_[by_low_[next_]].low) < top) {
    if (order_.rank(ranked_[by_low_[next_]].high) > bottom) active_.push_back(by_low_[next_]);
    ++next_;
  }
  if (active_.empty() || !(order_.height(top) > order_.height(bottom))) return;
  find_loops(bottom, top);
  add_areas(bottom, top);

  const std::int32_t count = top - bottom;
  std::int32_t thickest = 0;
  for (std::int32_t k = 1; k < count; ++k)
    if (areas_[k].thickness > areas_[thickest].thickness) thickest = k;
  bool holes = false;
  for (std::size_t l = 0; l < loops_.size(); ++l) {
    loops_[l].area = areas_[l * count + thickest].middle;
    holes = holes || loops_[l].area < 0;
  }
  if (holes) {
    find_owners((order_.height(bottom + thickest) + order_.height(bottom + thickest + 1)) / 2);
    for (std::size_t l = 0; l < loops_.size(); ++l) {
      if (loops_[l].owner < 0) continue;
      ++loops_[loops_[l].owner].holes;
      for (std::int32_t k = 0; k < count; ++k) {
        const AreaRange& hole = areas_[l * count + k];
        AreaRange& outer = areas_[pixel_at(k, loops_[l].owner, count)];
        outer.low += hole.low;
        outer.middle += hole.middle;
        outer.high += hole.high;
      }
    }
  }
  for (std::size_t l = 0; l < loops_.size(); ++l) {
    if (loops_[l].area <= 0) continue;
    for (std::int32_t k = 0; k < count; ++k) {
      AreaRange a = areas_[l * count + k];
      if (!(a.thickness > 0)) continue;
      a.low = std::max(0.0, a.low);
      a.middle = std::max(0.0, a.middle);
      a.high = std::max(0.0, a.high);
      ranges_.push_back({a, loops_[l].holes});
    }
  }
}

// Joins the edges of each triangle that cross the slab; each connected set is one loop.
void ProfileSweep::find_loops(std::int32_t bottom, std::int32_t top) {
  const auto passes = [&](std::int32_t a, std::int32_t b) {
    const std::int32_t ra = order_.rank(a), rb = order_.rank(b);
    return std::min(ra, rb) < top && std::max(ra, rb) > bottom;
  };
  for (std::int32_t t : active_)
    for (std::int32_t e : sides_[t]) {
      parts_.reset(e);
      loop_of_edge_[e] = -1;
    }
  for (std::int32_t t : active_) {
    std::int32_t first = -1;
    for (int k = 0; k < 3; ++k) {
      if (!passes(mesh_.triangles[t][k], mesh_.triangles[t][(k + 1) % 3])) continue;
      const std::int32_t r = parts_.find(sides_[t][k]);
      if (first < 0)
        first = r;
      else if (r != first)
        parts_.join_to(first, r);
    }
  }
  loops_.clear();
  loop_of_active_.resize(active_.size());
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const std::int32_t t = active_[i];
    int k = 0;
    while (!passes(mesh_.triangles[t][k], mesh_.triangles[t][(k + 1) % 3])) ++k;
    const std::int32_t r = parts_.find(sides_[t][k]);
    if (loop_of_edge_[r] < 0) {
      loop_of_edge_[r] = loops_.size();
      loops_.emplace_back();
    }
    loop_of_active_[i] = loop_of_edge_[r];
  }
}

void ProfileSweep::add_areas(std::int32_t bottom, std::int32_t top) {
  const std::size_t count = top - bottom;
  difference_.assign(loops_.size() * (count + 1), {});
  areas_.assign(loops_.size() * count, {0, 0, 0, 0});
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const RankedTriangle& r = ranked_[active_[i]];
    const auto add = [&](const Chord& chord, std::int32_t from, std::int32_t to) {
      if (!chord.valid()) return;
      const bool is_flat = order_.height(to) - order_.height(from) <= flat_;
      from = std::max(from, bottom) - bottom;
      to = std::min(to, top) - bottom;
      if (from >= to) return;
      const std::size_t row = loop_of_active_[i];
      if (!is_flat) {
        const Quadratic q = chord.area();
        difference_[row * (count + 1) + from] += q;
        difference_[row * (count + 1) + to] -= q;
        return;
      }
      for (std::int32_t k = from; k < to; ++k) {
        const double z0 = order_.height(bottom + k), z1 = order_.height(bottom + k + 1);
        AreaRange& a = areas_[row * count + k];
        a.low += chord.area(z0);
        a.middle += chord.area((z0 + z1) / 2);
        a.high += chord.area(z1);
      }
    };
    add(r.lower(order_), order_.rank(r.low), order_.rank(r.middle));
    add(r.upper(order_), order_.rank(r.middle), order_.rank(r.high));
  }
  for (std::size_t l = 0; l < loops_.size(); ++l) {
    Quadratic sum;
    for (std::size_t k = 0; k < count; ++k) {
      sum += difference_[l * (count + 1) + k];
      const double z0 = order_.height(bottom + static_cast<std::int32_t>(k));
      const double z1 = order_.height(bottom + static_cast<std::int32_t>(k) + 1);
      AreaRange& a = areas_[l * count + k];
      a.thickness = z1 - z0;
      a.low += sum(z0);
      a.middle += sum((z0 + z1) / 2);
      a.high += sum(z1);
    }
  }
}

// Assigns each hole to the smallest loop around it: the smallest loop that a ray from the hole crosses an odd
// number of times.
void ProfileSweep::find_owners(double z) {
  struct Cut {
    Vec2 a, b;
    std::int32_t loop;
  };
  std::vector<Cut> cuts;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const RankedTriangle& r = ranked_[active_[i]];
    if (order_.point(r.low).z() >= z || order_.point(r.high).z() <= z) continue;
    const Chord chord = order_.point(r.middle).z() > z ? r.lower(order_) : r.upper(order_);
    if (chord.valid()) cuts.push_back({chord.p_at(z), chord.q_at(z), loop_of_active_[i]});
  }
  std::vector<char> odd(loops_.size());
  for (std::size_t l = 0; l < loops_.size(); ++l) {
    if (loops_[l].area >= 0) continue;
    const auto own = std::find_if(cuts.begin(), cuts.end(),
                                  [&](const Cut& c) { return c.loop == static_cast<std::int32_t>(l); });
    if (own == cuts.end()) continue;
    const Vec2 p = (own->a + own->b) / 2;
    std::fill(odd.begin(), odd.end(), 0);
    for (const Cut& c : cuts)
      if ((c.a.y() > p.y()) != (c.b.y() > p.y()) &&
          p.x() < (c.b.x() - c.a.x()) * (p.y() - c.a.y()) / (c.b.y() - c.a.y()) + c.a.x())
        odd[c.loop] ^= 1;
    for (std::size_t o = 0; o < loops_.size(); ++o)
      if (odd[o] && loops_[o].area > 0 &&
          (loops_[l].owner < 0 || loops_[o].area < loops_[loops_[l].owner].area))
        loops_[l].owner = o;
  }
}

}  // namespace terrazzo
