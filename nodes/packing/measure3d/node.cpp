#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/packing/measure3d/pieces.h"
#include "nodes/packing/measure3d/report.h"
#include "runtime/context.h"
#include "runtime/memory.h"

namespace terrazzo::measure3d {
namespace {

constexpr double kUsualGap = 0.02;  // of the mean diameter

void check_inputs(const Context& c) {
  if (c.has("particles") && !c.has("shapes"))
    throw Error("missing-input", "the particles have no shapes", "connect the shapes of the particles");
  if (!c.has("particles") && !c.has("volume"))
    throw Error("missing-input", "nothing to measure is connected",
                "connect particles with shapes, a volume, or both");
}

void measure_meshes(Context& c, const Particles& particles, Findings& f) {
  const auto& shapes = c.input<Shapes>("shapes");
  if (particles.count() == 0) throw Error("no-particles", "there are no particles to measure");
  f.bodies = bodies_of(particles, shapes, c.work().part(0, 0.05));
  f.volume = particles.box.prod();
  double diameter = 0;
  for (const Body& b : f.bodies) diameter += std::cbrt(b.volume * 6 / M_PI) / f.bodies.size();
  f.gap = c.optional_number("contact_gap").value_or(kUsualGap * diameter);
  if (const double half = particles.box.minCoeff() / 2; f.gap > half)
    throw Error(
        "bad-value",
        fmt::format("contact_gap is {} mm, more than half of the box's shortest edge, {} mm", f.gap, half),
        "particles would touch their own copies; use a smaller gap")
        .parameter("contact_gap");
  f.touches = touches_of(particles, shapes, f.gap, c.work().part(0.05, 0.4));
}

// A volume that tiles must be one of these particles' box.
void check_box(const Raster& raster, const Particles& particles) {
  const Vec3 edge = raster.box.size.cast<double>().cwiseProduct(raster.box.spacing);
  if (!raster.box.periodic || (edge - particles.box).norm() < 1e-3 * edge.norm()) return;
  throw Error(
      "size-mismatch",
      fmt::format(
          "the volume is {:.4g} × {:.4g} × {:.4g} mm, but the particles' box is {:.4g} × {:.4g} × {:.4g} mm",
          edge.x(), edge.y(), edge.z(), particles.box.x(), particles.box.y(), particles.box.z()),
      "connect the volume that was made from these particles");
}

// Says which labels are phases, and marks their pieces.
void report_phases(Context& c, const Phases& phases, Findings& f) {
  std::size_t spanning = 0;
  for (Body& b : f.bodies) {
    if (b.index < phases.first) continue;
    const std::size_t piece = b.index - phases.first;
    b.cls = phases.label_of[piece];
    if (phases.spans[piece]) {
      b.cut = true;
      ++spanning;
    }
  }
  const std::size_t count = phases.labels.size(), shown = std::min<std::size_t>(count, 5);
  std::string names =
      fmt::format("{}", fmt::join(phases.labels.begin(), phases.labels.begin() + shown, ", "));
  if (count > shown) names += fmt::format(" and {} more", count - shown);
  std::string text = fmt::format(
      "{} of the labels mark{} a phase instead of a particle ({}): no connected piece has half of the "
      "label's "
      "voxels, or one reaches across the whole box. The {} connected pieces are measured as particles, with "
      "the label as their class",
      count, count == 1 ? "s" : "", names, phases.label_of.size());
  if (spanning > 0)
    text += fmt::format("; the {} that reach{} across the box {} left out of means and distributions",
                        spanning, spanning == 1 ? "es" : "", spanning == 1 ? "is" : "are");
  c.warn(text + ". If the lowest label is the binder, set `threshold` above it.");
}

// The class that is the phase of the raster, if every class is inside or outside of it. Else −1.
int class_of_phase(const Classes& classes, const Raster& raster) {
  if (classes.count() != 2) return -1;
  for (std::size_t i = 0; i < raster.count(); ++i)
    if (raster.in[i]) return classes.voxels[classes.of[i]] == raster.inside ? classes.of[i] : -1;
  return -1;
}

// Before labels of phases are split into their pieces.
void measure_phases(Context& c, const Raster& raster, Phase phase, const Work& work, Findings& f) {
  require_memory(2.0 * raster.count(), c.memory(), "the phases of the volume");
  const bool uniform = raster.inside == 0 || raster.inside == raster.count();
  if (const auto labels = classes_of_labels(raster, work.quiet())) {
    f.phases = measure_classes(*labels, c.memory(), work.part(0, 0.4));
    f.interfaces = interfaces_of(*labels, work.part(0.4, 0.5));
    if (const int k = class_of_phase(*labels, raster); k >= 0) f.phase = f.phases[k];
  }
  if (f.phase || uniform) return;
  Classes classes = classes_of_phase(raster, phase);
  classes.wanted[0] = f.phases.empty();
  const auto measured = measure_classes(classes, c.memory(), work.part(0.5, 0.9));
  f.phase = measured[1];
  if (!f.phases.empty()) return;
  f.phases = measured;
  f.interfaces = interfaces_of(classes, work.part(0.9, 1));
}

void measure_voxels(Context& c, Raster& raster, const Particles* particles, bool labels, Findings& f) {
  f.volume = raster.count() * raster.voxel_volume();
  f.voxel_fraction = raster.fraction();
  measure_phases(c, raster, c.choice<Phase>("phase"), c.work().part(0.45, 0.8), f);
  if (labels) {
    const Phases phases = split_phases(raster, c.work().quiet());
    f.touches = touches_of(raster, c.work().part(0.8, 0.85));
    f.bodies = bodies_of(raster, particles, c.work().part(0.85, 0.87));
    if (!phases.labels.empty()) report_phases(c, phases, f);
  }
  f.correlation = correlate(raster, c.memory(), c.work().part(0.87, 0.95));
  f.representative = representative_volume(raster, c.number("precision"), c.work().part(0.95, 1));
}

// Particles of the phase, or all solid ones if the phase is the binder, that are not cut by the border.
void choose_bodies(Context& c, Phase phase, bool tiles, Findings& f) {
  std::size_t cut = 0, voids = 0;
  for (const Body& b : f.bodies) {
    f.counted.push_back(b.is_void == (phase == Phase::Voids) && !b.cut);
    cut += b.cut;
    voids += b.is_void;
  }
  if (phase == Phase::Voids && voids == 0)
    throw Error("no-particles", "none of the particles is a void", "set phase: particles").parameter("phase");
  if (cut > 0 && !tiles)
    c.warn(
        fmt::format("{} of {} particles touch the border of a volume that does not tile: they are listed, "
                    "but left out of means "
                    "and distributions, which therefore favor small particles",
                    cut, f.bodies.size()));
}

// Rows of the table that are metrics, too.
constexpr std::pair<const char*, const char*> kMetrics[] = {
    {"particles", "particles"},
    {"mean diameter", "mean_diameter"},
    {"mean contacts", "mean_contacts"},
    {"nematic order", "nematic_order"},
    {"volume fraction, meshes", "volume_fraction"},
    {"specific surface, meshes", "specific_surface"},
    {"volume fraction, voxels", "voxel_fraction"},
    {"specific surface, voxels", "voxel_surface"},
    {"mean chord", "mean_chord"},
    {"mean chord along x", "mean_chord_x"},
    {"mean chord along y", "mean_chord_y"},
    {"mean chord along z", "mean_chord_z"},
    {"mean local thickness", "mean_thickness"},
    {"mean curvature per volume", "curvature_density"},
    {"Euler number per volume", "euler_density"},
    {"share connected across x", "percolation_x"},
    {"share connected across y", "percolation_y"},
    {"share connected across z", "percolation_z"},
    {"share in the largest piece", "largest_share"},
    {"integral range", "integral_range"},
    {"representative edge", "representative_edge"}};

void compute(Context& c) {
  check_inputs(c);
  const auto* particles = c.optional<Particles>("particles");
  const auto* volume = c.optional<Volume>("volume");
  const Phase phase = c.choice<Phase>("phase");
  Findings f;
  bool tiles = true;
  if (particles) measure_meshes(c, *particles, f);
  if (volume) {
    Raster raster = read_raster(*volume, c.text("grid"), particles, phase, c.optional_number("threshold"),
                                c.memory(), c.work().part(0.4, 0.45));
    tiles = raster.box.periodic;
    if (particles) check_box(raster, *particles);
    measure_voxels(c, raster, particles, !particles && !raster.ids.empty(), f);
    if (raster.inside == 0 || raster.inside == raster.count())
      c.warn(fmt::format("{} voxel belongs to the phase, so correlations are constant",
                         raster.inside == 0 ? "no" : "every"));
  }
  choose_bodies(c, phase, tiles, f);
  count_contacts(f);
  const Table summary = summary_of(f);
  for (const auto& [row, name] : kMetrics)
    for (std::size_t k = 0; k < summary.rows.size(); ++k)
      if (std::get<std::string>(summary.rows[k][0]) == row) c.metric(name, summary.number(k, "value"));
  const double shortest = std::cbrt(f.volume);
  if (f.representative && f.representative->edge > shortest)
    c.warn(fmt::format(
        "the volume, {:.3g} mm on edge, is smaller than a representative one: {:.3g} ± {:.2g} mm for {:.3g} "
        "% of the "
        "volume fraction",
        shortest, f.representative->edge, f.representative->edge_error, 100 * c.number("precision")));
  const auto histograms = histograms_of(f);
  c.output("table", summary);
  c.output("particles", body_table(f));
  c.output("distributions", histogram_table(histograms));
  c.output("contacts", contact_table(f));
  c.output("correlation", correlation_table(f));
  c.output("subvolumes", subvolume_table(f));
  c.output("phases", phase_table(f));
  c.output("interfaces", interface_table(f));
  c.output("figure", figure_of(f, histograms));
}

}  // namespace
}  // namespace terrazzo::measure3d

