#include "nodes/packing/cells/fill_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/directions.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/indices.h"
#include "nodes/packing/cells/grow.h"
#include "nodes/packing/cells/section_fit.h"
#include "nodes/packing/rigid/placement.h"
#include "nodes/packing/rigid/schedule.h"
#include "runtime/random.h"

namespace terrazzo::tessellation {
namespace {

constexpr std::uint64_t kAxes = 0x61786573;
constexpr int kWantedSections = 12000;  // of all shapes together, for the profiles that are wanted
constexpr double kFilm = 0.45;          // largest share of the binder that is film between sharp particles
constexpr int kShownSections = 30000;   // of all particles together
// Steps of packing before growth, times particles, and the fewest steps.
constexpr double kPackedSteps = 600 * 2500, kFewestSteps = 60;
// Effort of a contact test, and of a triangle of the result that is added, sectioned once and measured.
constexpr double kContactTest = 60, kSphereTest = 6, kAdd = 600, kSection = 15, kMeasure = 2200;
constexpr double kCutTriangles = 2.7;  // triangles after growth, for each before

// A crystal whose z axis is within a normal distribution of tilts about the box's z axis.
Quat fiber_rotation(Random& r, double spread) {
  constexpr double kDegree = std::numbers::pi / 180;
  const double tilt = spread * kDegree * std::sqrt(-2 * std::log(1 - r.uniform())),
               towards = 2 * std::numbers::pi * r.uniform(), spin = 2 * std::numbers::pi * r.uniform();
  const Vec3 axis(std::cos(towards), std::sin(towards), 0);
  return Quat(Eigen::AngleAxisd(tilt, axis) * Eigen::AngleAxisd(spin, Vec3::UnitZ()));
}

class Filler {
 public:
  Filler(const SizeDistribution& distribution, const Shapes& shapes, const FillOptions& options)
      : shapes_(shapes), options_(options), distribution_(distribution) {
    options_.population.fills_space = true;
    effort_.limit = options.effort;
  }
  FillResult run(const Work& work);
  // After a cancellation: calls options.interrupted with what there is.
  void hand_over();

 private:
  const Shapes& shapes_;
  FillOptions options_;
  SizeDistribution distribution_;
  packing::Population population_;
  FillResult result_;
  bool thinned_ = false;                        // whether the gap had to be smaller
  std::vector<packing::ContactShape> contact_;  // of the shapes that were needed so far
  GrowthShapes growing_;
  Effort effort_;
  bool ended_early_ = false;  // the last filling, since the effort was spent
  bool complete_ = false;     // whether result_ has all particles and shapes
  bool packed_ = false;       // whether the particles of population_ are packed

