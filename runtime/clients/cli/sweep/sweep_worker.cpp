#include <fmt/format.h>

#include <charconv>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "graph/exception_text.h"
#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/placeholders.h"
#include "runtime/clients/cli/sweep/sweep_point.h"
#include "runtime/files.h"
#include "runtime/json_text.h"
#include "runtime/report/report_format.h"
#include "runtime/sweep/sweep_file.h"
#include "runtime/sweep/sweep_log.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

struct WorkerCommand : GraphOptions {
  std::string file, chunk, expected;
  bool shared = false, need_shared = false;
};

struct Chunk {
  std::size_t number = 0, count = 1;
};

Chunk parse_chunk(const std::string& text) {
  Chunk out;
  const char* end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, out.number);
  const bool slash = number.ec == std::errc() && number.ptr != end && *number.ptr == '/';
  const auto count = slash ? std::from_chars(number.ptr + 1, end, out.count) : number;
  if (!slash || count.ec != std::errc() || count.ptr != end || out.number >= out.count)
    throw Error("usage", fmt::format("--chunk '{}' is not K/N with 0 ≤ K < N", text),
                "N tasks with K from 0 to N − 1 run all points");
  return out;
}

// One worker: a process that runs a chunk of points, or the nodes that all points share.
class Worker {
 public:
  Worker(const Program& program, const WorkerCommand& o, SweepFile sweep, const fs::path& out, WorkerLog log)
      : sweep_(std::move(sweep)),
        log_(std::move(log)),
        cancel_(cancel_on_interrupt()),
        need_shared_(o.need_shared),
        keep_(protected_files(sweep_)),
        session_(program.registry(), program.types(), session_options(o)),
        run_{program,    session_, sweep_.graph,  sweep_.targets, out,
             threads(o), o.memory, sweep_.hash(), keep_,          false} {
    require_same_version(sweep_, program.registry());
    if (!o.expected.empty() && run_.sweep.text() != o.expected)
      throw Error("other-sweep",
                  fmt::format("'{}' describes another sweep than when this worker was submitted",
                              (out / "sweep.json").string()));
    require_same_files(sweep_, session_.evaluator().hashes());
    if (need_shared_) shared_report_ = read_shared_report(sweep_, out);
    if (!sweep_.points.parts().empty()) run_.same_graph = load_point(run_, sweep_.points[0]);
  }

  int run_chunk(Chunk chunk) {
    const std::size_t n = sweep_.points.size();
    bool failed = false;
    const auto [first, last] = points_of(chunk.number, chunk.count, n);
    for (std::size_t i = first; i < last; ++i) {
      const SweepPoint point = sweep_.points[i];
      if (is_finished(point)) continue;
      if (need_shared_ && !is_shared_in_cache(sweep_, shared_report_, session_.evaluator().store()))
        return worker_without_shared();
      log_.write({{"event", "started"}, {"point", point.index}});
      std::cerr << fmt::format("=== {} started\n", point.folder);
      const json report = evaluate_point(run_, point, cancel_);
      if (!report.is_object()) return interrupted_worker();
      require_same_reads(sweep_, report);
      const PointSummary s = summary_of(report);
      // Another machine may have room. So the point stays without a report.
      if (s.cannot_write) throw Error("write-failed", fmt::format("{}: {}", point.folder, s.errors.front()));
      write_point_report(run_, point, report);
      for (const auto& e : s.errors) std::cerr << point.folder << ": error: " << e << '\n';
      failed = failed || s.status != "done";
      tell_finished(point.index, s);
      std::cerr << fmt::format("=== {} {}: {} computed, {} cached, {:.2f} s\n", point.folder, s.status,
                               s.computed, s.cached, s.seconds);
    }
    return failed ? kNodeFailed : kDone;
  }

  int run_shared() {
    SweepPoint point = sweep_.points[0];
    point.targets = sweep_.shared;
    const json report = evaluate_point(run_, point, cancel_);
    if (!report.is_object()) return interrupted_worker();
    require_same_reads(sweep_, report);
    const PointSummary s = summary_of(report);
    for (const auto& e : s.errors) std::cerr << "error: " << e << '\n';
    write_text_atomically(shared_report(run_.out), keep_, json_text(report, 2) + "\n");  // before the event
    tell_finished(0, s);
    return s.status == "done" ? kDone : kNodeFailed;
  }

  // Warns about what cost time but no results.
  void tell_trouble() {
    if (const std::string trouble = session_.evaluator().store().trouble(); !trouble.empty())
      warn(trouble + " (results of this worker are not kept in the cache)");
    if (const auto twice = session_.evaluator().store().computed_twice(); twice.differing > 0)
      warn(
          fmt::format("{} results differ from those that another machine computed meanwhile; the machines' "
                      "processors or libraries differ",
                      twice.differing));
  }

