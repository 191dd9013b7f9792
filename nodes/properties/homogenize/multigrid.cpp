#include "nodes/properties/homogenize/multigrid.h"

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "nodes/properties/homogenize/vectors.h"

namespace terrazzo::homogenize {
namespace {

constexpr int kFewest = 4;  // cells along each axis of the coarsest level
constexpr int kCoarsestSweeps = 16;
constexpr int kSweeps = 2;              // before and after each correction
constexpr double kLeastEnergy = 1e-12;  // of one step to the next, so that rounding leaves some
constexpr int kVisits = 2;              // of the coarser level: a W-cycle
// Merged cells conduct twice as well as they should, since the potential in each is constant. The correction
// is enlarged accordingly, by a little less than two (Braess 1995).
constexpr float kEnlarged = 1.9F;

std::size_t grain_of(const Vec3i& size) {  // planes of one range: at least 2¹⁵ cells
  return std::max<std::size_t>(1, (1 << 15) / pixels_in(size.x(), size.y()));
}

// The rows of a level: where the neighbors of row (y, z) begin.
struct Row {
  std::size_t at, south, north, below, above;
  Row(const Vec3i& n, int y, int z) {
    at = voxel_at(0, y, z, n);
    south = voxel_at(0, y == 0 ? n.y() - 1 : y - 1, z, n);
    north = voxel_at(0, y == n.y() - 1 ? 0 : y + 1, z, n);
    below = voxel_at(0, y, z == 0 ? n.z() - 1 : z - 1, n);
    above = voxel_at(0, y, z == n.z() - 1 ? 0 : z + 1, n);
  }
};

// Σ g x(j) over the neighbors of cell x of a row, of which `west` and `east` are the neighbors along x.
template <class Level, class Values>
inline auto neighbors(const Level& l, const Values& v, const Row& row, int x, int west, int east) {
  const float *gx = l.face[0].data(), *gy = l.face[1].data(), *gz = l.face[2].data();
  return gx[row.at + west] * v[row.at + west] + gx[row.at + x] * v[row.at + east] +
         gy[row.south + x] * v[row.south + x] + gy[row.at + x] * v[row.north + x] +
         gz[row.below + x] * v[row.below + x] + gz[row.at + x] * v[row.above + x];
}

// Calls visit(x, west, east) for x = first, first + step … below n.
template <class Visit>
inline void along_row(int n, int first, int step, Visit&& visit) {
  int x = first;
  if (x == 0 && n > 0) {
    visit(0, n - 1, n > 1 ? 1 : 0);
    x = step;
  }
  for (; x < n - 1; x += step) visit(x, x - 1, x + 1);
  if (x == n - 1) visit(x, x - 1, 0);
}

}  // namespace

double Multigrid::bytes(const Vec3i& size) {
  double cells = 0;
  for (Vec3i n = size;; n = (n.array() + 1) / 2) {
    cells += voxels_in(n);
    if (n.maxCoeff() <= kFewest) return 28 * cells;
  }
}

Multigrid::Multigrid(Conductances fine, const Work& work) {
  Level first;
  first.size = fine.size;
  for (int a = 0; a < 3; ++a) first.face[a] = std::move(fine.face[a]);
  first.sink = std::move(fine.sink);
  levels_.push_back(std::move(first));
  while (levels_.back().size.maxCoeff() > kFewest) levels_.push_back(coarser(levels_.back(), work));
  for (Level& l : levels_) {
    set_inverse(l, work);
    l.x.resize(voxels_in(l.size));
    l.b.resize(voxels_in(l.size));
  }
}

void Multigrid::set_inverse(Level& l, const Work& work) {
  l.inverse.resize(voxels_in(l.size));
  work.parallel(l.size.z(), grain_of(l.size), [&](std::size_t begin, std::size_t end) {
    const struct {
      float operator[](std::size_t) const { return 1; }
    } ones;
    for (int z = begin, stop = end; z < stop; ++z)
      for (int y = 0; y < l.size.y(); ++y) {
        const Row row(l.size, y, z);
        along_row(l.size.x(), 0, 1, [&](int x, int west, int east) {
          const float sum =
              neighbors(l, ones, row, x, west, east) + (l.sink.empty() ? 0 : l.sink[row.at + x]);
          l.inverse[row.at + x] = sum > 0 ? 1 / sum : 0;
        });
      }
  });
}

Multigrid::Level Multigrid::coarser(const Level& fine, const Work& work) {
  Level out;
  for (int a = 0; a < 3; ++a) out.size[a] = fine.size[a] > 1 ? (fine.size[a] + 1) / 2 : 1;
  const std::size_t count = voxels_in(out.size);
  for (auto& f : out.face) f.assign(count, 0);
  if (!fine.sink.empty()) out.sink.assign(count, 0);
  work.parallel(out.size.z(), grain_of(out.size), [&](std::size_t begin, std::size_t end) {
    for (int z = 2 * begin; z < std::min<int>(2 * end, fine.size.z()); ++z)
      for (int y = 0; y < fine.size.y(); ++y)
        for (int x = 0; x < fine.size.x(); ++x) {
          const std::size_t from = voxel_at(x, y, z, fine.size), to = voxel_at(x / 2, y / 2, z / 2, out.size);
          const Vec3i at(x, y, z);
          for (int a = 0; a < 3; ++a)  // faces inside of a merged cell disappear
            if (at[a] % 2 == 1 || at[a] == fine.size[a] - 1) out.face[a][to] += fine.face[a][from];
          if (!fine.sink.empty()) out.sink[to] += fine.sink[from];
        }
  });
  return out;
}

// One sweep of Gauss–Seidel, color by color. Neighbors have different colors: that of the sum of their
// coordinates, and others on the last plane of an axis with an odd number of cells, whose next plane is the
// first.
void Multigrid::smooth(Level& l, bool forward, const Work& work) {
  const Vec3i& n = l.size;
  int odd = 0;
  for (int a = 0; a < 3; ++a) odd += n[a] > 1 && n[a] % 2 == 1;
  const auto last = [&](int a, int at) { return n[a] > 1 && n[a] % 2 == 1 && at == n[a] - 1; };
  const int colors = 2 * (odd + 1);
  for (int k = 0; k < colors; ++k) {
    const int color = forward ? k : colors - 1 - k, parity = color % 2, seams = color / 2;
    work.parallel(n.z(), grain_of(n), [&](std::size_t begin, std::size_t end) {
      for (int z = begin, stop = end; z < stop; ++z)
        for (int y = 0; y < n.y(); ++y) {
          const int count = last(1, y) + last(2, z), offset = (y + z + parity) % 2;
          const Row row(n, y, z);
          const auto update = [&](int x, int west, int east) {
            l.x[row.at + x] =
                (l.b[row.at + x] + neighbors(l, l.x, row, x, west, east)) * l.inverse[row.at + x];
          };
          const bool seam = n.x() > 1 && n.x() % 2 == 1;
          if (!seam) {
            if (count == seams) along_row(n.x(), offset, 2, update);
          } else if (count == seams) {
            for (int x = offset; x < n.x() - 1; x += 2) update(x, x == 0 ? n.x() - 1 : x - 1, x + 1);
          } else if (count + 1 == seams && offset == 0) {
            update(n.x() - 1, n.x() - 2, 0);
          }
        }
    });
  }
}

void Multigrid::restrict_residual(const Level& fine, Level& coarse, const Work& work) {
  const Vec3i &n = fine.size, &m = coarse.size;
  work.parallel(m.z(), grain_of(m), [&](std::size_t begin, std::size_t end) {
    std::fill(coarse.b.begin() + begin * pixels_in(m.x(), m.y()),
              coarse.b.begin() + end * pixels_in(m.x(), m.y()), 0);
    std::vector<float> residual(n.x());
    for (int z = 2 * begin; z < std::min<int>(2 * end, n.z()); ++z)
      for (int y = 0; y < n.y(); ++y) {
        const Row row(n, y, z);
        along_row(n.x(), 0, 1, [&](int x, int west, int east) {
          const std::size_t i = row.at + x;
          const float inverse = fine.inverse[i];
          residual[x] =
              inverse > 0 ? fine.b[i] + neighbors(fine, fine.x, row, x, west, east) - fine.x[i] / inverse : 0;
        });
        float* to = coarse.b.data() + voxel_at(0, y / 2, z / 2, m);
        for (int x = 0; x < n.x(); ++x) to[x / 2] += residual[x];
      }
  });
}

void Multigrid::correct(Level& fine, const Level& coarse, const Work& work) {
  const Vec3i& n = fine.size;
  work.parallel(n.z(), grain_of(n), [&](std::size_t begin, std::size_t end) {
    for (int z = begin, stop = end; z < stop; ++z)
      for (int y = 0; y < n.y(); ++y) {
        float* to = fine.x.data() + voxel_at(0, y, z, n);
        const float* from = coarse.x.data() + voxel_at(0, y / 2, z / 2, coarse.size);
        for (int x = 0; x < n.x(); ++x) to[x] += kEnlarged * from[x / 2];
      }
  });
}

void Multigrid::cycle(std::size_t level, const Work& work) {
  Level& l = levels_[level];
  if (level + 1 == levels_.size()) {
    for (int k = 0; k < kCoarsestSweeps; ++k) smooth(l, true, work);
    for (int k = 0; k < kCoarsestSweeps; ++k) smooth(l, false, work);
    return;
  }
  for (int k = 0; k < kSweeps; ++k) smooth(l, true, work);
  restrict_residual(l, levels_[level + 1], work);
  std::fill(levels_[level + 1].x.begin(), levels_[level + 1].x.end(), 0);
  for (int k = 0; k < kVisits; ++k) cycle(level + 1, work);
  correct(l, levels_[level + 1], work);
  for (int k = 0; k < kSweeps; ++k) smooth(l, false, work);
}

void Multigrid::precondition(const std::vector<double>& r, std::vector<float>& z, const Work& work) {
  Level& l = levels_[0];
  each(r.size(), work, [&](std::size_t i) {
    l.b[i] = r[i];
    l.x[i] = 0;
  });
  cycle(0, work.quiet());
  each(r.size(), work, [&](std::size_t i) { z[i] = l.x[i]; });
}

template <class T>
void Multigrid::apply(const std::vector<T>& x, std::vector<double>& y, const Work& work) const {
  const Level& l = levels_[0];
  const Vec3i& n = l.size;
  work.quiet().parallel(n.z(), grain_of(n), [&](std::size_t begin, std::size_t end) {
    const float *gx = l.face[0].data(), *gy = l.face[1].data(), *gz = l.face[2].data();
    for (int z = begin, stop = end; z < stop; ++z)
      for (int j = 0; j < n.y(); ++j) {
        const Row row(n, j, z);
        along_row(n.x(), 0, 1, [&](int i, int west, int east) {
          const double v = x[row.at + i];
          const double sum =
              gx[row.at + west] * (v - x[row.at + west]) + gx[row.at + i] * (v - x[row.at + east]) +
              gy[row.south + i] * (v - x[row.south + i]) + gy[row.at + i] * (v - x[row.north + i]) +
              gz[row.below + i] * (v - x[row.below + i]) + gz[row.at + i] * (v - x[row.above + i]);
          y[row.at + i] = sum;
        });
        if (!l.sink.empty())
          for (int i = 0; i < n.x(); ++i) y[row.at + i] += l.sink[row.at + i] * x[row.at + i];
      }
  });
}
template void Multigrid::apply(const std::vector<float>&, std::vector<double>&, const Work&) const;
template void Multigrid::apply(const std::vector<double>&, std::vector<double>&, const Work&) const;

Convergence solve(Multigrid& system, const std::vector<double>& b, double energy, std::vector<double>& x,
                  const Accuracy& accuracy, const Work& work) {
  const std::size_t n = b.size();
  std::vector<double> r = b, p(n, 0), q(n);
  std::vector<float> z(n);
  x.assign(n, 0);
  const double whole = std::sqrt(dot(b, b, work));
  Convergence out;
  double before = 0;
  const bool checks = energy > 0;
  for (;; ++out.iterations) {
    out.residual = whole > 0 ? std::sqrt(dot(r, r, work)) / whole : 0;
    report(out, accuracy.tolerance, work);
    if (out.residual == 0) return out;
    system.precondition(r, z, work);
    const double rz = dot(r, z, work);  // about the square of the error, in the norm of the energy
    if (out.residual <= accuracy.tolerance && (!checks || rz <= accuracy.tolerance * energy)) return out;
    if (out.iterations == accuracy.iterations || !std::isfinite(rz))
      throw stalled({out.iterations, std::max(out.residual, checks ? rz / energy : 0)}, accuracy.tolerance);
    const double beta = before > 0 ? rz / before : 0;
    before = rz;
    each(n, work, [&](std::size_t i) { p[i] = z[i] + beta * p[i]; });
    system.apply(p, q, work);
    const double alpha = rz / dot(p, q, work);
    if (!std::isfinite(alpha)) throw stalled(out, accuracy.tolerance);
    each(n, work, [&](std::size_t i) {
      x[i] += alpha * p[i];
      r[i] -= alpha * q[i];
    });
    energy = std::max(energy - alpha * rz, kLeastEnergy * energy);
  }
}

}  // namespace terrazzo::homogenize
