#include "nodes/export/formats/solvers/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "graph/diagnostic.h"
#include "graph/text/utf8.h"

namespace terrazzo::exporting {
namespace {

constexpr std::uint32_t kUnknownCrystal = 999;

// The 14 Bravais lattices by the Pearson symbol's first letter and the numbers of their Laue group of highest
// symmetry in EbsdLib. hR is trigonal.
const std::map<std::string, std::uint32_t> kLattices = {
    {"cP", 1}, {"cI", 1}, {"cF", 1}, {"hP", 0}, {"hR", 10}, {"tP", 8}, {"tI", 8},
    {"oP", 6}, {"oS", 6}, {"oI", 6}, {"oF", 6}, {"mP", 5},  {"mS", 5}, {"aP", 4}};

const std::vector<std::string> kColumns = {
    "phase",   "name",     "lattice",  "c/a",      "density kg/m³", "density kg/m3", "young GPa",
    "poisson", "C_11 GPa", "C_12 GPa", "C_13 GPa", "C_33 GPa",      "C_44 GPa",      "C_66 GPa"};

Error bad(const std::string& what, const std::string& hint = {}) {
  return Error("bad-materials", "the table of materials: " + what, hint);
}

// One row, by column.
class MaterialRow {
 public:
  MaterialRow(const Table& table, std::size_t row) : table_(table), row_(row) {}
  std::string phase;  // for messages

  std::string text(const std::string& column) const {
    const int c = table_.column(column);
    if (c < 0) return {};
    const auto* text = std::get_if<std::string>(&table_.rows[row_][c]);
    if (!text) throw bad(fmt::format("row {}: '{}' is a number", row_ + 1, column), "write a word");
    return *text;
  }
  std::optional<double> number(const std::string& column) const {
    const int c = table_.column(column);
    if (c < 0) return {};
    const Table::Cell& cell = table_.rows[row_][c];
    if (const auto* text = std::get_if<std::string>(&cell)) {
      if (text->empty()) return {};
      throw bad(fmt::format("{}: '{}' is '{}'", phase, column, printable(*text)), "write a number");
    }
    const double value = std::get<double>(cell);
    if (!std::isfinite(value)) throw bad(fmt::format("{}: '{}' is not finite", phase, column));
    return value;
  }