 private:
  bool is_finished(const SweepPoint& point) {
    const json report = read_report(run_.out / point.folder / "report.json");
    return is_finished_point(report, run_.sweep, run_.out / point.folder) &&
           is_in_cache(point, report, session_.evaluator().store());
  }

  void tell_finished(std::size_t index, const PointSummary& s) {
    const auto twice = session_.evaluator().store().computed_twice();
    log_.write({{"event", "finished"},
                {"sweep", run_.sweep.text()},
                {"point", index},
                {"status", s.status},
                {"seconds", s.seconds},
                {"computed", s.computed},
                {"cached", s.cached},
                {"twice", twice.count - told_.count},
                {"twice_seconds", twice.seconds - told_.seconds},
                {"errors", s.errors}});
    told_ = twice;
  }

  int worker_without_shared() {
    log_.write({{"event", "missing"}});
    std::cerr << "stopped: the cache lacks what all points share\n";
    return kNodeFailed;
  }

  int interrupted_worker() {
    log_.write({{"event", "interrupted"}});
    std::cerr << "interrupted; finished points and nodes are kept\n";
    return kInterrupted;
  }

  void warn(const std::string& message) {
    std::cerr << "warning: " << message << '\n';
    log_.write({{"event", "warning"}, {"message", message}});
  }

  const SweepFile sweep_;
  const WorkerLog log_;
  const std::atomic<bool>* cancel_;
  const bool need_shared_;
  json shared_report_;
  const ProtectedFiles keep_;
  Session session_;
  PointRun run_;
  ComputedTwice told_;
};

int sweep_worker(const Program& program, WorkerCommand& o) {
  if (o.shared != o.chunk.empty()) throw Error("usage", "give either --chunk K/N or --shared");
  const Chunk chunk = o.shared ? Chunk{} : parse_chunk(o.chunk);
  const fs::path file = fs::absolute(o.file).lexically_normal();
  const fs::path out = file.parent_path();
  if (!o.cache.empty()) o.cache = fs::absolute(o.cache).string();
  const fs::path jobs = jobs_folder(out);
  const WorkerLog log(
      jobs / ((o.shared ? std::string(shared_name) : chunk_name(chunk.number, chunk.count)) + ".jsonl"));
  try {
    SweepFile sweep = read_sweep_file(file);
    std::error_code error;
    fs::create_directories(jobs, error);
    fs::current_path(sweep.folder, error);
    if (error)
      throw Error("sweep-file", fmt::format("cannot enter the sweep's working folder '{}': {}", sweep.folder,
                                            error.message()));
    o.out = out.string();
    program.nodes();  // loaded first: session_options checks the address space left
    Worker worker(program, o, std::move(sweep), out, log);
    const int result = o.shared ? worker.run_shared() : worker.run_chunk(chunk);
    worker.tell_trouble();
    return result;
  } catch (const Error& e) {
    const std::string& code = e.diagnostic().code;
    const bool refused = code == "other-version" || code == "input-changed" || code == "other-sweep";
    log.write({{"event", refused ? "refused" : "stopped"}, {"message", e.diagnostic().message}});
    throw;
  } catch (const std::exception& e) {
    log.write({{"event", "stopped"}, {"message", exception_text(e)}});
    throw;
  }
}

}  // namespace

void add_sweep_worker(CLI::App& app, const Program& program, int& exit_code) {
  auto* command = app.add_subcommand(
      "sweep-worker",
      "Run some points of a planned sweep; for batch systems and for several machines by hand");
  auto o = std::make_shared<WorkerCommand>();
  command->add_option("file", o->file, "The sweep.json that `terrazzo sweep` wrote")
      ->type_name(placeholder::file)
      ->required();
  command->add_option("--chunk", o->chunk, "Run part K of N of the points, K from 0; skips finished points")
      ->type_name("K/N");
  command->add_flag("--shared", o->shared, "Compute only the work that all points share");
  command->add_flag("--need-shared", o->need_shared,
                    "Stop if the cache lacks the work that all points share, instead of repeating it");
  command->add_option("--expect", o->expected, "Refuse to run if this is not the sweep's hash")
      ->type_name("HASH");
  command->add_option("--threads", o->threads, "Number of threads; 0: one per CPU core")
      ->type_name(placeholder::number)
      ->check(CLI::Range(0, 1024));
  command
      ->add_option("--memory", o->memory,
                   "Bytes of results to keep in memory in addition to those in use, such as 500M or 4G "
                   "(default: 2 GiB). If given, also the limit for loading one file")
      ->type_name(placeholder::bytes)
      ->transform(CLI::AsSizeValue(true));
  add_cache_options(*command, *o);
  command->callback([o, &program, &exit_code] { exit_code = sweep_worker(program, *o); });
}

}  // namespace terrazzo::cli
