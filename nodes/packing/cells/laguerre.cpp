#include "nodes/packing/cells/laguerre.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/packing/cells/cell_mesh.h"
#include "nodes/packing/cells/prescribed_volumes.h"
#include "nodes/packing/cells/sphere_seeds.h"
#include "nodes/packing/cells/split_edges.h"
#include "nodes/packing/cells/warp.h"
#include "runtime/random.h"

namespace terrazzo::tessellation {
namespace {

constexpr std::uint64_t kGaps = 0x67617073;
constexpr int kEnlargements = 12;     // rounds of enlarging cells for what gaps and edges take
constexpr double kWhole = 1e-6;       // volume fractions closer to 1 than this leave no binder
constexpr double kEdges = 0.15;       // longest edge of a rounded mesh, in grain diameters
constexpr double kRoughEdges = 0.13;  // the same of a rough one, in mean grain diameters

constexpr int kDoublings = 8;
constexpr double kWidestJoint = 0.4;  // of automatic gaps, in the smaller radius
// Effort of a plane's share in a norm, and of moving a face inward.
constexpr double kNormTests = 8, kShrinkTests = 500;

double diameter_of(double volume) { return std::cbrt(6 / std::numbers::pi * volume); }

class Laguerre {
 public:
  Laguerre(const Vec3& box, const std::vector<double>& volume, const LaguerreOptions& options, Effort& effort,
           const Work& work)
      : box_(box),
        wanted_(volume),
        options_(options),
        effort_(effort),
        work_(work),
        roundness_(options.roundness) {
    stretch_ = options.stretch / std::cbrt(options.stretch.prod());
    total_ = std::accumulate(volume.begin(), volume.end(), 0.0);
  }
  Grains run();

 private:
  Vec3 box_, stretch_;
  const std::vector<double>& wanted_;
  const LaguerreOptions& options_;
  Effort& effort_;
  const Work& work_;
  double total_ = 0;
  double roundness_;
  Seeds seeds_;                    // in the space in which grains are equiaxed
  std::vector<ConvexCell> cells_;  // in the space of the box
  std::vector<double> rounding_;   // share of its volume that a cell keeps when rounded

