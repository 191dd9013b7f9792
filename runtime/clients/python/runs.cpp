// The class of runs: evaluations that are waited for, and their results.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "runtime/clients/cli/report.h"
#include "runtime/clients/python/run_object.h"
#include "runtime/files.h"
#include "runtime/files/protected_files.h"
#include "runtime/json_text.h"

namespace terrazzo::python {
namespace {

py::dict progress(const RunObject& run) {
  const ProgressQueue::State s = run.progress();
  py::list running;
  for (const auto& [node, r] : s.running)
    running.append(py::make_tuple(run.graph().nodes[node].path, r.fraction, r.note));
  py::dict out;
  out["done"] = s.done;
  out["needed"] = s.needed;
  out["running"] = running;
  return out;
}

py::list nodes(RunObject& run) {
  const RunResult& r = run.result();
  py::list out;
  for (std::size_t i = 0; i < r.nodes.size(); ++i) {
    const NodeResult& n = r.nodes[i];
    if (n.status == Status::Unneeded) continue;
    std::uint64_t bytes = 0;
    for (const auto& [port, record] : n.outputs) bytes += record.bytes;
    std::vector<std::string> files;
    for (const auto& f : n.files) files.push_back(f.path);
    py::dict d;
    d["name"] = run.graph().nodes[i].path;
    d["type"] = run.graph().nodes[i].type->name;
    d["status"] = name_of(n.status);
    d["seconds"] = n.seconds;
    d["bytes"] = bytes;
    d["metrics"] = n.metrics;
    d["warnings"] = n.warnings;
    d["files"] = files;
    d["key"] = n.key.text();
    d["error"] = n.error ? to_python(*n.error) : py::none();
    d["saved"] = n.saved ? to_python(n.saved->message) : py::none();
    out.append(d);
  }
  return out;
}

}  // namespace

void bind_runs(py::module_& m) {
  py::class_<KeptOutput>(m, "KeptOutput").def("value", [](const KeptOutput& k) {
    return to_python(k.value());
  });
  py::class_<RunObject>(m, "RunCore")
      .def(py::init<py::object, std::vector<std::string>, std::string, std::optional<int>>())
      .def("done", &RunObject::done)
      .def("cancel", &RunObject::cancel)
      .def("wait", &RunObject::wait)
      .def("progress", progress)
      .def("nodes", nodes)
      .def("seconds", [](RunObject& r) { return r.result().seconds; })
      .def("trouble", [](RunObject& r) { return r.result().trouble; })
      .def("canceled", [](RunObject& r) { return r.result().cancelled(); })
      .def("write_report",
           [](RunObject& r, const std::string& folder) {
             write_text_atomically(
                 std::filesystem::path(folder) / "report.json", ProtectedFiles(r.graph()),
                 json_text(cli::report_json(r.graph(), r.result(), r.threads(), {}, folder), 2) + "\n");
           })
      .def("raise_errors", &RunObject::raise_errors)
      .def("elements", &RunObject::elements)
      .def("keep", &RunObject::keep)
      .def("value", [](RunObject& r, const std::string& output) { return to_python(r.value(output)); });
  m.def("end_all_runs", end_all_runs);
  m.def("leave_without_exit_handlers", leave_without_exit_handlers);
}

}  // namespace terrazzo::python
