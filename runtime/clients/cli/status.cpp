#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/placeholders.h"
#include "runtime/clients/cli/slurm/run_elements.h"
#include "runtime/clients/cli/slurm/slurm_detached.h"
#include "runtime/clients/cli/slurm/slurm_jobs.h"
#include "runtime/files.h"
#include "runtime/json_text.h"
#include "runtime/sweep/sweep_status.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
using nlohmann::json;
using State = PointStatus::State;
namespace {

struct StatusCommand {
  std::string folder, point;
  bool json = false;
};

// What waits and runs of a sweep. Nothing without Slurm, or if its controller does not answer.
struct QueueStatus {
  std::vector<slurm::Task> tasks;
  std::vector<DetachedJob> jobs;  // that stand for the command
};
std::optional<QueueStatus> queue_of(const SweepStatus& status, const fs::path& folder, const fs::path& out) {
  std::optional<std::vector<slurm::Task>> all;
  try {
    all = slurm::queue("terrazzo-");
  } catch (const Error&) {  // not installed on this machine
  }
  if (!all) return {};
  std::erase_if(*all, [](const slurm::Task& t) { return !t.active() && !t.completing(); });
  QueueStatus found{{}, detached_jobs(out, *all)};
  for (auto& task : *all)
    if (task.name.starts_with(slurm_job_prefix(status.sweep.hash(), folder)))
      found.tasks.push_back(std::move(task));
  return found;
}

std::string duration(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} seconds", seconds);
  if (seconds < 5400) return fmt::format("{:.0f} minutes", seconds / 60);
  return fmt::format("{:.1f} hours", seconds / 3600);
}

const LogStatus* log_of_task(const SweepStatus& status, const std::string& task) {
  for (const auto& log : status.logs)
    if (log.task == task) return &log;
  return nullptr;
}

// Points that a worker started and whose task Slurm no longer runs are not running.
void forget_dead_workers(SweepStatus& status, const std::vector<slurm::Task>& tasks) {
  for (auto& log : status.logs) {
    if (log.point == 0 || log.task.starts_with("process ")) continue;
    if (std::any_of(tasks.begin(), tasks.end(), [&](const auto& t) { return t.id() == log.task; })) continue;
    auto& point = status.points[log.point - 1];
    if (point.state == State::Running) point.state = State::Waiting;
    log.point = 0;
  }
}

json task_json(const slurm::Task& t) {
  return {{"task", t.id()}, {"name", t.name}, {"state", t.state}, {"node", t.node}, {"reason", t.reason}};
}

json status_json(const SweepStatus& s, const QueueStatus& queue, double seconds_left) {
  json list = json::array();
  json jobs = json::array();
  json failures = json::array();
  json running = json::array();
  for (const auto& t : queue.tasks) list.push_back(task_json(t));
  for (const auto& job : queue.jobs) {
    jobs.push_back(task_json(job.task));
    jobs.back()["role"] = job.role;
  }
  for (const auto& log : s.logs)
    if (log.point > 0)
      running.push_back({{"point", s.sweep.points[log.point - 1].name()},
                         {"worker", log.name},
                         {"host", log.host},
                         {"task", log.task},
                         {"since", log.since}});
  for (const auto& f : s.failures) {
    json failure = {{"message", f.message}};
    if (f.point > 0) failure["point"] = s.sweep.points[f.point - 1].name();
    if (f.log >= 0) {
      const LogStatus& log = s.logs[f.log];
      failure["worker"] = log.name;
      failure["host"] = log.host;
      failure["task"] = log.task;
      failure["log"] = log.text.string();
    }
    failures.push_back(failure);
  }
  return {{"sweep", s.sweep.hash().text()},
          {"points",
           {{"all", s.points.size()},
            {"done", s.count(State::Done)},
            {"failed", s.count(State::Failed)},
            {"running", s.count(State::Running)},
            {"waiting", s.count(State::Waiting)}}},
          {"nodes", {{"computed", s.computed}, {"cached", s.cached}, {"computed_twice", s.twice}}},
          {"seconds_left", std::isfinite(seconds_left) ? json(seconds_left) : json()},
          {"jobs", jobs},
          {"tasks", list},
          {"running", running},
          {"failures", failures}};
}

