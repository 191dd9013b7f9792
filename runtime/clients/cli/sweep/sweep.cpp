#include "runtime/sweep/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "graph/exception_text.h"
#include "runtime/bundle/bundle.h"
#include "runtime/cache/disk_cache.h"
#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/placeholders.h"
#include "runtime/clients/cli/slurm/slurm_detached.h"
#include "runtime/clients/cli/slurm/slurm_executor.h"
#include "runtime/clients/cli/slurm/slurm_options.h"
#include "runtime/clients/cli/sweep/sweep_point.h"
#include "runtime/clients/cli/sweep/sweep_sheet.h"
#include "runtime/files.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

struct SweepCommand : GraphOptions {
  std::vector<std::string> vary;
  std::string preview = "preview.png";
  int jobs = 1;
  bool plan = false;
  SlurmOptions slurm;
};

// Runs points in this process, several at a time. They share one store, so shared work runs once.
class LocalExecutor : public Executor {
 public:
  LocalExecutor(const PointRun& run, int jobs) : run_(run), jobs_(jobs) {}

  void run(const SweepPoints& points, const std::atomic<bool>* cancel,
           const std::function<void(const SweepPoint&, const json&)>& finished) override {
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    std::exception_ptr failure;  // the first one; no more points start after it
    const auto work = [&] {
      try {
        for (std::size_t i; (i = next++) < points.size();) {
          const SweepPoint point = points[i];
          json report;
          if (!*cancel) report = evaluate_point(run_, point, cancel);
          if (report.is_object()) write_point_report(run_, point, report);
          const std::lock_guard lock(mutex);
          finished(point, report);
        }
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = points.size();
      }
    };
    std::vector<std::thread> others;
    try {
      for (int k = 1; k < jobs_; ++k) others.emplace_back(work);
    } catch (const std::system_error& e) {
      std::cerr << "warning: running " << others.size() + 1
                << " points at a time, because the system refused more threads (" << exception_text(e)
                << ")\n";
    }
    work();
    for (auto& t : others) t.join();
    if (failure) std::rethrow_exception(failure);
  }

 private:
  const PointRun& run_;
  int jobs_;
};

// What came of the points so far.
struct Outcome {
  explicit Outcome(const SweepPoints& points) : table(points) {}
  SweepTable table;
  std::vector<std::size_t> with_preview;
  std::size_t finished = 0;
  bool failed = false, cancelled = false;

  void add(const SweepCommand& o, std::size_t points, const SweepPoint& p, const json& report) {
    ++finished;
    if (!report.is_object()) {
      cancelled = true;
      return;
    }
    table.add(p.index - 1, report);
    const PointSummary s = summary_of(report);
    for (const auto& error : s.errors) {
      failed = true;
      std::cerr << p.folder << ": error: " << error << '\n';
    }
    for (const auto& node : report.at("nodes"))
      for (const auto& file : node.at("files"))
        if (file.at("path") == o.preview) with_preview.push_back(p.index - 1);
    if (!o.quiet)
      std::cout << fmt::format("[{}/{}] {}: {} computed, {} cached, {:.2f} s\n", finished, points,
                               p.caption(), s.computed, s.cached, s.seconds)
                << std::flush;
  }
  void write_table(const fs::path& path, const ProtectedFiles& keep) const {
    write_atomically(path, keep, [&](const fs::path& temporary) {
      std::ofstream out(temporary, std::ios::binary);
      table.write([&](const std::string& row) { out << row; });
      if (!out.flush()) throw Error("write-failed", fmt::format("cannot write '{}'", path.string()));
    });
  }
};

// What the sweep reads, and what nodes read that no target needs. Throws Error "overwrites-input" or
// "write-failed" if a file of the sweep cannot take its place, before any point runs.
ProtectedFiles files_to_keep(const Program& program, const SweepCommand& o, const SweepFile& sweep) {
  Diagnostics found;
  ProtectedFiles keep(load_graph(o.graph, program.registry(), sweep.points[0].overrides, found));
  for (const auto& [path, content] : sweep.files) keep.add(path);
  for (const char* name : {"sweep.json", "sweep.csv", "sweep.png"}) {
    keep.require_other(fs::path(o.out) / name);
    require_replaceable(fs::path(o.out) / name);
  }
  return keep;
}

