// Size distributions, K matrices and tables.
#include <fmt/format.h>

#include "graph/text/nearest.h"
#include "nodes/data/kmatrix.h"
#include "nodes/data/size_distribution.h"
#include "nodes/data/table.h"
#include "runtime/clients/python/value_views.h"

namespace terrazzo::python {
namespace {

struct EntryPart {
  py::object owner;
  const SizeDistribution::Entry* entry;
};
struct KEntryPart {
  py::object owner;
  const KMatrix::Entry* entry;
};

py::object cell(const Table::Cell& c) {
  if (const auto* number = std::get_if<double>(&c)) return py::float_(*number);
  return py::str(std::get<std::string>(c));
}

}  // namespace

void bind_sizes(py::module_& m) {
  py::class_<EntryPart>(m, "SizeDistributionEntry", "The densities of one shape and class.")
      .def_property_readonly(
          "shape", [](const EntryPart& p) { return p.entry->shape; },
          "Number of the shape; −1: any shape, by the probabilities of the shapes.")
      .def_property_readonly(
          "cls", [](const EntryPart& p) { return p.entry->cls; }, "Color or particle class.")
      .def_property_readonly(
          "N_V", [](const EntryPart& p) { return view(p.owner, p.entry->N_V); },
          "float64 (n): particles per mm³ in each size class. A view.")
      .def_property_readonly(
          "low", [](const EntryPart& p) { return view(p.owner, p.entry->low); },
          "float64 (n): lower ends of the 90 % intervals of N_V. A view.")
      .def_property_readonly(
          "high", [](const EntryPart& p) { return view(p.owner, p.entry->high); },
          "float64 (n): upper ends of the 90 % intervals of N_V. A view.");
  py::class_<ObjectOf<SizeDistribution>, ValueObject>(
      m, "SizeDistribution",
      "Number of particles per volume in each size class. A size is √(4·A_max/π), with A_max the "
      "area of the particle's largest section.")
      .def_property_readonly(
          "class_edges", [](const py::object& s) { return view(s, the<SizeDistribution>(s).class_edges); },
          "float64 (n + 1): increasing sizes in mm. A view.")
      .def_property_readonly(
          "entries", [](const py::object& s) { return parts<EntryPart>(s, the<SizeDistribution>(s).shapes); },
          "One SizeDistributionEntry for each shape and class.")
      .def_property_readonly(
          "N_V",
          [](const py::object& s) {
            const auto& v = the<SizeDistribution>(s);
            py::array_t<double> out(static_cast<py::ssize_t>(v.classes()));
            double* at = out.mutable_data();
            std::fill(at, at + v.classes(), 0.0);
            for (const auto& e : v.shapes)
              for (std::size_t i = 0; i < v.classes(); ++i) at[i] += e.N_V[i];
            return out;
          },
          "float64 (n): particles per mm³ in each size class, over all shapes and classes. Computed.")
      .def_property_readonly(
          "volume_fraction", [](const py::object& s) { return the<SizeDistribution>(s).volume_fraction; },
          "Volume of the particles divided by the volume.")
      .def_property_readonly(
          "d_max", [](const py::object& s) { return the<SizeDistribution>(s).d_max; },
          "Size of the largest particle in mm.")
      .def_property_readonly(
          "goodness_of_fit", [](const py::object& s) { return the<SizeDistribution>(s).goodness_of_fit; },
          "χ² per degree of freedom of the refitted N_A; 0 without a fit.");
}

void bind_tables(py::module_& m) {
  py::class_<ObjectOf<Table>, ValueObject>(m, "Table",
                                           "Named columns of numbers or text. table['N_V mm⁻³'] is a column.")
      .def("__len__", [](const py::object& s) { return the<Table>(s).rows.size(); })
      .def_property_readonly(
          "columns", [](const py::object& s) { return the<Table>(s).columns; },
          "Names of the columns, with units.")
      .def_property_readonly(
          "rows",
          [](const py::object& s) {
            py::list out;
            for (const auto& row : the<Table>(s).rows) {
              py::list cells;
              for (const auto& c : row) cells.append(cell(c));
              out.append(py::tuple(cells));
            }
            return out;
          },
          "The rows as tuples.")
      .def(
          "__getitem__",
          [](const py::object& s, const std::string& name) -> py::object {
            const auto& t = the<Table>(s);
            const int at = t.column(name);
            if (at < 0)
              throw Error("no-column",
                          fmt::format("the table has no column '{}'{}", name, did_you_mean(name, t.columns)),
                          fmt::format("columns: {}", fmt::join(t.columns, ", ")));
            const std::size_t k = at;
            bool numbers = true;
            for (const auto& row : t.rows) numbers = numbers && k < row.size() && row[k].index() == 0;
            if (numbers) {
              py::array_t<double> out(static_cast<py::ssize_t>(t.rows.size()));
              for (std::size_t i = 0; i < t.rows.size(); ++i)
                out.mutable_data()[i] = std::get<double>(t.rows[i][k]);
              return out;
            }
            py::list out;
            for (const auto& row : t.rows) out.append(k < row.size() ? cell(row[k]) : py::str(""));
            return out;
          },
          py::arg("column"), "A column: float64 (n) if all of it are numbers, otherwise a list. Copied.");
}

void bind_kmatrix(py::module_& m) {
  py::class_<KEntryPart>(m, "KMatrixEntry", "The section statistics of one shape.")
      .def_property_readonly(
          "probability", [](const KEntryPart& p) { return p.entry->probability; },
          "Fraction of all particles, by number.")
      .def_property_readonly(
          "mean_caliper", [](const KEntryPart& p) { return p.entry->mean_caliper; },
          "Mean caliper diameter in mm, at scale 1.")
      .def_property_readonly(
          "max_section_area", [](const KEntryPart& p) { return p.entry->max_section_area; },
          "mm², at scale 1.")
      .def_property_readonly(
          "volume", [](const KEntryPart& p) { return p.entry->volume; }, "mm³, at scale 1.")
      .def_property_readonly(
          "K",
          [](const KEntryPart& p) {
            const auto& k = p.entry->K;  // by column
            return view(p.owner, py::dtype::of<double>(), k.data(),
                        {static_cast<py::ssize_t>(k.rows()), static_cast<py::ssize_t>(k.cols())},
                        {sizeof(double), static_cast<py::ssize_t>(sizeof(double)) * k.rows()});
          },
          "float64 (n, n): row: profile class, column: particle class. A view.")
      .def_property_readonly(
          "cdf", [](const KEntryPart& p) { return view(p.owner, p.entry->cdf); },
          "float64: share of the profiles with √(A/A_max) ≤ (b + 1) / len(cdf). A view.");
  py::class_<ObjectOf<KMatrix>, ValueObject>(
      m, "KMatrix", "Frequency of profiles of each size class from particles of each size class.")
      .def_property_readonly(
          "classes", [](const py::object& s) { return the<KMatrix>(s).classes; }, "Number of classes.")
      .def_property_readonly(
          "residual", [](const py::object& s) { return the<KMatrix>(s).residual; },
          "Largest relative change of a class between half of the samples and all.")
      .def_property_readonly(
          "entries", [](const py::object& s) { return parts<KEntryPart>(s, the<KMatrix>(s).shapes); },
          "One KMatrixEntry for each shape.");
}

}  // namespace terrazzo::python
