#include "nodes/export/formats/solvers/lammps_file.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/export/formats/units.h"

namespace terrazzo::exporting {
namespace {

constexpr double kDensity = 1000;
constexpr std::int32_t kMostClasses = 65536;

// kg/m³ of each class of particles that are no voids.
std::vector<double> densities(const Particles& p, const SolverMaterials* materials) {
  std::vector<double> out;
  for (std::size_t i = 0; i < p.count(); ++i) {
    if (p.is_void(i)) continue;
    const std::int32_t cls = p.cls[i];
    if (cls < 0 || cls >= kMostClasses)
      throw Error("bad-particles",
                  fmt::format("particle {} has the class {}; classes are 0 to {}", i, cls, kMostClasses - 1));
    if (out.size() <= std::size_t(cls)) out.resize(cls + 1, 0);
    if (out[cls] > 0) continue;
    out[cls] = kDensity;
    if (!materials) continue;
    const SolverMaterial& m = materials->of(fmt::format("PHASE_{}", cls));
    if (!m.density)
      throw Error("no-material", "the table of materials has no density for " + m.phase,
                  "fill in 'density kg/m³'");
    out[cls] = *m.density;
  }
  if (out.empty()) throw Error("no-particles", "there are no particles to write");
  return out;
}

}  // namespace

void write_lammps(const std::filesystem::path& path, const Particles& p, const Shapes& shapes,
                  const SolverMaterials* materials, const Work& work) {
  const std::vector<double> density = densities(p, materials);
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    out << "Terrazzo: spheres of the particles' volumes, SI units, atom_style sphere\n\n"
        << fmt::format("{} atoms\n{} atom types\n\n", p.count() - p.void_count(), density.size());
    for (int a = 0; a < 3; ++a)
      out << fmt::format("0 {0:.12g} {1}lo {1}hi\n", p.box[a] * kMetersPerMm, "xyz"[a]);
    out << "\nAtoms\n\n";
    std::size_t number = 0;
    for (std::size_t i = 0; i < p.count(); ++i) {
      if (i % 4096 == 0) {
        work.check();
        work.progress(double(i) / double(p.count()));
      }
      if (p.is_void(i)) continue;
      const std::int32_t shape = p.shape[i];
      if (shape < 0 || std::size_t(shape) >= shapes.shapes.size())
        throw Error("no-such-shape",
                    fmt::format("particle {} has the shape {} of {}", i, shape, shapes.shapes.size()),
                    "connect the shapes used in the packing");
      const double diameter = p.scale[i] * std::cbrt(6 / std::numbers::pi * shapes.shapes[shape].volume);
      if (!(diameter > 0) || !std::isfinite(diameter))
        throw Error("unmeasured-shape", fmt::format("the shape {} has no volume", shape));
      const Vec3 at = p.position[i] * kMetersPerMm;
      out << fmt::format("{} {} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g}\n", ++number, p.cls[i] + 1,
                         diameter * kMetersPerMm, density[p.cls[i]], at.x(), at.y(), at.z());
    }
  });
}

}  // namespace terrazzo::exporting
