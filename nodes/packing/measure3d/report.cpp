#include "nodes/packing/measure3d/report.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "nodes/common/geometry/mesh/principal_axes.h"

namespace terrazzo::measure3d {
namespace {

double diameter_of(const Body& b) { return std::cbrt(6 * b.volume / std::numbers::pi); }
double elongation_of(const Body& b) { return b.axes[0] > 0 ? b.axes[1] / b.axes[0] : 0; }
double flatness_of(const Body& b) { return b.axes[1] > 0 ? b.axes[2] / b.axes[1] : 0; }

struct Mean {
  double mean = 0, deviation = 0, error = 0;
  std::size_t n = 0;
};

Mean mean_of(const std::vector<double>& values) {
  Mean m;
  m.n = values.size();
  if (m.n == 0) return m;
  const double n = m.n;
  for (const double v : values) m.mean += v / n;
  double squares = 0;
  for (const double v : values) squares += (v - m.mean) * (v - m.mean);
  m.deviation = m.n > 1 ? std::sqrt(squares / (n - 1)) : 0;
  m.error = m.deviation / std::sqrt(n);
  return m;
}

std::vector<double> values_of(const Findings& f, const std::function<double(const Body&)>& of) {
  std::vector<double> out;
  for (std::size_t k = 0; k < f.bodies.size(); ++k)
    if (f.counted[k]) out.push_back(of(f.bodies[k]));
  return out;
}

// Tensor ⟨uuᵀ⟩ of the longest axes.
Mat3 orientation_tensor(const Findings& f) {
  Mat3 sum = Mat3::Zero();
  double n = 0;
  for (std::size_t k = 0; k < f.bodies.size(); ++k)
    if (f.counted[k]) {
      const Vec3 u = f.bodies[k].directions.col(0);
      sum += u * u.transpose();
      ++n;
    }
  return n > 0 ? Mat3(sum / n) : sum;
}

Histogram histogram_between(std::string name, std::string unit, const std::vector<double>& values, double lo,
                            double hi, std::size_t bins) {
  Histogram h{std::move(name), std::move(unit), {}, std::vector<double>(bins, 0), {}};
  if (!(hi > lo)) hi = lo + std::max(1e-9, std::abs(lo) * 1e-9);
  for (std::size_t k = 0; k <= bins; ++k) h.edges.push_back(lo + (hi - lo) * k / bins);
  for (const double v : values) {
    // A value on an edge, such as the ratio 0.6 of axes, belongs above it whatever its rounding.
    const double t = (v - lo) / (hi - lo) * bins + 1e-9;
    h.share[static_cast<std::size_t>(std::clamp(t, 0.0, static_cast<double>(bins) - 1))] +=
        1 / static_cast<double>(values.size());
  }
  return h;
}

}  // namespace

void count_contacts(Findings& f) {
  f.neighbors.assign(f.bodies.size(), 0);
  f.contact_area.assign(f.bodies.size(), 0);
  std::int32_t last = -1;
  for (const Body& b : f.bodies) last = std::max(last, b.index);
  std::vector<std::size_t> slot(last + 1, 0);
  for (std::size_t k = 0; k < f.bodies.size(); ++k) slot[f.bodies[k].index] = k;
  for (const Touch& t : f.touches)
    for (const std::int32_t p : {t.a, t.b}) {
      const std::size_t k = slot[p];
      ++f.neighbors[k];
      f.contact_area[k] += t.area;
    }
}

namespace {

std::vector<Histogram> body_histograms(const Findings& f) {
  const auto volumes = values_of(f, [](const Body& b) { return b.volume; });
  if (volumes.empty()) return {};
  const auto bins =
      static_cast<std::size_t>(std::clamp(2 * std::cbrt(static_cast<double>(volumes.size())), 5.0, 40.0));
  std::vector<Histogram> out;
  const auto spread = [&](const char* name, const char* unit, const std::vector<double>& v) {
    out.push_back(histogram_between(name, unit, v, *std::min_element(v.begin(), v.end()),
                                    *std::max_element(v.begin(), v.end()), bins));
  };
  spread("volume", "mm³", volumes);
  spread("diameter", "mm", values_of(f, diameter_of));
  out.push_back(histogram_between("elongation", "", values_of(f, elongation_of), 0, 1, 20));
  out.push_back(histogram_between("flatness", "", values_of(f, flatness_of), 0, 1, 20));
  // |cos| of random directions is uniform.
  for (int a = 0; a < 3; ++a) {
    out.push_back(histogram_between(std::string("|cos| of the longest axis to ") + "xyz"[a], "",
                                    values_of(f, [a](const Body& b) { return std::abs(b.directions(a, 0)); }),
                                    0, 1, 10));
    out.back().expected.assign(10, 0.1);
  }
  std::vector<double> contacts, areas;
  for (std::size_t k = 0; k < f.bodies.size(); ++k)
    if (f.counted[k]) contacts.push_back(f.neighbors[k]);
  const double most = *std::max_element(contacts.begin(), contacts.end());
  out.push_back(
      histogram_between("contacts", "", contacts, -0.5, most + 0.5, static_cast<std::size_t>(most) + 1));
  for (const Touch& t : f.touches) areas.push_back(t.area);
  if (!areas.empty())
    out.push_back(histogram_between("contact area", "mm²", areas, 0,
                                    *std::max_element(areas.begin(), areas.end()), bins));
  return out;
}

// `of`: the end of the names.
void add_phase_histograms(const PhaseMeasures& phase, const std::string& of, std::vector<Histogram>& out) {
  constexpr std::size_t kMostBins = 40;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto& share = phase.chords[a].share;
    if (share.empty()) continue;
    const std::size_t width = (share.size() - 1 + kMostBins - 1) / kMostBins;  // voxels
    Histogram h{std::string("chord along ") + "xyz"[a] + of, "mm", {0.5 * phase.spacing[a]}, {}, {}};
    for (std::size_t k = 1; k < share.size(); ++k) {
      if ((k - 1) % width == 0) {
        h.edges.push_back((k + width - 0.5) * phase.spacing[a]);
        h.share.push_back(0);
      }
      h.share.back() += share[k];
    }
    out.push_back(std::move(h));
  }
  if (!phase.thickness.share.empty())
    out.push_back({"local thickness" + of, "mm", phase.thickness.edges, phase.thickness.share, {}});
}

using AddRow = std::function<void(const std::string&, double, double, const char*)>;

void add_voxel_rows(const Findings& f, const AddRow& add) {
  if (f.voxel_fraction)
    add("volume fraction, voxels", *f.voxel_fraction,
        f.representative ? f.representative->fraction_error : NAN, "");
  if (f.voxel_fraction && !f.phase) add("specific surface, voxels", 0, NAN, "1/mm");
  if (!f.phase) return;
  const PhaseMeasures& p = *f.phase;
  const auto add_known = [&](const std::string& name, double value, const char* unit) {
    if (!std::isnan(value)) add(name, value, NAN, unit);
  };
  add_known("specific surface, voxels", p.densities.surface, "1/mm");
  if (p.densities.surface > 0) add("mean chord", 4 * p.fraction / p.densities.surface, NAN, "mm");
  for (std::size_t a = 0; a < 3; ++a)
    add_known(std::string("mean chord along ") + "xyz"[a], p.chords[a].mean, "mm");
  add_known("mean local thickness", p.thickness.mean, "mm");
  add_known("sd of local thickness", p.thickness.deviation, "mm");
  add_known("mean curvature per volume", p.densities.curvature, "1/mm²");
  add_known("Euler number per volume", p.densities.euler, "1/mm³");
  for (std::size_t a = 0; a < 3; ++a)
    add(std::string("share connected across ") + "xyz"[a], p.percolation.across[a], NAN, "");
  add("share in the largest piece", p.percolation.largest, NAN, "");
}

}  // namespace

