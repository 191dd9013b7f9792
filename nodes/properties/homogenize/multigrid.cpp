#include "nodes/properties/homogenize/multigrid.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "nodes/properties/homogenize/vectors.h"
#include "runtime/random.h"

namespace terrazzo::homogenize {
namespace {

constexpr int kCoarsestSweeps = 16;
constexpr int kSweeps = 2;              // before and after each correction
constexpr double kLeastEnergy = 1e-12;  // of one step to the next, so that rounding leaves some
// The spectrum of a polynomial: tolerance of the solution from which it is read, share of noise in that, by
// how much its upper end is enlarged, and its least lower end, relative to the upper one.
constexpr double kSpectrum = 1e-3, kNoise = 0.1, kBeyond = 1.1, kNarrowest = 1e-6;
constexpr int kManySteps = 100'000;
constexpr double kMostCycles = 8;
// Merged cells conduct twice as well as they should, since the potential in each is constant. The correction
// is enlarged accordingly, by a little less than two (Braess 1995).
constexpr float kEnlarged = 1.9F;

// Σ g value(x(j)) over the neighbors j of cell i of a segment, of which `west` and `east` are those along x.
template <class Level, class T, class Value>
inline auto sum_of_neighbors(const Level& l, const Segment& s, std::size_t i, std::size_t west,
                             std::size_t east, const T* x, Value&& value) {
  const float *gx = l.face[0].data(), *gy = l.face[1].data(), *gz = l.face[2].data();
  const std::size_t at = s.at + i, south = s.south + i, below = s.below + i;
  return gx[west] * value(x[west]) + gx[at] * value(x[east]) + gy[south] * value(x[south]) +
         gy[at] * value(x[s.north + i]) + gz[below] * value(x[below]) + gz[at] * value(x[s.above + i]);
}

template <class Level>
inline float sum_of_neighbors(const Level& l, const Segment& s, std::size_t i, std::size_t west,
                              std::size_t east) {
  return sum_of_neighbors(l, s, i, west, east, l.x.data(), [](float v) { return v; });
}

// Calls visit(i, west, east) for cells i = first, first + step … of a segment.
template <class Visit>
inline void along(const Segment& s, std::size_t first, std::size_t step, Visit&& visit) {
  const std::size_t at = s.at, last = s.length - 1;
  std::size_t i = first;
  if (i == 0) {
    visit(0, s.west, last > 0 ? at + 1 : s.east);
    i = step;
  }
  for (; i < last; i += step) visit(i, at + i - 1, at + i + 1);
  if (i == last) visit(i, at + i - 1, s.east);
}

}  // namespace

double Multigrid::bytes(const std::vector<Cells>& levels, bool sink) {
  double values = 0;
  for (const Cells& cells : levels) values += static_cast<double>(cells.length());
  return (sink ? 28 : 24) * values;
}

Multigrid::Multigrid(std::shared_ptr<const std::vector<Cells>> cells, Conductances fine, Cycle cycle,
                     const Work& work)
    : cells_(std::move(cells)), visits_(static_cast<int>(cycle)) {
  levels_.push_back(level_of(cells_->front(), std::move(fine), work));
  for (std::size_t k = 1; k < cells_->size(); ++k)
    levels_.push_back(level_of((*cells_)[k], merged(levels_.back(), (*cells_)[k], work), work));
}

Multigrid::Level Multigrid::level_of(const Cells& cells, Conductances c, const Work& work) const {
  Level l;
  l.cells = &cells;
  for (int a = 0; a < 3; ++a) l.face[a] = std::move(c.face[a]);
  l.sink = std::move(c.sink);
  for (auto* values : {&l.inverse, &l.x, &l.b}) values->assign(cells.length(), 0);
  each_segment(cells, work, [&](const Segment& s, int) {
    along(s, 0, 1, [&](std::size_t i, std::size_t west, std::size_t east) {
      const float sum = sum_of_neighbors(l, s, i, west, east, l.x.data(), [](float) { return 1.0F; }) +
                        (l.sink.empty() ? 0 : l.sink[s.at + i]);
      l.inverse[s.at + i] = sum > 0 ? 1 / sum : 0;
    });
  });
  return l;
}

// Faces inside of a merged cell disappear, the others add up.
Conductances Multigrid::merged(const Level& fine, const Cells& coarse, const Work& work) {
  Conductances out;
  for (auto& f : out.face) f.assign(coarse.length(), 0);
  if (!fine.sink.empty()) out.sink.assign(coarse.length(), 0);
  const Vec3i& n = fine.cells->size();
  const auto leaves = [&](int axis, int at) { return at % 2 == 1 || at == n[axis] - 1; };
  each_child(*fine.cells, coarse, work, [&](const Segment& s, int z) {
    for (int i = 0; i < s.length; ++i) {
      const std::size_t from = s.at + i, to = s.parent + (s.x % 2 + i) / 2;
      if (leaves(0, s.x + i)) out.face[0][to] += fine.face[0][from];
      if (leaves(1, s.y)) out.face[1][to] += fine.face[1][from];
      if (leaves(2, z)) out.face[2][to] += fine.face[2][from];
      if (!fine.sink.empty()) out.sink[to] += fine.sink[from];
    }
  });
  return out;
}

// One sweep of Gauss–Seidel, color by color. Neighbors have different colors: that of the sum of their
// coordinates, and others on the last plane of an axis that wraps around an odd number of cells.
void Multigrid::smooth(Level& l, bool forward, const Work& work) {
  const int colors = 2 * (l.cells->seams() + 1);
  for (int k = 0; k < colors; ++k) {
    const int color = forward ? k : colors - 1 - k, parity = color % 2, seams = color / 2;
    each_segment(*l.cells, work, [&](const Segment& s, int z) {
      if (s.seams != seams) return;
      along(s, (s.x + s.y + z + parity) % 2, 2, [&](std::size_t i, std::size_t west, std::size_t east) {
        l.x[s.at + i] = (l.b[s.at + i] + sum_of_neighbors(l, s, i, west, east)) * l.inverse[s.at + i];
      });
    });
  }
}

void Multigrid::restrict_residual(const Level& fine, Level& coarse, const Work& work) {
  std::fill(coarse.b.begin(), coarse.b.end(), 0);
  each_child(*fine.cells, *coarse.cells, work, [&](const Segment& s, int) {
    along(s, 0, 1, [&](std::size_t i, std::size_t west, std::size_t east) {
      const float inverse = fine.inverse[s.at + i];
      if (inverse > 0)
        coarse.b[s.parent + (s.x % 2 + i) / 2] +=
            fine.b[s.at + i] + sum_of_neighbors(fine, s, i, west, east) - fine.x[s.at + i] / inverse;
    });
  });
}

void Multigrid::correct(Level& fine, const Level& coarse, const Work& work) {
  each_segment(*fine.cells, work, [&](const Segment& s, int) {
    for (int i = 0; i < s.length; ++i) fine.x[s.at + i] += kEnlarged * coarse.x[s.parent + (s.x % 2 + i) / 2];
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
  for (int k = 0; k < visits_; ++k) cycle(level + 1, work);
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
  each_segment(*l.cells, work, [&](const Segment& s, int) {
    along(s, 0, 1, [&](std::size_t i, std::size_t west, std::size_t east) {
      const double v = x[s.at + i];
      y[s.at + i] = sum_of_neighbors(l, s, i, west, east, x.data(), [&](T there) { return v - there; });
    });
    if (!l.sink.empty())
      for (std::size_t i = s.at; i < static_cast<std::size_t>(s.at) + s.length; ++i) y[i] += l.sink[i] * x[i];
  });
}
template void Multigrid::apply(const std::vector<float>&, std::vector<double>&, const Work&) const;
template void Multigrid::apply(const std::vector<double>&, std::vector<double>&, const Work&) const;

Convergence solve(Multigrid& system, const std::vector<double>& b, double energy, std::vector<double>& x,
                  const Accuracy& accuracy, const Work& work, std::vector<Step>* steps) {
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
    if (steps) steps->push_back({alpha, beta});
    each(n, work, [&](std::size_t i) {
      x[i] += alpha * p[i];
      r[i] -= alpha * q[i];
    });
    energy = std::max(energy - alpha * rz, kLeastEnergy * energy);
  }
}

namespace {

// Smallest and largest eigenvalue of a system after its preconditioner, nearly, from steps of conjugate
// gradients (Saad 2003, section 6.7.3).
Eigen::Vector2d ends_of_spectrum(const std::vector<Step>& steps) {
  const Eigen::Index n = static_cast<Eigen::Index>(steps.size());
  Eigen::VectorXd diagonal(n), beside(n - 1);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Step& step = steps[k];
    diagonal[k] = 1 / step.length;
    if (k == 0) continue;
    diagonal[k] += step.kept / steps[k - 1].length;
    beside[k - 1] = std::sqrt(step.kept) / steps[k - 1].length;
  }
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, beside, Eigen::EigenvaluesOnly);
  return {solver.eigenvalues()[0], solver.eigenvalues()[n - 1]};
}

}  // namespace

