#include "nodes/export/formats/solvers/damask_files.h"

#include <fmt/format.h>

#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/io/checked_file.h"

namespace terrazzo::exporting {
namespace {

constexpr double kPascalsPerGpa = 1e9;

std::string lattice_of(const SolverMaterial& m) { return m.lattice.empty() ? "cI" : m.lattice; }

// Quoted, for YAML takes No, on and null for other things than text.
std::string yaml_name(const SolverMaterial& m) { return '"' + m.name + '"'; }

// YAML 1.1 takes numbers without point and signed exponent for text.
std::string yaml_number(double value) { return fmt::format("{:.12e}", value); }

void add_phase(std::string& text, const SolverMaterial& m) {
  const Stiffness& s = *m.stiffness;
  const std::string lattice = lattice_of(m);
  text += fmt::format("  {}:\n    lattice: {}\n", yaml_name(m), lattice);
  if (m.c_over_a) text += fmt::format("    c/a: {}\n", yaml_number(*m.c_over_a));
  if (m.density) text += fmt::format("    rho: {}\n", yaml_number(*m.density));
  text += "    mechanical:\n      output: [F, P, F_e, O]\n      elastic:\n        type: Hooke\n";
  const auto add = [&](const char* name, double gpa) {
    text += fmt::format("        {}: {}\n", name, yaml_number(gpa * kPascalsPerGpa));
  };
  add("C_11", s.c11);
  add("C_12", s.c12);
  add("C_44", s.c44);
  if (lattice.starts_with("c")) return;
  add("C_13", s.c13);
  add("C_33", s.c33);
  if (lattice == "tI") add("C_66", s.c66);
}

// DAMASK requires a unit quaternion with a positive real part.
std::string quaternion_text(Quat q) {
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return fmt::format("[{:.17f}, {:.17f}, {:.17f}, {:.17f}]", q.w(), q.x(), q.y(), q.z());
}

}  // namespace

void check_damask(const Regions& regions, const SolverMaterials& materials, const Particles* particles) {
  materials.require_stiffness(regions, particles != nullptr);
  const std::set<std::string> known = {"cF", "cI", "hP", "tI"};
  for (const Region& r : regions.all) {
    if (r.voxels == 0) continue;
    const SolverMaterial& m = materials.of(r);
    if (!known.count(lattice_of(m)))
      throw Error("bad-materials", fmt::format("{}: DAMASK does not know the lattice {}", m.phase, m.lattice),
                  "use cF, cI, hP or tI");
    if (!m.c_over_a && (m.lattice == "hP" || m.lattice == "tI"))
      throw Error("bad-materials",
                  fmt::format("{}: DAMASK needs 'c/a' of the lattice {}", m.phase, m.lattice),
                  "add it to the table of materials");
  }
}

void write_damask_material(const std::filesystem::path& path, const Regions& regions,
                           const SolverMaterials& materials, const Particles* particles,
                           const std::string& provenance) {
  std::string text = "# Terrazzo: materials for DAMASK 3, in SI units.\n";
  if (!provenance.empty()) text += "# provenance " + provenance + "\n";
  text += "homogenization:\n  SX:\n    N_constituents: 1\n    mechanical: {type: pass}\nphase:\n";
  std::set<std::string> done;
  for (const Region& r : regions.all)
    if (const SolverMaterial& m = materials.of(r); done.insert(m.phase).second) add_phase(text, m);
  text += "material:\n";
  for (const Region& r : regions.all) {
    const Quat turn = particles && r.particle >= 0 ? particles->orientation[r.particle] : Quat::Identity();
    text += fmt::format("  - homogenization: SX\n    constituents:\n      - {{phase: {}, v: 1.0, O: {}}}\n",
                        yaml_name(materials.of(r)), quaternion_text(turn));
  }
  write_bytes(path, text);
}

void write_damask_load(const std::filesystem::path& path) {
  write_bytes(
      path,
      "# Terrazzo: tension along x at 0.001 per second, free in y and z.\n"
      "solver:\n  mechanical: spectral_basic\nloadstep:\n  - boundary_conditions:\n      mechanical:\n"
      "        dot_F:\n          - [0.001, 0, 0]\n          - [0, x, 0]\n          - [0, 0, x]\n"
      "        P:\n          - [x, x, x]\n          - [x, 0, x]\n          - [x, x, 0]\n"
      "    discretization: {t: 1.0, N: 5}\n    f_out: 5\n");
}

}  // namespace terrazzo::exporting