 private:
  const Table& table_;
  std::size_t row_;
};

bool is_phase(const std::string& key) {
  if (key == "BINDER" || key == "VOIDS") return true;
  return key.starts_with("PHASE_") && key.size() > 6 && key.size() < 12 &&
         std::all_of(key.begin() + 6, key.end(), [](char c) { return c >= '0' && c <= '9'; });
}

bool is_name(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !name.empty() && name.size() <= 70 && letter(name[0]) &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-'; });
}

// Abaqus and CalculiX read names in upper case.
bool same_name(const std::string& a, const std::string& b) {
  const auto upper = [](unsigned char c) { return std::toupper(c); };
  return std::ranges::equal(a, b, {}, upper, upper);
}

std::optional<Stiffness> isotropic_stiffness(const MaterialRow& row) {
  const auto young = row.number("young GPa"), poisson = row.number("poisson");
  if (!young && !poisson) return {};
  if (!young || !poisson) throw bad(row.phase + " has only one of 'young GPa' and 'poisson'", "give both");
  if (!(*young > 0) || !(*poisson > -1 && *poisson < 0.5))
    throw bad(fmt::format("{}: Young's modulus {} and Poisson's ratio {}", row.phase, *young, *poisson),
              "use a modulus above 0 and a ratio above −1 and below 0.5; give voids a small modulus");
  const double shear = *young / (2 * (1 + *poisson));
  const double lambda = *young * *poisson / ((1 + *poisson) * (1 - 2 * *poisson));
  const double axial = lambda + 2 * shear;
  return Stiffness{axial, lambda, lambda, axial, shear, shear};
}

std::optional<Stiffness> crystal_stiffness(const MaterialRow& row, const std::string& lattice) {
  const std::array<const char*, 6> all = {"C_11 GPa", "C_12 GPa", "C_44 GPa",
                                          "C_13 GPa", "C_33 GPa", "C_66 GPa"};
  std::array<std::optional<double>, 6> c;
  std::size_t given = 0;
  for (std::size_t k = 0; k < all.size(); ++k) given += (c[k] = row.number(all[k])).has_value();
  if (given == 0) return {};
  const bool cubic = lattice.starts_with("c"), hexagonal = lattice == "hP";
  if (!cubic && !hexagonal && !lattice.starts_with("t"))
    throw bad(fmt::format("{}: the lattice '{}' has no stiffness of this form", row.phase, lattice),
              "give a cubic, hexagonal or tetragonal lattice, such as cF, hP or tI");
  const std::size_t needed = cubic ? 3 : hexagonal ? 5 : 6;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (c[k].has_value() != (k < needed))
      throw bad(
          fmt::format("{}: {} '{}'", row.phase, c[k] ? "the lattice " + lattice + " has no" : "no", all[k]),
          fmt::format("give the first {} of C_11, C_12, C_44, C_13, C_33, C_66", needed));
  if (cubic) return Stiffness{*c[0], *c[1], *c[1], *c[0], *c[2], *c[2]};
  return Stiffness{*c[0], *c[1], *c[3], *c[4], *c[2], hexagonal ? (*c[0] - *c[1]) / 2 : *c[5]};
}

void check_stable(const std::string& phase, const Stiffness& s) {
  const bool stable = s.c44 > 0 && s.c66 > 0 && s.c33 > 0 && s.c11 > std::abs(s.c12) &&
                      s.c33 * (s.c11 + s.c12) > 2 * s.c13 * s.c13;
  if (!stable) throw bad(phase + ": a crystal of this stiffness is not stable", "check the constants");
}

SolverMaterial read_material(MaterialRow row) {
  SolverMaterial m;
  m.phase = row.phase = row.text("phase");
  if (!is_phase(m.phase))
    throw bad("'" + printable(m.phase) + "' is no phase", "use BINDER, PHASE_0, PHASE_1, …, VOIDS");
  m.name = row.text("name");
  if (m.name.empty()) m.name = m.phase;
  if (!is_name(m.name))
    throw Error("bad-names",
                "the table of materials: solvers cannot read the name '" + printable(m.name) + "'",
                "begin with a letter, and use letters, digits, _ and -");
  m.lattice = row.text("lattice");
  if (!m.lattice.empty() && !kLattices.count(m.lattice))
    throw bad(fmt::format("{}: '{}' is no lattice", m.phase, printable(m.lattice)),
              "use a Pearson symbol: cP, cI, cF, hP, hR, tP, tI, oP, oS, oI, oF, mP, mS or aP");
  m.c_over_a = row.number("c/a");
  m.density = row.number("density kg/m³");
  if (!m.density) m.density = row.number("density kg/m3");
  for (const auto& [value, column] : {std::pair{m.c_over_a, "c/a"}, {m.density, "density kg/m³"}})
    if (value && !(*value > 0))
      throw bad(fmt::format("{}: '{}' is {}", m.phase, column, *value), "use a value above 0");
  const auto isotropic = isotropic_stiffness(row), crystal = crystal_stiffness(row, m.lattice);
  if (isotropic && crystal) throw bad(m.phase + " has both Young's modulus and C_11", "give one of them");
  m.stiffness = isotropic ? isotropic : crystal;
  if (m.stiffness) check_stable(m.phase, *m.stiffness);
  return m;
}

}  // namespace

bool Stiffness::isotropic() const {
  const double most = 1e-6 * c11;
  return std::abs(c33 - c11) < most && std::abs(c13 - c12) < most && std::abs(c66 - c44) < most &&
         std::abs(c11 - c12 - 2 * c44) < most;
}

std::string phase_key(const Region& r) {
  if (r.is == Region::Is::Binder) return "BINDER";
  if (r.is == Region::Is::Void) return "VOIDS";
  return fmt::format("PHASE_{}", r.phase - 1);
}

SolverMaterials::SolverMaterials(const Table& table) {
  for (const std::string& column : table.columns)
    if (std::find(kColumns.begin(), kColumns.end(), column) == kColumns.end())
      throw bad("unknown column '" + printable(column) + "'",
                fmt::format("the columns are {}", fmt::join(kColumns, ", ")));
  if (table.column("phase") < 0)
    throw Error("no-column", "the table of materials has no column 'phase'",
                "add it, with BINDER, PHASE_0, PHASE_1, …, VOIDS");
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    SolverMaterial m = read_material({table, row});
    for (const SolverMaterial& other : all_) {
      if (other.phase == m.phase) throw bad("two rows for " + m.phase, "delete one");
      if (same_name(other.name, m.name))
        throw Error("bad-names", "the table of materials: two phases have the name " + m.name,
                    "rename one; upper and lower case count as equal");
    }
    all_.push_back(std::move(m));
  }
}

const SolverMaterial& SolverMaterials::of(const std::string& phase) const {
  for (const SolverMaterial& m : all_)
    if (m.phase == phase) return m;
  throw Error("no-material", "the table of materials has no row for " + phase, "add it");
}

const SolverMaterial& SolverMaterials::of(const Region& r) const { return of(phase_key(r)); }

void SolverMaterials::require_stiffness(const Regions& regions, bool oriented) const {
  for (const Region& r : regions.all) {
    if (r.voxels == 0) continue;
    const SolverMaterial& m = of(r);
    if (!m.stiffness)
      throw Error("no-material", "the table of materials has no stiffness for " + m.phase,
                  "give 'young GPa' and 'poisson', or 'C_11 GPa', …");
    if (!m.stiffness->isotropic() && !(oriented && r.particle >= 0))
      throw Error(
          "no-orientations",
          fmt::format("{} ({}) is not isotropic, and {} has no orientation", m.phase, m.name, r.name()),
          "give it 'young GPa' and 'poisson', or connect particles and set regions: particles");
  }
}

std::uint32_t dream3d_crystal(const std::string& lattice) {
  const auto it = kLattices.find(lattice);
  return it == kLattices.end() ? kUnknownCrystal : it->second;
}

}  // namespace terrazzo::exporting
