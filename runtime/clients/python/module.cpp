// The extension `terrazzo._core`. The package beside it makes the interface that docs/python.md describes.
#include <cstdlib>

#include "graph/describe.h"
#include "graph/output_path.h"
#include "nodes/register_nodes.h"
#include "runtime/clients/cli/options.h"
#include "runtime/clients/python/bind.h"
#include "runtime/files.h"
#include "runtime/json_text.h"
#include "runtime/plugin.h"
#include "runtime/report/provenance.h"

namespace terrazzo::python {
namespace {

struct Types {
  Registry registry;
  ValueTypes values;
  Diagnostics plugins;  // those that could not be loaded
};

// Never destroyed, because graphs of other threads may still refer to node types when the interpreter exits.
Types& types() {
  static Types& all = *[] {
    auto* t = new Types;
    register_nodes(t->registry);
    register_value_types(t->values);
    if (const char* list = std::getenv("TERRAZZO_PLUGIN_PATH"))
      t->plugins = load_plugins(list, t->registry, t->values);
    return t;
  }();
  return all;
}

}  // namespace

Registry& registry() { return types().registry; }
const ValueTypes& value_types() { return types().values; }

py::object from_json(const std::string& text) {
  static const py::handle loads = py::module_::import("json").attr("loads").cast<py::object>().release();
  return loads(text);
}

}  // namespace terrazzo::python

PYBIND11_MODULE(_core, m) {
  using namespace terrazzo;
  using namespace terrazzo::python;
  m.doc() = "The C++ part of terrazzo. Use the package, not this module.";
  bind_errors(m);
  bind_values(m);
  bind_volumes(m);
  bind_arrays(m);
  bind_volume_arrays(m);
  bind_graph(m);
  bind_runs(m);
  bind_python_nodes(m);
  bind_cache(m);
  bind_reproduce(m);
  m.attr("version") = program_version;
  m.def("plugin_problems", [] {
    py::list out;
    for (const auto& d : types().plugins) out.append(to_python(d));
    return out;
  });
  m.def("node_types", [] { return registry().names(); });
  m.def("node_type", [](const std::string& name) -> py::object {
    const NodeType* type = registry().find(name);
    if (!type) throw Error("unknown-type", "there is no node type '" + name + "'");
    return from_json(json_text(describe_json(*type)));
  });
  m.def("range_text", [](const std::string& type, const std::string& parameter) {
    return range_text(*registry().find(type)->find_parameter(parameter));
  });
  m.def("default_text", [](const std::string& type, const std::string& parameter) -> std::string {
    const auto& v = registry().find(type)->find_parameter(parameter)->value;
    return v ? written(*v) : "";
  });
  m.def("value_type_names", [] { return value_types().names(); });
  m.def("value_type_doc", [](const std::string& name) { return value_types().find(name)->doc; });
  m.def("default_cache", [] { return cli::default_cache().string(); });
  m.def("write_text",
        [](const std::string& file, const std::string& text) { write_text_atomically(file, text); });
  m.def("is_reserved_output", [](const std::string& name) { return is_reserved_output(name); });
  m.def("library_folder", [] { return library_folder().string(); });
}
