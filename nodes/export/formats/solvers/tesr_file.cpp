#include "nodes/export/formats/solvers/tesr_file.h"

#include <fmt/format.h>

#include <numbers>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/export/formats/solvers/euler_angles.h"

namespace terrazzo::exporting {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// The symmetry of all cells in Neper's words, or "" if they differ or Neper has no word.
std::string symmetry(const Regions& regions, const SolverMaterials& materials) {
  std::set<std::string> words;
  for (std::size_t r = 1; r < regions.all.size(); ++r) {
    const std::string lattice = materials.of(regions.all[r]).lattice;
    words.insert(lattice.starts_with("c") ? "cubic" : lattice == "hP" ? "hexagonal" : "");
  }
  return words.size() == 1 ? *words.begin() : "";
}

}  // namespace

void write_tesr(const std::filesystem::path& path, const VoxelSource& id, const VoxelBox& box,
                const Regions& regions, const Particles* particles, const SolverMaterials* materials,
                const Work& work) {
  const std::size_t cells = regions.all.size() - 1;
  if (cells == 0)
    throw Error("no-particles", "the volume has no particle", "connect a volume with particles");
  const std::string crystal = materials ? symmetry(regions, *materials) : "";
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    const auto three = [](const auto& v) { return fmt::format("   {} {} {}\n", v[0], v[1], v[2]); };
    out << "***tesr\n **format\n   2.1\n **general\n   3\n"
        << three(box.size) << three(box.spacing) << "  *origin\n"
        << three(box.corner) << " **cell\n   " << cells << '\n';
    if (particles) {
      out << "  *ori\n   euler-bunge\n";
      for (std::size_t r = 1; r <= cells; ++r) {
        const std::int32_t p = regions.all[r].particle;
        const auto angles = euler_angles(p >= 0 ? particles->orientation[p] : Quat::Identity());
        out << fmt::format("   {:.12f} {:.12f} {:.12f}\n", angles[0] * kDegrees, angles[1] * kDegrees,
                           angles[2] * kDegrees);
      }
    }
    if (!crystal.empty()) out << "  *crysym\n   " << crystal << '\n';
    out << " **data\n   ascii\n";
    std::vector<std::int32_t> plane(box.plane());
    for (int z = 0; z < box.size.z(); ++z) {
      work.check();
      work.progress(double(z) / box.size.z());
      id.read(z, z + 1, plane.data());
      std::string text;
      for (std::size_t i = 0; i < plane.size(); ++i)
        text += std::to_string(regions.number(plane[i])) + ((i + 1) % box.size.x() ? ' ' : '\n');
      out << text;
    }
    out << "***end\n";
  });
}

}  // namespace terrazzo::exporting
