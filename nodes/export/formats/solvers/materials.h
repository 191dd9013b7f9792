// What solvers must know of each phase: its name, crystal lattice, stiffness and density.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "nodes/data/linear.h"
#include "nodes/data/table.h"
#include "nodes/export/regions.h"

namespace terrazzo::exporting {

// Of a crystal of cubic, hexagonal or tetragonal symmetry in its own frame, GPa.
struct Stiffness {
  double c11 = 0, c12 = 0, c13 = 0, c33 = 0, c44 = 0, c66 = 0;
  bool isotropic() const;
};

struct SolverMaterial {
  std::string phase;    // BINDER, PHASE_0, PHASE_1, … or VOIDS
  std::string name;     // in the files
  std::string lattice;  // Pearson symbol of the Bravais lattice, such as cF; empty: not given
  std::optional<double> c_over_a;
  std::optional<Stiffness> stiffness;
  std::optional<double> density;  // kg/m³
};

// The key of a region's phase in the table: BINDER, PHASE_0, … or VOIDS.
std::string phase_key(const Region&);

class SolverMaterials {
 public:
  // A row per phase. Columns: `phase`; and, where known, `name`, `lattice`, `c/a`, `density kg/m³`; `young
  // GPa` and `poisson`; or `C_11 GPa`, `C_12 GPa`, `C_44 GPa`, for hexagonal and tetragonal lattices also
  // `C_13 GPa`, `C_33 GPa`, and for tetragonal ones `C_66 GPa`. Empty cells are not given. Throws Error
  // "bad-materials", "bad-names", "no-column".
  explicit SolverMaterials(const Table&);

  // Throws Error "no-material" if the table lacks the region's phase.
  const SolverMaterial& of(const Region&) const;
  const SolverMaterial& of(const std::string& phase) const;
  // Throws Error "no-material" if a region's phase is absent or has no stiffness, "no-orientations" if it is
  // not isotropic and the region is no particle with an orientation.
  void require_stiffness(const Regions&, bool oriented) const;

 private:
  std::vector<SolverMaterial> all_;
};

// Number of the crystal structure in .dream3d files (EbsdLib); 999, unknown, without a lattice.
std::uint32_t dream3d_crystal(const std::string& lattice);

}  // namespace terrazzo::exporting