namespace terrazzo {

NodeType measure3d_node() {
  using namespace measure3d;
  return NodeType("Measure3D", 3)
      .doc_(
          "Measures a packing or a volume of labels: distributions of volume, aspect, orientation and "
          "coordination; contact area and specific surface; chord lengths, local thickness, curvature, Euler "
          "number and connectivity of phases, and the interfaces between them; two-point correlation and "
          "lineal path; the size of a representative volume.")
      .source_(
          "Torquato 2002 (correlations); Ohser and Mücklich 2000 (surfaces, curvature, Euler number); "
          "Hildebrand and Rüegsegger 1997 (local thickness); Lantuéjoul 1991, Kanit et al. 2003 "
          "(representative volume); Zingg 1935 (aspect)")
      .optional_input(
          "particles", {"Particles"},
          "Particles, measured from their meshes. With the volume, they show which labels are voids.")
      .optional_input("shapes", {"Shapes"}, "Shapes of the particles")
      .optional_input("volume", {"Volume"},
                      "Volume for correlations, surface and representative size: labels, such as Voxelize's "
                      "grid id, a density, or a level set, which is measured as the body inside. "
                      "Without particles, each label of the grid is measured as a particle.")
      .output("table", "Table", "One row per measure: value, standard error, unit")
      .output("particles", "Table",
              "One row per particle: position, volume, axes of the ellipsoid of equal inertia with "
              "directions of the longest and "
              "shortest, contacts")
      .output("distributions", "Table",
              "Histograms of volume, diameter, aspect, orientation, contacts and contact area; of phases, of "
              "chords along x, y and z (shares of their number) and of local thickness (shares of the "
              "volume, which are the granulometry by balls)")
      .output("contacts", "Table", "Pairs of particles that touch, with the area of contact")
      .output("correlation", "Table",
              "Two-point correlation S2 along x, y and z and over all directions, and lineal path L along x, "
              "y and z, by distance")
      .output("subvolumes", "Table",
              "Standard deviation of the volume fraction in cubes, with its standard error, and as expected "
              "from the integral range")
      .output("phases", "Table",
              "One row per label, if there are 2 to 64, else the phase and the rest: fraction; surface, mean "
              "curvature and Euler number per volume; mean chords and local thickness; shares of the phase "
              "that are connected across x, y and z, and in the largest piece")
      .output("interfaces", "Table", "Pairs of these phases that touch: area, and area per volume")
      .output("figure", "Image", "Plots of these measures")
      .parameter(
          Parameter::choice("phase", "particles", {"particles", "voids", "binder"})
              .doc_(
                  "Phase whose surface, correlations and representative size are measured. voids: particles "
                  "that are voids. binder: the particles themselves are measured as with particles."))
      .parameter(Parameter::text("grid", "")
                     .doc_("Grid of the volume to measure. Empty: id, else density, else the only one."))
      .parameter(Parameter::optional_number("threshold", "auto")
                     .range(-1e30, 1e30)
                     .doc_("Smallest value that counts as particle; smaller values are binder. auto: 0 for "
                           "labels, 0.5 for other grids. Use 1 if the labels of a file begin at 1."))
      .parameter(Parameter::optional_number("contact_gap", "auto")
                     .range(1e-9, 1e9)
                     .unit_("mm")
                     .doc_("Particles are in contact if their surfaces are closer than this. auto: 2 % of "
                           "their mean diameter. Labels are in contact if they share a face of voxels."))
      .parameter(Parameter::number("precision", 0.05)
                     .range(1e-6, 1)
                     .doc_("Two standard deviations of the volume fraction of a representative volume, "
                           "relative to the volume fraction"))
      .compute_(compute);
}

}  // namespace terrazzo
