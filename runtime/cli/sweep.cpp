#include "runtime/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "runtime/cli/commands.h"
#include "runtime/cli/placeholders.h"
#include "runtime/cli/report.h"
#include "runtime/cli/write_value.h"
#include "runtime/files.h"
#include "runtime/json_text.h"
#include "runtime/provenance.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

struct SweepCommand : GraphOptions {
  std::vector<std::string> vary;
  std::string executor = "local", preview = "preview.png";
  int jobs = 1;
};

// Runs points in this process, several at a time. They share one store, so shared work runs once.
class LocalExecutor : public Executor {
 public:
  LocalExecutor(const Program& program, Session& session, const SweepCommand& o)
      : program_(program), session_(session), o_(o) {}

  void run(const std::vector<SweepPoint>& points, const std::atomic<bool>* cancel,
           const std::function<void(const SweepPoint&, const json&)>& finished) override {
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    std::exception_ptr failure;  // the first one; no more points start after it
    const auto work = [&] {
      try {
        for (std::size_t i; (i = next++) < points.size();) {
          json report;
          if (!*cancel) report = run_point(points[i], cancel);
          const std::lock_guard lock(mutex);
          finished(points[i], report);
        }
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = points.size();
      }
    };
    std::vector<std::thread> others;
    try {
      for (int k = 1; k < o_.jobs; ++k) others.emplace_back(work);
    } catch (const std::system_error& e) {
      std::cerr << "warning: running " << others.size() + 1
                << " points at a time, because the system refused more threads (" << e.what() << ")\n";
    }
    work();
    for (auto& t : others) t.join();
    if (failure) std::rethrow_exception(failure);
  }

 private:
  json run_point(const SweepPoint& point, const std::atomic<bool>* cancel) {
    Diagnostics found;
    const Graph graph = load_graph(o_.graph, program_.registry(), point.overrides, found);
    RunOptions options;
    options.targets = target_nodes(graph, o_.targets);
    options.output_folder = fs::path(o_.out) / point.folder;
    options.threads = std::max(1, threads(o_) / o_.jobs);
    options.memory = o_.memory;
    options.cancel = cancel;
    options.provenance = provenance(graph, point.overrides);
    const RunResult result = session_.evaluator().run(graph, options);
    try {
      session_.history().record(graph, result, session_.evaluator().hashes());
    } catch (const std::exception& e) {
      std::cerr << "warning: " << point.folder << ": cannot save what `terrazzo explain` needs: " << e.what()
                << '\n';
    }
    for (const auto& node : result.nodes)
      if (node.saved) std::cerr << point.folder << ": " << node.saved->message.text() << '\n';
    if (result.cancelled()) return nullptr;
    json report = report_json(graph, result, options.threads, point.overrides, options.output_folder);
    write_text_atomically(options.output_folder / "report.json", json_text(report, 2) + "\n");
    return report;
  }

  const Program& program_;
  Session& session_;
  const SweepCommand& o_;
};

// Checks the graphs of all points, so that errors are reported before the first point runs.
bool check_points(const Program& program, const SweepCommand& o, const std::vector<SweepPoint>& points) {
  for (const auto& p : points) {
    Diagnostics found;
    load_graph(o.graph, program.registry(), p.overrides, found);
    if (!has_errors(found)) continue;
    print(found);
    return false;
  }
  return true;
}

std::string caption(const SweepPoint& p) {
  std::string out;
  for (const auto& [target, value] : p.values) out += (out.empty() ? "" : ", ") + target + " " + value;
  return out;
}

std::string quoted(const std::string& s) { return json_text(s); }  // JSON strings are valid YAML