  bool shrinks() const {
    return roundness_ > 0 || options_.gap.value_or(total_ < (1 - kWhole) * box_.prod() ? 1 : 0) > 0;
  }
  void make_cells(const Work& work);
  double gap_of(std::size_t i, const Plane& plane, double gap) const;
  ConvexCell shrunk(std::size_t i, double gap) const;
  Mesh solid(const ConvexCell& cell, double longest_edge) const;
  void measure_rounding(double gap, const Work& work);
  std::vector<double> volumes(double gap, const Work& work) const;
  double fitting_gap(const Work& work) const;
  double excess_of(double gap, const Work& work) const;
  void limit_roundness(const Work& work);
};

// The cells of the seeds, stretched to the box.
void Laguerre::make_cells(const Work& work) {
  cells_ = power_diagram(seeds_, work);
  if (stretch_ == Vec3::Ones()) return;
  for (ConvexCell& c : cells_) {
    for (Vec3& p : c.corners) p = p.cwiseProduct(stretch_);
    for (Face& f : c.faces) f.normal = f.normal.cwiseQuotient(stretch_).normalized();
    c.centroid = c.centroid.cwiseProduct(stretch_);  // the volume stays: the stretch has determinant 1
  }
}

double Laguerre::gap_of(std::size_t i, const Plane& plane, double gap) const {
  if (plane.neighbor < 0) return gap;
  const std::size_t j = plane.neighbor;
  // A gap that is chosen leaves small grains most of their size.
  if (!options_.gap)
    gap = std::min(gap, kWidestJoint * std::cbrt(0.75 / std::numbers::pi * std::min(wanted_[i], wanted_[j])));
  if (options_.gap_variation == 0) return gap;
  const std::uint64_t low = std::min(i, j), high = std::max(i, j);
  return gap * (1 + options_.gap_variation * Random(mix64(options_.seed) ^ low, kGaps, high).uniform(-1, 1));
}

ConvexCell Laguerre::shrunk(std::size_t i, double gap) const {
  if (!(gap > 0)) return cells_[i];
  auto planes = planes_of(cells_[i]);
  double reach = 0;
  for (const Vec3& c : cells_[i].corners) reach = std::max(reach, c.cwiseAbs().maxCoeff());
  for (Plane& p : planes) p.offset -= 0.5 * gap_of(i, p, gap);
  return cell_between(planes, 1.01 * reach);
}

Mesh Laguerre::solid(const ConvexCell& cell, double longest_edge) const {
  Mesh mesh = cell_mesh(cell);
  if (longest_edge > 0) split_long_edges(mesh, longest_edge);
  round_edges(mesh, planes_of(cell), cell.centroid, roundness_);
  return mesh;
}

void Laguerre::measure_rounding(double gap, const Work& work) {
  rounding_.assign(cells_.size(), 1);
  if (roundness_ == 0) return;
  std::vector<double> tests(cells_.size(), 0);
  work.parallel(cells_.size(), 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (const ConvexCell c = shrunk(i, gap); c.volume > 0) {
        const Mesh mesh = solid(c, kEdges * diameter_of(c.volume));
        rounding_[i] = mesh_volume(mesh) / c.volume;
        tests[i] = kNormTests * (mesh.vertices.size() * c.faces.size());
      }
  });
  effort_.used += std::accumulate(tests.begin(), tests.end(), 0.0);
}

std::vector<double> Laguerre::volumes(double gap, const Work& work) const {
  std::vector<double> v(cells_.size());
  work.parallel(v.size(), 32, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) v[i] = rounding_[i] * shrunk(i, gap).volume;
  });
  for (const ConvexCell& c : cells_) effort_.used += kShrinkTests * c.faces.size();
  return v;
}

// Volume of all grains with this gap beyond what is wanted.
double Laguerre::excess_of(double gap, const Work& work) const {
  const auto v = volumes(gap, work);
  return std::accumulate(v.begin(), v.end(), 0.0) - total_;
}

// Makes edges sharper until the least gap leaves room for the grains.
void Laguerre::limit_roundness(const Work& work) {
  constexpr int kSteps = 7;  // to a hundredth
  const double most = std::exchange(roundness_, 0);
  if (!shrinks()) return;  // no binder
  measure_rounding(0, work);
  const double gap = options_.least_gap * fitting_gap(work);
  double low = 0, high = most;
  for (int k = 0; k <= kSteps && low < high && !(k > 2 && effort_.spent()); ++k) {
    roundness_ = k == 0 ? high : 0.5 * (low + high);
    measure_rounding(gap, work);
    (excess_of(gap, work) >= 0 ? low : high) = roundness_;
  }
  roundness_ = low;
}

// The gap at which all grains together have their volume.
double Laguerre::fitting_gap(const Work& work) const {
  const auto excess = [&](double gap) { return excess_of(gap, work); };
  double low = 0, above = excess(0);
  if (above <= 0) return 0;
  double high = 0.2 * std::cbrt(box_.prod() / cells_.size()), below = excess(high);
  for (int k = 0; below > 0; ++k) {
    if (k == kDoublings) return high;  // all gaps are as wide as the grains let them be
    low = high;
    above = below;
    high *= 2;
    below = excess(high);
  }
  for (int k = 0; k < 40 && above > 1e-6 * total_ && -below > 1e-6 * total_; ++k) {
    // The volume is nearly a cubic of the gap, so the secant is good; a share of bisection keeps both ends
    // moving.
    const double t = std::clamp(above / (above - below), 0.05, 0.95);
    const double mid = low + t * (high - low), e = excess(mid);
    (e > 0 ? low : high) = mid;
    (e > 0 ? above : below) = e;
  }
  return above < -below ? low : high;
}