  void populate(const Work& work);
  void fill(const Work& work);
  void fill_by_laguerre(const Work& work);
  void fill_by_growth(const Work& work);
  double growth_gap();
  void pack_cores(double factor, const Work& work);
  void add(std::vector<Mesh>& meshes, const Work& work);
  void measure_sizes(const Work& work);
  void correct_sizes(const Particles& first, const std::vector<int>& first_class, const Work& work);
  Eigen::MatrixXd shown(const Work& work);
  std::size_t triangles() const;  // of the result
};

void Filler::populate(const Work& work) {
  packed_ = false;
  population_ = packing::populate(distribution_, shapes_, nullptr, options_.population, work);
  const Particles& p = population_.particles;
  result_.wanted.clear();
  for (std::size_t i = 0; i < p.count(); ++i)
    result_.wanted.push_back(shapes_.shapes[p.shape[i]].volume * std::pow(p.scale[i], 3));
  // Counts are whole numbers, so the sum may be slightly off.
  const double sum = std::accumulate(result_.wanted.begin(), result_.wanted.end(), 0.0);
  for (double& v : result_.wanted) v *= population_.target_fraction * p.box.prod() / sum;
}

// Makes particle shapes of meshes in the coordinates of the box (Laguerre) or about the positions (growth).
void Filler::add(std::vector<Mesh>& meshes, const Work& work) {
  complete_ = false;
  const Particles& from = population_.particles;
  Particles& p = result_.particles = from;
  const bool placed = options_.method == Method::Laguerre;
  result_.shapes.shapes.assign(meshes.size(), {});
  work.parallel(meshes.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Mesh mesh = std::move(meshes[i]);
      if (const auto faults = mesh_faults(mesh); !faults.empty())
        throw Error("open-mesh", fmt::format("the surface of grain {} is not closed: {}", i, faults.front()),
                    "change `seed`");
      if (placed) p.orientation[i] = Quat::Identity();
      Random random(options_.population.seed, kAxes, i);
      if (options_.axes == CrystalAxes::Uniform) p.orientation[i] = random_rotation(random);
      if (options_.axes == CrystalAxes::Fiber) p.orientation[i] = fiber_rotation(random, options_.spread);
      const Vec3 centroid = mesh_centroid(mesh);
      p.position[i] = wrap_point(placed ? centroid : Vec3(from.position[i] + centroid), p.box);
      const Mat3 back = p.orientation[i].toRotationMatrix().transpose();
      transform(mesh, back, -back * centroid);
      Shape& s = result_.shapes.shapes[i];
      s.name = fmt::format("grain {}", i + 1);
      s.probability = 1.0 / static_cast<double>(meshes.size());
      s.volume = mesh_volume(mesh);
      s.surface_area = mesh_surface_area(mesh);
      s.mean_caliper = mesh_mean_caliper(mesh);
      s.smooth = !placed && shapes_.shapes[from.shape[i]].smooth;
      s.mesh = std::move(mesh);
      p.shape[i] = static_cast<std::int32_t>(i);
      p.scale[i] = 1;
    }
  });
  complete_ = true;
  effort_.used += kAdd * static_cast<double>(triangles());
}

// Measures that only the result needs.
void Filler::measure_sizes(const Work& work) {
  effort_.used += kMeasure * static_cast<double>(triangles());
  work.parallel(result_.shapes.shapes.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Shape& s = result_.shapes.shapes[i];
      s.max_section_area = quick_max_section_area(s.mesh);
      result_.particles.size[i] = s.size();
    }
  });
}

void Filler::fill_by_laguerre(const Work& work) {
  Grains grains =
      laguerre_grains(population_.particles.box, result_.wanted, options_.grains, effort_, work.part(0, 0.8));
  ended_early_ = effort_.spent();
  result_.gap = grains.gap;
  result_.faces = grains.faces;
  result_.roundness = grains.roundness;
  add(grains.meshes, work.part(0.8, 1));
}

// Packs the particles at `factor` of their size; overlaps that remain are cut by growth.
void Filler::pack_cores(double factor, const Work& work) {
  Particles& p = population_.particles;
  contact_.resize(shapes_.shapes.size());
  for (std::int32_t s : p.shape)
    if (contact_[s].bounding_radius == 0)
      contact_[s] = packing::make_contact_shape(shapes_.shapes[s].mesh, work.quiet());
  packing::Packing packed;
  packed.box = p.box;
  packed.shape = p.shape;
  packed.position = p.position;
  packed.orientation = p.orientation;
  std::vector<double> radius;
  for (std::size_t i = 0; i < p.count(); ++i) {
    packed.scale.push_back(factor * p.scale[i]);
    packed.size.push_back(factor * p.size[i]);
    radius.push_back(std::cbrt(0.75 / std::numbers::pi * shapes_.shapes[p.shape[i]].volume) *
                     packed.scale[i]);
  }
  packing::place_at_random(packed, 0, radius, options_.population.seed, work.quiet());
  packing::AnnealOptions anneal;
  anneal.seed = options_.population.seed;
  anneal.enough = 0.9;
  anneal.overlaps = true;
  packing::Budget budget;
  // Fewer steps for more particles; overlaps that remain are cut by growth.
  budget.limit = std::min<double>(options_.iterations,
                                  std::max(kFewestSteps, kPackedSteps / static_cast<double>(p.count())));
  packing::pack(contact_, packed, anneal, budget, work);
  const bool spheres = std::all_of(contact_.begin(), contact_.end(),
                                   [](const auto& s) { return s.bounding_radius == 0 || s.ball > 0; });
  effort_.used += (spheres ? kSphereTest : kContactTest) * packing::Budget::kTestsPerBody * budget.used *
                  static_cast<double>(p.count());
  p.position = packed.position;
  p.orientation = packed.orientation;
  for (std::size_t i = 0; i < p.count(); ++i) p.scale[i] = packed.scale[i] * packed.shrink;
  packed_ = true;
  result_.packed_fraction = population_.target_fraction * std::pow(factor * packed.shrink, 3);
}