Polynomial::Polynomial(std::unique_ptr<Multigrid> system, double rest, const Work& work)
    : system_(std::move(system)) {
  const std::size_t n = system_->cells().length();
  std::vector<double> slope(n, 0), x;
  rest_.assign(n, 0);
  product_.assign(n, 0);
  step_.assign(n, 0);
  cycle_.assign(n, 0);
  // A mean slope along all axes, whose solution has long parts, and noise, which has all others.
  each_segment(system_->cells(), work, [&](const Segment& s, int) {
    for (int i = 0; i < s.length; ++i) {
      step_[s.at + i] = static_cast<float>(Random(1, 1, s.at + i).uniform() - 0.5);
      for (int a = 0; a < 3; ++a)
        slope[s.at + i] +=
            static_cast<double>(system_->face(a)[s.at + i]) - system_->face(a)[s.previous(a, i)];
    }
  });
  system_->apply(step_, product_, work);
  const double noise = std::sqrt(dot(product_, product_, work)), whole = std::sqrt(dot(slope, slope, work));
  const double share = noise > 0 && whole > 0 ? kNoise * whole / noise : 1;
  each(n, work, [&](std::size_t i) { slope[i] += share * product_[i]; });
  std::vector<Step> steps;
  solve(*system_, slope, 0, x, {kSpectrum, kManySteps}, work.quiet(), &steps);
  const Eigen::Vector2d ends = steps.empty() ? Eigen::Vector2d(1, 1) : ends_of_spectrum(steps);
  high_ = kBeyond * ends[1];
  low_ = std::max(ends[0], kNarrowest * high_);
  const double middle = (high_ + low_) / (high_ - low_);
  const double needed = std::ceil(std::acosh(1 / rest) / std::acosh(middle));
  cycles_ = static_cast<int>(std::clamp(needed, 1.0, kMostCycles));
}

double Polynomial::bytes(const std::vector<Cells>& levels) {
  return 24.0 * static_cast<double>(levels.front().length());
}

void Polynomial::precondition(const std::vector<double>& r, std::vector<float>& z, const Work& work) {
  const double middle = (high_ + low_) / 2, half = (high_ - low_) / 2;
  double rho = half / middle;
  system_->precondition(r, cycle_, work);
  each(r.size(), work, [&](std::size_t i) {
    rest_[i] = r[i];
    step_[i] = z[i] = static_cast<float>(cycle_[i] / middle);
  });
  for (int k = 1; k < cycles_; ++k) {
    system_->apply(step_, product_, work);
    each(r.size(), work, [&](std::size_t i) { rest_[i] -= product_[i]; });
    system_->precondition(rest_, cycle_, work);
    const double next = 1 / (2 * middle / half - rho), kept = next * rho, fresh = 2 * next / half;
    rho = next;
    each(r.size(), work, [&](std::size_t i) {
      step_[i] = static_cast<float>(kept * step_[i] + fresh * cycle_[i]);
      z[i] += step_[i];
    });
  }
}

}  // namespace terrazzo::homogenize
