// Linear systems in which each cell of a voxel grid exchanges something with its six neighbors.
#pragma once

#include <memory>
#include <vector>

#include "nodes/properties/homogenize/cells.h"
#include "nodes/properties/homogenize/convergence.h"
#include "runtime/work.h"

namespace terrazzo::homogenize {

// The operator (A x)(i) = Σ g (x(i) − x(j)) + s(i) x(i) over the neighbors j of cell i.
struct Conductances {
  std::vector<float> face[3];  // g, of each cell, to the next cell along x, y and z; 0 if that is absent
  std::vector<float> sink;     // s; empty: zero everywhere
};

// How often a cycle visits the next coarser level. W where values of far cells depend on each other, as
// without sinks; V where sinks are everywhere near.
enum class Cycle { V = 1, W = 2 };

// A preconditioner for it: one cycle of multigrid on cells merged by 2 × 2 × 2, in single precision, with
// Gauss–Seidel sweeps in colors. It is symmetric and positive, and does not depend on the number of threads.
class Multigrid {
 public:
  Multigrid(std::shared_ptr<const std::vector<Cells>>, Conductances, Cycle, const Work&);

  const Cells& cells() const { return cells_->front(); }
  // g of the faces across an axis, as in Conductances.
  const std::vector<float>& face(int axis) const { return levels_[0].face[axis]; }
  // y = A x, in double precision. T: float or double.
  template <class T>
  void apply(const std::vector<T>& x, std::vector<double>& y, const Work&) const;
  // z ≈ A⁻¹ r, of equal size.
  void precondition(const std::vector<double>& r, std::vector<float>& z, const Work&);

  // Bytes that a system on these cells needs beside them.
  static double bytes(const std::vector<Cells>&, bool sink);

 private:
  struct Level {
    const Cells* cells = nullptr;
    std::vector<float> face[3], sink;
    std::vector<float> inverse;  // of the diagonal, 0 where that is 0
    std::vector<float> x, b;
  };
  Level level_of(const Cells&, Conductances, const Work&) const;
  static Conductances merged(const Level& fine, const Cells& coarse, const Work&);
  static void smooth(Level&, bool forward, const Work&);
  static void restrict_residual(const Level& fine, Level& coarse, const Work&);
  static void correct(Level& fine, const Level& coarse, const Work&);
  void cycle(std::size_t level, const Work&);

  std::shared_ptr<const std::vector<Cells>> cells_;
  std::vector<Level> levels_;
  int visits_;
};

// One step of conjugate gradients: its length, and how much of the last direction the next one takes.
struct Step {
  double length, kept;
};

// Solves A x = b by conjugate gradients, from zero. Stops when the residual is at most `tolerance`, and so is
// the error of energy − b·x relative to that difference, an effective value, as far as the preconditioner can
// tell; 0: no such value. Throws Error "not-converged" with the residual if the iterations do not suffice. A
// singular A needs a `b` without a component in its null space. `steps`: receives the steps, if it is not
// null.
Convergence solve(Multigrid&, const std::vector<double>& b, double energy, std::vector<double>& x,
                  const Accuracy&, const Work&, std::vector<Step>* steps = nullptr);

// A better preconditioner: a polynomial of cycles that leaves a share `rest` of the error, or more if that
// takes too many, by the iteration of Chebyshev (Saad 2003, algorithm 12.1). Unlike conjugate gradients, it
// is linear.
class Polynomial {
 public:
  Polynomial(std::unique_ptr<Multigrid>, double rest, const Work&);

  void precondition(const std::vector<double>& r, std::vector<float>& z, const Work&);

  static double bytes(const std::vector<Cells>&);  // beside the system's

 private:
  std::unique_ptr<Multigrid> system_;
  double low_, high_;  // eigenvalues of the system after one cycle
  int cycles_;
  std::vector<double> rest_, product_;
  std::vector<float> step_, cycle_;
};

}  // namespace terrazzo::homogenize