// Writes a contact sheet of the points' previews, using the LoadImage and ContactSheet nodes.
void write_sheet(const Program& program, Session& session, const SweepCommand& o,
                 const std::vector<SweepPoint>& points, const std::vector<json>& reports) {
  if (!program.registry().find("LoadImage") || !program.registry().find("ContactSheet")) return;
  std::string loads, images, captions;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!reports[i].is_object()) continue;
    for (const auto& node : reports[i].at("nodes"))
      for (const auto& file : node.at("files")) {
        if (file.at("path") != o.preview) continue;
        // Relative, because the name of the output folder may not be UTF-8.
        const fs::path path = fs::path(points[i].folder) / o.preview;
        loads += fmt::format("  p{}: {{type: LoadImage, params: {{path: {}}}}}\n", i, quoted(path.string()));
        images += fmt::format("{}p{}.image", images.empty() ? "" : ", ", i);
        captions += (captions.empty() ? "" : ", ") + quoted(caption(points[i]));
      }
  }
  if (images.empty()) {
    std::cerr << "no contact sheet: no point wrote '" << o.preview
              << "' (choose another file with --preview)\n";
    return;
  }
  Diagnostics found;
  Graph graph = load_graph_text(
      fmt::format("terrazzo: 1\nnodes:\n{}  sheet: {{type: ContactSheet, inputs: {{images: [{}]}}, params: "
                  "{{captions: [{}]}}}}\n",
                  loads, images, captions),
      fs::absolute(o.out) / "sweep.yaml", program.registry(), {}, found);
  print(found);
  if (has_errors(found)) return;
  RunOptions options;
  options.targets = {append_writer(program.registry(), graph, graph.wire_to("sheet.image"), "sweep.png")};
  options.output_folder = o.out;
  options.threads = threads(o);
  options.memory = o.memory;
  options.cancel = cancel_on_interrupt();
  const RunResult r = session.evaluator().run(graph, options);
  for (const auto& n : r.nodes)
    if (n.error) std::cerr << n.error->text() << '\n';
  if (!r.failed() && !r.cancelled())
    std::cout << "wrote " << (fs::path(o.out) / "sweep.png").string() << '\n';
}

int sweep(const Program& program, const SweepCommand& o) {
  std::vector<Vary> vary;
  for (const auto& v : o.vary) vary.push_back(parse_vary(v));
  const auto points = sweep_points(vary, overrides(o));
  if (!check_points(program, o, points)) return wrong_usage;
  const NodeSet& nodes = program.nodes();  // loaded first: session_options checks the address space left
  Session session(nodes.registry, nodes.types, session_options(o));
  LocalExecutor local(program, session, o);
  std::vector<json> reports(points.size());
  std::size_t finished = 0;
  bool failed = false, cancelled = false;
  local.run(points, cancel_on_interrupt(), [&](const SweepPoint& p, const json& report) {
    reports[p.index - 1] = report;
    ++finished;
    if (!report.is_object()) {
      cancelled = true;
      return;
    }
    std::size_t computed = 0, cached = 0;
    for (const auto& node : report.at("nodes")) {
      computed += node.at("status") == "computed";
      cached += node.at("status") == "memory" || node.at("status") == "disk";
      if (node.at("error").is_null()) continue;
      failed = true;
      std::cerr << p.folder << ": error: " << node.at("name").get<std::string>() << ": "
                << node.at("error").at("message").get<std::string>() << '\n';
    }
    if (!o.quiet)
      std::cout << fmt::format("[{}/{}] {}: {}: {} computed, {} cached, {:.2f} s\n", finished, points.size(),
                               p.folder, caption(p), computed, cached, report.at("seconds").get<double>())
                << std::flush;
  });
  finish(session, o);
  write_text_atomically(fs::path(o.out) / "sweep.csv", sweep_table(points, reports));
  std::cout << "wrote " << (fs::path(o.out) / "sweep.csv").string() << '\n';
  if (cancelled) {
    std::cerr << "interrupted; rerun the same command to resume\n";
    return interrupted;
  }
  write_sheet(program, session, o, points, reports);
  return failed ? node_failed : done;
}

}  // namespace

void add_sweep(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand("sweep", "Run a graph for every combination of parameter values");
  auto o = std::make_shared<SweepCommand>();
  add_graph_options(*command, *o);
  command
      ->add_option(
          "--vary", o->vary,
          "Values of a parameter: NODE.PARAM=A,B,C or NODE.PARAM=LO:HI:STEP, or NAME=... for a graph "
          "parameter (repeatable)")
      ->type_name(placeholder::varied_setting)
      ->required()
      ->take_all()
      ->expected(1);
  add_run_options(*command, *o);
  command
      ->add_option("--target", o->targets,
                   "Node to evaluate: NODE, NODE.PORT or a graph output (repeatable; default: graph outputs, "
                   "nodes that write files, and nodes without consumers)")
      ->type_name(placeholder::target)
      ->take_all()
      ->expected(1);
  command->add_option("--jobs", o->jobs, "Number of points to run at a time; they share the threads")
      ->type_name(placeholder::number)
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_option("--executor", o->executor, "Executor that runs the points")
      ->type_name("EXECUTOR")
      ->check(CLI::IsMember({"local"}))
      ->capture_default_str();
  command->add_option("--preview", o->preview, "Output file of each point to show on the contact sheet")
      ->type_name(placeholder::file)
      ->capture_default_str();
  command->add_flag("--quiet", o->quiet, "Print errors only");
  command->callback([o, &program, &exit_code] { exit_code = sweep(program, *o); });
}

}  // namespace terrazzo::cli
