#include "nodes/export/formats/solvers/inp_job.h"

#include <fmt/format.h>

#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/io/checked_file.h"

namespace terrazzo::exporting {
namespace {

constexpr double kMpaPerGpa = 1000, kTonnesPerMm3 = 1e-12;  // of kg/m³
constexpr double kStrain = 0.001;

void add_material(std::string& text, const SolverMaterial& m) {
  const Stiffness& s = *m.stiffness;
  text += fmt::format("*MATERIAL, NAME={}\n", m.name);
  if (s.isotropic()) {
    const double poisson = s.c12 / (s.c11 + s.c12);
    const double young = s.c11 * (1 + poisson) * (1 - 2 * poisson) / (1 - poisson);
    text += fmt::format("*ELASTIC\n{:.9e}, {:.9e}\n", young * kMpaPerGpa, poisson);
  } else {
    text += "*ELASTIC, TYPE=ORTHOTROPIC\n";
    int on_line = 0;
    for (const double c : {s.c11, s.c12, s.c11, s.c13, s.c13, s.c33, s.c66, s.c44})
      text += fmt::format("{}{:.9e}", on_line++ ? ", " : "", c * kMpaPerGpa);
    text += fmt::format("\n{:.9e}\n", s.c44 * kMpaPerGpa);
  }
  if (m.density) text += fmt::format("*DENSITY\n{:.9e}\n", *m.density * kTonnesPerMm3);
}

// The crystal's x axis, and a direction in its x-y plane.
void add_orientation(std::string& text, const std::string& name, const Quat& turn) {
  const Mat3 axes = turn.normalized().toRotationMatrix();
  text += fmt::format("*ORIENTATION, NAME={}\n", name);
  for (int k = 0; k < 2; ++k)
    text += fmt::format("{}{:.9e}, {:.9e}, {:.9e}", k ? ", " : "", axes(0, k), axes(1, k), axes(2, k));
  text += '\n';
}

}  // namespace

void write_inp_materials(const std::filesystem::path& path, const Regions& regions,
                         const SolverMaterials& materials, const Particles* particles) {
  materials.require_stiffness(regions, particles != nullptr);
  std::string text =
      "** Terrazzo: materials in MPa and tonnes per mm3, and a section for each element set.\n";
  std::set<std::string> done;
  for (const Region& r : regions.all)
    if (r.voxels > 0)
      if (const SolverMaterial& m = materials.of(r); done.insert(m.phase).second) add_material(text, m);
  for (const Region& r : regions.all) {
    if (r.voxels == 0) continue;
    const SolverMaterial& m = materials.of(r);
    std::string end;
    if (!m.stiffness->isotropic()) {
      add_orientation(text, "AXES_" + r.name(), particles->orientation[r.particle]);
      end = ", ORIENTATION=AXES_" + r.name();
    }
    text += fmt::format("*SOLID SECTION, ELSET={}, MATERIAL={}{}\n", r.name(), m.name, end);
  }
  write_bytes(path, text);
}

void check_inp_job(const InpJob& job) {
  for (const std::string& file : {job.mesh, job.equations, job.materials})
    if (file.find_first_of(" ,\"'*") != std::string::npos || file.size() > 100)
      throw Error(
          "bad-names", "*INCLUDE cannot read the file name '" + file + "'",
          "use a name without spaces, commas, quotation marks and asterisks, of at most 90 characters")
          .parameter("path");
}

void write_inp_job(const std::filesystem::path& path, const InpJob& job, const VoxelBox& box) {
  std::string text =
      "** Terrazzo: the block stretched by 0.1 % along x, for CalculiX: ccx -i NAME. Stresses in MPa.\n";
  for (const std::string& file : {job.mesh, job.equations, job.materials})
    if (!file.empty()) text += "*INCLUDE, INPUT=" + file + "\n";
  text += "*STEP\n*STATIC\n*BOUNDARY\n";
  const double pull = kStrain * box.size.x() * box.spacing.x();
  if (job.equations.empty())
    text +=
        fmt::format("SIDE_X0, 1, 1, 0.\nSIDE_Y0, 2, 2, 0.\nSIDE_Z0, 3, 3, 0.\nSIDE_X1, 1, 1, {:.9e}\n", pull);
  else  // without rotation
    text += fmt::format(
        "CORNER_000, 1, 3, 0.\nCORNER_100, 1, 1, {:.9e}\nCORNER_100, 2, 3, 0.\nCORNER_010, 1, 1, 0.\n"
        "CORNER_010, 3, 3, 0.\nCORNER_001, 1, 2, 0.\n",
        pull);
  text += "*NODE FILE\nU\n*EL FILE\nS, E\n*EL PRINT, ELSET=ALL_ELEMENTS, GLOBAL=YES\nS\n*END STEP\n";
  write_bytes(path, text);
}

}  // namespace terrazzo::exporting