// The gap of growth. Films as thick as that which all the binder would make leave no room to grow.
double Filler::growth_gap() {
  const double wanted = options_.grains.gap.value_or(0);
  const Particles& p = population_.particles;
  double surface = 0;  // at full size
  const double factor = std::pow(population_.target_fraction / result_.packed_fraction, 2.0 / 3);
  for (std::size_t i = 0; i < p.count(); ++i)
    surface += factor * shapes_.shapes[p.shape[i]].surface_area * p.scale[i] * p.scale[i];
  // The rounder edges are, the more of the binder is between them.
  const double film = kFilm * (1 - options_.grains.roundness);
  const double most = film * 2 * (1 - population_.target_fraction) * p.box.prod() / surface;
  if (wanted > most && !thinned_) {
    thinned_ = true;
    result_.notes.push_back(fmt::format(
        "the gap of {:.3g} mm would need more binder than there is; {:.3g} mm is used", wanted, most));
  }
  return std::min(wanted, most);
}

void Filler::fill_by_growth(const Work& work) {
  const double factor = std::min(1.0, std::cbrt(options_.start_fraction / population_.target_fraction));
  pack_cores(factor, work.part(0, 0.4));
  GrowOptions grow_options;
  grow_options.gap = result_.gap = growth_gap();
  grow_options.gap_variation = options_.grains.gap_variation;
  grow_options.roundness = result_.roundness = options_.grains.roundness;
  grow_options.seed = options_.population.seed;
  growing_.prepare(shapes_, population_.particles, work.quiet());
  effort_.limit =
      options_.effort - kCutTriangles * (kAdd + kMeasure) * static_cast<double>(growing_.triangles());
  Grown grown =
      grow(growing_, population_.particles, result_.wanted, grow_options, effort_, work.part(0.4, 0.9));
  ended_early_ = effort_.spent();
  result_.flat = grown.flat;
  add(grown.meshes, work.part(0.9, 1));
}

void Filler::fill(const Work& work) {
  if (options_.method == Method::Laguerre)
    fill_by_laguerre(work);
  else
    fill_by_growth(work);
  result_.size_class = population_.size_class;
  double sum = 0, wanted = 0;
  for (std::size_t i = 0; i < result_.wanted.size(); ++i) {
    sum += result_.shapes.shapes[i].volume;
    wanted += result_.wanted[i];
  }
  result_.fraction = sum / result_.particles.box.prod();
  result_.worst = result_.mean_error = 0;
  for (std::size_t i = 0; i < result_.wanted.size(); ++i) {
    const double error = std::abs(result_.shapes.shapes[i].volume / result_.wanted[i] * wanted / sum - 1);
    result_.worst = std::max(result_.worst, error);
    result_.mean_error += error / static_cast<double>(result_.wanted.size());
  }
}

std::size_t Filler::triangles() const {
  std::size_t sum = 0;
  for (const Shape& s : result_.shapes.shapes) sum += s.mesh.triangles.size();
  return sum;
}