Grains Laguerre::run() {
  Grains out;
  const std::size_t n = wanted_.size();
  const Vec3 even_box = box_.cwiseQuotient(stretch_);
  std::vector<double> cell_volume = wanted_;
  seeds_ = sphere_seeds(even_box, cell_volume, options_.seed, options_.seed_fraction, work_.part(0, 0.1));
  out.iterations =
      fit_round_cells(seeds_, cell_volume, options_.tolerance, options_.rounds, effort_, work_.part(0.1, 0.6))
          .iterations;
  const Work enlarging = work_.part(0.6, 0.8);
  for (int round = 0;; ++round) {
    make_cells(enlarging.quiet());
    for (std::size_t i = 0; i < n; ++i) cell_volume[i] = cells_[i].volume;
    if (round == 0 && roundness_ > 0 && options_.least_gap > 0 && !options_.gap)
      limit_roundness(enlarging.quiet());
    measure_rounding(out.gap, enlarging.quiet());
    out.gap = !shrinks() ? 0 : options_.gap ? *options_.gap : fitting_gap(enlarging.quiet());
    out.volume = volumes(out.gap, enlarging.quiet());
    const double factor = std::accumulate(out.volume.begin(), out.volume.end(), 0.0) / total_;
    out.worst = 0;
    std::size_t lost = 0;
    for (std::size_t i = 0; i < n; ++i) {
      out.worst = std::max(out.worst, std::abs(out.volume[i] / (factor * wanted_[i]) - 1));
      lost += out.volume[i] == 0;
      // A gap takes as much off the extent of a larger cell of the same shape.
      const double taken = std::cbrt(cell_volume[i]) - std::cbrt(out.volume[i]);
      cell_volume[i] = std::pow(std::cbrt(factor * wanted_[i]) + taken, 3);
    }
    const int last = effort_.spent() && lost == 0 ? round : kEnlargements;
    if (lost == n || (lost > 0 && round == last))
      throw Error(
          "gap-too-wide",
          fmt::format("{} of {} grains are thinner than the gap of {:.4g} mm", lost, n, out.gap),
          "lower `gap` or gap_variation, raise the volume fraction, or leave out the smallest classes")
          .parameter("gap");
    if (!shrinks() || out.worst <= options_.tolerance || round == last) break;
    enlarging.progress(static_cast<double>(round) / kEnlargements,
                       fmt::format("volumes within {:.2g}", out.worst));
    out.iterations +=
        fit_volumes(seeds_, cell_volume, 0.2 * options_.tolerance, effort_, enlarging.quiet()).iterations;
  }
  for (const ConvexCell& c : cells_) out.faces += static_cast<double>(c.faces.size()) / n;

  out.roundness = roundness_;
  const double mean = diameter_of(box_.prod() / n);
  const Warp warp(box_, mean, options_.roughness * mean, options_.seed);
  out.meshes.resize(n);
  work_.part(0.8, 1).parallel(n, 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ConvexCell cell = shrunk(i, out.gap);
      double edge = roundness_ > 0 ? kEdges * diameter_of(cell.volume) : 0;
      if (options_.roughness > 0) edge = edge > 0 ? std::min(edge, kRoughEdges * mean) : kRoughEdges * mean;
      Mesh& mesh = out.meshes[i] = solid(cell, edge);
      for (Vec3& v : mesh.vertices) {
        v += seeds_.position[i].cwiseProduct(stretch_);
        if (options_.roughness > 0) v = warp(v);
      }
    }
  });
  return out;
}

}  // namespace

Grains laguerre_grains(const Vec3& box, const std::vector<double>& volume, const LaguerreOptions& options,
                       Effort& effort, const Work& work) {
  return Laguerre(box, volume, options, effort, work).run();
}

}  // namespace terrazzo::tessellation