std::vector<Histogram> histograms_of(const Findings& f) {
  std::vector<Histogram> out = body_histograms(f);
  if (f.phase) add_phase_histograms(*f.phase, "", out);
  for (const PhaseMeasures& phase : f.phases) add_phase_histograms(phase, ", phase " + phase.name, out);
  return out;
}

Table summary_of(const Findings& f) {
  Table t;
  t.columns = {"measure", "value", "error", "unit"};
  const auto add = [&](const std::string& name, double value, double error, const char* unit) {
    t.rows.push_back({name, value, std::isfinite(error) ? Table::Cell(error) : Table::Cell(std::string()),
                      std::string(unit)});
  };
  const auto add_mean = [&](const std::string& name, const std::vector<double>& v, const char* unit) {
    const Mean m = mean_of(v);
    add("mean " + name, m.mean, m.error, unit);
    add("sd of " + name, m.deviation, NAN, unit);
  };
  const auto volumes = values_of(f, [](const Body& b) { return b.volume; });
  if (!volumes.empty()) {
    const double n = volumes.size();
    add("particles", n, NAN, "");
    add("particles per volume", n / f.volume, NAN, "1/mm³");
    add_mean("volume", volumes, "mm³");
    add_mean("diameter", values_of(f, diameter_of), "mm");
    add_mean("elongation", values_of(f, elongation_of), "");
    add_mean("flatness", values_of(f, flatness_of), "");
    const Mat3 tensor = orientation_tensor(f);
    const char* names[] = {"xx", "yy", "zz", "xy", "xz", "yz"};
    const int at[][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    for (int k = 0; k < 6; ++k)
      add(std::string("orientation tensor ") + names[k], tensor(at[k][0], at[k][1]), NAN, "");
    add("nematic order", 1.5 * eigen_axes(tensor).eigenvalues()[2] - 0.5, NAN, "");
    std::vector<double> contacts, area, between;
    for (std::size_t k = 0; k < f.bodies.size(); ++k)
      if (f.counted[k]) {
        contacts.push_back(f.neighbors[k]);
        area.push_back(f.contact_area[k]);
      }
    add_mean("contacts", contacts, "");
    add_mean("contact area of a particle", area, "mm²");
    for (const Touch& touch : f.touches) between.push_back(touch.area);
    if (!between.empty()) add_mean("contact area of a pair", between, "mm²");
    if (f.gap > 0) {
      add("contact gap", f.gap, NAN, "mm");
      double volume = 0, surface = 0;
      for (std::size_t k = 0; k < f.bodies.size(); ++k)
        if (f.counted[k]) {
          volume += f.bodies[k].volume;
          surface += f.bodies[k].surface;
        }
      add("volume fraction, meshes", volume / f.volume, NAN, "");
      add("specific surface, meshes", surface / f.volume, NAN, "1/mm");
    }
  }
  add_voxel_rows(f, add);
  if (f.representative && f.representative->integral_range > 0) {
    add("integral range", f.representative->integral_range, f.representative->integral_range_error, "mm³");
    add("representative edge", f.representative->edge, f.representative->edge_error, "mm");
  }
  return t;
}

Table body_table(const Findings& f) {
  Table t;
  t.columns = {"index",           "class",       "void",    "cut",       "x mm",     "y mm",       "z mm",
               "volume mm³",      "diameter mm", "long mm", "middle mm", "short mm", "elongation", "flatness",
               "long_x",          "long_y",      "long_z",  "short_x",   "short_y",  "short_z",    "contacts",
               "contact_area mm²"};
  for (std::size_t k = 0; k < f.bodies.size(); ++k) {
    const Body& b = f.bodies[k];
    auto& row = t.rows.emplace_back();
    for (const double v : {double(b.index),        double(b.cls),      double(b.is_void),  double(b.cut),
                           b.center.x(),           b.center.y(),       b.center.z(),       b.volume,
                           diameter_of(b),         b.axes[0],          b.axes[1],          b.axes[2],
                           elongation_of(b),       flatness_of(b),     b.directions(0, 0), b.directions(1, 0),
                           b.directions(2, 0),     b.directions(0, 2), b.directions(1, 2), b.directions(2, 2),
                           double(f.neighbors[k]), f.contact_area[k]})
      row.emplace_back(v);
  }
  return t;
}

Table histogram_table(const std::vector<Histogram>& all) {
  Table t;
  t.columns = {"measure", "unit", "from", "to", "share"};
  for (const Histogram& h : all)
    for (std::size_t k = 0; k < h.share.size(); ++k)
      t.rows.push_back({h.name, h.unit, h.edges[k], h.edges[k + 1], h.share[k]});
  return t;
}

Table contact_table(const Findings& f) {
  Table t;
  t.columns = {"a", "b", "area mm²"};
  for (const Touch& touch : f.touches) t.rows.push_back({double(touch.a), double(touch.b), touch.area});
  return t;
}

Table correlation_table(const Findings& f) {
  Table t;
  t.columns = {"r mm", "S2_x", "S2_y", "S2_z", "mean_r mm", "S2_mean", "L_x", "L_y", "L_z"};
  if (!f.correlation) return t;
  const Correlation& c = *f.correlation;
  for (std::size_t k = 0; k < c.mean.size(); ++k) {
    auto& row = t.rows.emplace_back();
    row.emplace_back(k * c.step);
    for (int a = 0; a < 3; ++a) row.emplace_back(c.two_point[a][k]);
    for (const double v : {c.length[k], c.mean[k]})
      row.push_back(std::isnan(v) ? Table::Cell(std::string()) : Table::Cell(v));
    for (int a = 0; a < 3; ++a) row.emplace_back(c.lineal_path[a][k]);
  }
  return t;
}

Table subvolume_table(const Findings& f) {
  Table t;
  t.columns = {"edge mm", "subvolumes", "sd", "error", "expected"};
  if (f.representative)
    for (const Subvolumes& s : f.representative->table)
      t.rows.push_back({s.edge, s.count, s.deviation, s.error, s.expected});
  return t;
}

Table phase_table(const Findings& f) {
  Table t;
  t.columns = {"phase",         "fraction",      "surface 1/mm",  "curvature 1/mm²", "euler 1/mm³",
               "chord_x mm",    "chord_y mm",    "chord_z mm",    "thickness mm",    "thickness_sd mm",
               "percolation_x", "percolation_y", "percolation_z", "largest_share",   "pieces"};
  for (const PhaseMeasures& p : f.phases) {
    auto& row = t.rows.emplace_back();
    row.emplace_back(p.name);
    for (const double v :
         {p.fraction, p.densities.surface, p.densities.curvature, p.densities.euler, p.chords[0].mean,
          p.chords[1].mean, p.chords[2].mean, p.thickness.mean, p.thickness.deviation,
          p.percolation.across[0], p.percolation.across[1], p.percolation.across[2], p.percolation.largest,
          static_cast<double>(p.percolation.pieces)})
      row.push_back(std::isnan(v) ? Table::Cell(std::string()) : Table::Cell(v));
  }
  return t;
}

Table interface_table(const Findings& f) {
  Table t;
  t.columns = {"a", "b", "area mm²", "area per volume 1/mm"};
  for (const Interface& i : f.interfaces)
    t.rows.push_back({f.phases[i.a].name, f.phases[i.b].name, i.area, i.per_volume});
  return t;
}

}  // namespace terrazzo::measure3d