Eigen::MatrixXd Filler::shown(const Work& work) {
  const int each = std::max(4, kShownSections / static_cast<int>(result_.particles.count()));
  effort_.used += kSection * each * static_cast<double>(triangles());
  return profile_densities(result_.shapes, result_.particles, result_.size_class, distribution_.class_edges,
                           each, options_.population.seed, work);
}

// Corrects the sizes until sections show the profiles that the distribution stands for, as far as the effort
// allows.
void Filler::correct_sizes(const Particles& first, const std::vector<int>& first_class, const Work& work) {
  const int each = std::max(40, kWantedSections / count_of(shapes_.shapes));
  const Eigen::VectorXd wanted = profile_densities(shapes_, first, first_class, distribution_.class_edges,
                                                   each, options_.population.seed, work.quiet())
                                     .colwise()
                                     .sum();
  Eigen::MatrixXd now = shown(work.quiet());
  result_.misfit_before = misfit(wanted, now.colwise().sum());
  const Vec3& edges = result_.particles.box;
  result_.misfit_by_chance = sampling_misfit(wanted, wanted.sum() * std::pow(edges.prod(), 2.0 / 3));
  result_.misfit_after = result_.misfit_before;
  double last = effort_.used;  // by the last filling
  // Less than half of what one section would show by chance needs no correction.
  for (int k = 0; k < options_.corrections && result_.misfit_after > 0.5 * result_.misfit_by_chance; ++k) {
    const double before = effort_.used;
    if (before + last > effort_.limit) {
      result_.notes.push_back(fmt::format(
          "the sizes were corrected {} time{} instead of {}: more would take too long for {} particles", k,
          k == 1 ? "" : "s", options_.corrections, population_.particles.count()));
      break;
    }
    correct(distribution_, wanted, now);
    populate(work);
    fill(work.part(static_cast<double>(k) / options_.corrections, (k + 1.0) / options_.corrections));
    now = shown(work.quiet());
    result_.misfit_after = misfit(wanted, now.colwise().sum());
    last = effort_.used - before;
  }
}

void Filler::hand_over() {
  if (!options_.interrupted) return;
  if (complete_) {
    // Sizes are those that were wanted: measuring them takes too long now.
    for (std::size_t i = 0; i < result_.shapes.shapes.size(); ++i)
      result_.shapes.shapes[i].max_section_area =
          0.25 * std::numbers::pi * result_.particles.size[i] * result_.particles.size[i];
    options_.interrupted(result_.particles, result_.shapes, true);
  } else if (packed_) {
    Particles p = population_.particles;
    for (std::size_t i = 0; i < p.count(); ++i) p.size[i] = p.scale[i] * shapes_.shapes[p.shape[i]].size();
    options_.interrupted(p, shapes_, false);
  }
}

FillResult Filler::run(const Work& work) {
  populate(work);
  result_.notes = population_.notes;
  result_.requested_fraction = population_.requested_fraction;
  result_.left_out_fraction = population_.left_out_fraction;
  result_.expected = population_.expected;
  const Particles first = population_.particles;
  const std::vector<int> first_class = population_.size_class;
  const double filled = 0.9 / (options_.corrections + 1);
  fill(work.part(0, filled));
  correct_sizes(first, first_class, work.part(filled, 0.9));
  measure_sizes(work.part(0.9, 1));
  result_.effort = effort_.used / options_.effort;
  if (ended_early_)
    result_.notes.push_back(fmt::format(
        "{} particles were more work than one node may do, so their volumes are less exact: the worst is off "
        "by {:.2g} of its volume, and the mean by {:.2g}",
        result_.particles.count(), result_.worst, result_.mean_error));
  return std::move(result_);
}

}  // namespace

FillResult fill_space(const SizeDistribution& distribution, const Shapes& shapes, const FillOptions& options,
                      const Work& work) {
  Filler filler(distribution, shapes, options);
  try {
    return filler.run(work);
  } catch (const Cancelled&) {
    filler.hand_over();
    throw;
  }
}

}  // namespace terrazzo::tessellation