void print_status(const SweepStatus& s, const std::optional<QueueStatus>& found, double seconds_left) {
  const QueueStatus queue = found.value_or(QueueStatus());
  std::cout << fmt::format("{} points: {} done, {} failed, {} running, {} waiting\n", s.points.size(),
                           s.count(State::Done), s.count(State::Failed), s.count(State::Running),
                           s.count(State::Waiting))
            << fmt::format("{} results computed, {} from the cache, {} computed twice\n", s.computed,
                           s.cached, s.twice);
  if (seconds_left > 0) std::cout << "about " << duration(seconds_left) << " left\n";
  for (const auto& job : queue.jobs)
    std::cout << fmt::format("job {} {}: {}{}\n", job.task.id(), what_it_does(job), job.task.state,
                             job.task.node.empty() ? " (" + job.task.reason + ")" : " on " + job.task.node);
  const std::int64_t now = std::time(nullptr);
  const auto at = [&](const LogStatus& log) {
    return fmt::format("{}, for {}", s.sweep.points[log.point - 1].name(),
                       duration(std::max<std::int64_t>(0, now - log.since)));
  };
  std::size_t pending = 0;
  for (const auto& t : queue.tasks) {
    if (t.state == "PENDING") {
      ++pending;
      continue;
    }
    const LogStatus* log = log_of_task(s, t.id());
    const std::string what = log && log->point > 0 ? at(*log) : t.number ? "" : "what all points share";
    std::cout << fmt::format("{:<12} {:<11} {:<10} {}\n", t.id(), t.state, t.node, what);
  }
  if (pending > 0) {
    const auto t = std::find_if(queue.tasks.begin(), queue.tasks.end(),
                                [](const auto& t) { return t.state == "PENDING"; });
    std::cout << fmt::format("{} tasks wait in Slurm's queue ({})\n", pending, t->reason);
  }
  for (const auto& log : s.logs)
    if (log.point > 0 && log.task.starts_with("process "))
      std::cout << fmt::format("{:<12} {:<11} {:<10} {}\n", log.task, "started", log.host, at(log));
  if (found && queue.tasks.empty() && queue.jobs.empty() && s.count(State::Running) == 0 &&
      s.count(State::Done) < s.points.size())
    std::cout << "nothing is queued; the same command resumes\n";
  for (const auto& log : s.logs)
    if (log.finished && log.name == job_role::finisher)
      std::cout << fmt::format("the rest of the graph is done ({} on {})\n", log.task, log.host);
  for (const auto& f : s.failures) {
    const LogStatus* log = f.log < 0 ? nullptr : &s.logs[f.log];
    std::cout << fmt::format(
        "{}{}: {}\n", f.point > 0 ? s.sweep.points[f.point - 1].name() : log->name,
        log && !log->host.empty() ? fmt::format(" on {} ({})", log->host, log->task) : "", f.message);
  }
}

// The folder of the sweep itself. For the output folder of a run, that of the round which was started last.
fs::path sweep_folder(const fs::path& folder) {
  fs::path out = folder;
  std::error_code error;
  fs::file_time_type latest;
  if (fs::exists(folder / "sweep.json", error)) return out;
  for (std::size_t k = 1; fs::exists(round_folder(folder, k) / "sweep.json", error); ++k)
    if (const auto time = fs::last_write_time(round_folder(folder, k) / "sweep.json", error);
        !error && (k == 1 || time > latest)) {
      latest = time;
      out = round_folder(folder, k);
    }
  return out;
}

void show_status(const StatusCommand& o) {
  const fs::path folder = sweep_folder(o.folder);
  SweepStatus s = sweep_status(folder, o.folder);
  for (const auto& [log, lines] : s.damaged)
    std::cerr << fmt::format("warning: '{}' has {} damaged lines, which are left out\n", log.string(), lines);
  if (o.point == job_role::coordinator || o.point == job_role::finisher) {
    const auto text = read_file(jobs_folder(o.folder) / (o.point + ".txt"));
    if (!text)
      throw Error("no-log", fmt::format("there is no log of the {}", o.point), "--detach starts one");
    std::cout << *text;
    return;
  }
  if (!o.point.empty()) {
    const auto point = s.sweep.points.find(o.point);
    if (!point) throw Error("usage", fmt::format("the sweep has no point '{}'", o.point));
    std::cout << point_log(s, *point);
    return;
  }
  const auto queue = queue_of(s, folder, o.folder);
  if (queue) forget_dead_workers(s, queue->tasks);
  for (const auto& job : queue.value_or(QueueStatus()).jobs)  // it is queued again
    std::erase_if(s.failures,
                  [&](const SweepFailure& f) { return f.log >= 0 && s.logs[f.log].name == job.role; });
  const double left = s.count(State::Waiting) + s.count(State::Running);
  const double running = s.count(State::Running);
  const double seconds_left = left == 0                      ? 0
                              : s.timed == 0 || running == 0 ? std::nan("")
                                                             : left * s.seconds / s.timed / running;
  if (o.json)
    std::cout << json_text(status_json(s, queue.value_or(QueueStatus()), seconds_left), 2) << '\n';
  else
    print_status(s, queue, seconds_left);
}

}  // namespace

void add_status(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("status", "Show how far a sweep is, what runs where, and what failed");
  auto o = std::make_shared<StatusCommand>();
  command->add_option("folder", o->folder, "The output folder of a sweep, or of a run on Slurm")
      ->type_name(placeholder::folder)
      ->required();
  auto* as_json = command->add_flag("--json", o->json, "Print JSON");
  command
      ->add_option("--log", o->point,
                   "Print what the worker of this point printed, such as point-012 or 12; or what the job of "
                   "--detach printed: coordinator or finisher")
      ->type_name("POINT")
      ->excludes(as_json);
  command->callback([o, &exit_code] {
    show_status(*o);
    exit_code = kDone;
  });
}

}  // namespace terrazzo::cli