int sweep(const Program& program, SweepCommand& o) {
  const bool on_slurm = o.slurm.on_slurm();
  complete_slurm_options(o.slurm, o);
  if (on_slurm && o.jobs > 1)
    throw Error("usage",
                "--jobs is for the local executor; --chunk-size and --parallel divide the points on Slurm");
  std::vector<Vary> vary;
  for (const auto& v : o.vary) vary.push_back(parse_vary(v));
  SweepPoints all(std::move(vary), overrides(o));
  const NodeSet& nodes = program.nodes();  // loaded first: session_options checks the address space left
  if (is_bundle(o.graph)) o.graph = keep_bundle(o.graph, o.out, nodes.registry).string();
  Session session(nodes.registry, nodes.types, session_options(o));
  const auto plan = plan_sweep(program, session, o, std::move(all));
  if (!plan) return kWrongUsage;
  const SweepPoints& points = plan->file.points;
  const ProtectedFiles keep = files_to_keep(program, o, plan->file);
  const fs::path sweep_file = fs::path(o.out) / "sweep.json";
  const Hash hash = plan->file.hash();
  const DetachablePlan detachable{hash, sweep_file, {slurm_job_prefix(hash, o.out)}};
  if (on_slurm && !o.plan)
    if (const auto code = wait_for_detached(detachable, o, o.slurm)) return *code;
  write_sweep_file(sweep_file, plan->file);
  if (o.plan) {
    std::cout << fmt::format("wrote {}: {} points, sweep {}\n", sweep_file.string(), points.size(),
                             hash.text());
    return kDone;
  }
  if (o.slurm.detach && !o.slurm.is_job()) {
    submit_detached(job_role::coordinator, detachable, o, o.slurm);
    return kDone;
  }
  const PointRun run{program,  session, o.graph, o.targets, o.out, std::max(1, threads(o) / o.jobs),
                     o.memory, hash,    keep,    true};
  std::unique_ptr<SlurmExecutor> slurm;
  std::unique_ptr<Executor> local;
  if (on_slurm) {
    slurm = slurm_executor(*plan, session.evaluator().store(), o.out, o, o.slurm);
  } else {
    local = std::make_unique<LocalExecutor>(run, o.jobs);
  }
  Outcome outcome(points);
  Executor& executor = on_slurm ? static_cast<Executor&>(*slurm) : *local;
  executor.run(points, cancel_on_interrupt(),
               [&](const SweepPoint& p, const json& report) { outcome.add(o, points.size(), p, report); });
  if (slurm && slurm->out_of_time()) {
    submit_detached(job_role::coordinator, detachable, o, o.slurm);
    return kDone;
  }
  finish(session, o);
  // The workers leave collecting to this process.
  if (slurm && session.evaluator().store().trouble().empty())
    tend_cache(session.evaluator().store().folder(), o.cache_limit);
  outcome.write_table(fs::path(o.out) / "sweep.csv", keep);
  std::cout << "wrote " << (fs::path(o.out) / "sweep.csv").string() << '\n';
  if (outcome.cancelled || *cancel_on_interrupt()) {
    std::cerr << "interrupted; rerun the same command to resume\n";
    return kInterrupted;
  }
  if (slurm && slurm->gave_up()) {
    std::cerr << fmt::format("{} of {} points have no result; rerun the same command to resume\n",
                             points.size() - outcome.finished, points.size());
    return kNodeFailed;
  }
  std::sort(outcome.with_preview.begin(), outcome.with_preview.end());
  write_sweep_sheet(program, session, o, o.preview, points, outcome.with_preview);
  return outcome.failed ? kNodeFailed : kDone;
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
  add_target_option(*command, *o, "evaluate");
  command->add_option("--jobs", o->jobs, "Number of points to run at a time; they share the threads")
      ->type_name(placeholder::number)
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  add_slurm_options(*command, o->slurm, "points");
  command->add_flag(
      "--plan", o->plan,
      "Write sweep.json into the output folder, and run nothing; `terrazzo sweep-worker` runs it");
  command->add_option("--preview", o->preview, "Output file of each point to show on the contact sheet")
      ->type_name(placeholder::file)
      ->capture_default_str();
  command->add_flag("--quiet", o->quiet, "Print errors only");
  command->callback([o, &program, &exit_code] {
    exit_code = run_as_job(*o, o->slurm, [&] { return sweep(program, *o); });
  });
}

}  // namespace terrazzo::cli
