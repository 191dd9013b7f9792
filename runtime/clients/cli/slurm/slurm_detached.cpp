#include "runtime/clients/cli/slurm/slurm_detached.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "graph/exception_text.h"
#include "runtime/clients/cli/slurm/slurm_jobs.h"
#include "runtime/files.h"
#include "runtime/sweep/sweep_log.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kDigits = 12;  // of a hash in a job's name

std::string folder_prefix(const fs::path& out) {
  return "terrazzo-" + hash_of(fs::absolute(out).lexically_normal().string()).text().substr(0, kDigits) + "-";
}

std::string job_name(const std::string& role, const fs::path& out, const Hash& plan) {
  return folder_prefix(out) + role + "-" + plan.text().substr(0, kDigits);
}

// The words of this process's command line, without the program.
std::vector<std::string> own_arguments() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);  // its size is unknown
  const std::string all(std::istreambuf_iterator<char>(file), {});
  std::vector<std::string> out;
  for (std::size_t at = 0; at < all.size();) {
    const auto end = std::min(all.find('\0', at), all.size());
    out.push_back(all.substr(at, end - at));
    at = end + 1;
  }
  if (out.empty()) throw Error("no-slurm", "cannot read this process's command line in /proc");
  out.erase(out.begin());
  return out;
}

fs::path write_script(const std::string& role, const DetachablePlan& plan, const GraphOptions& o,
                      const SlurmOptions& s) {
  // Its time limit is announced by a signal, which must not end the program before it listens.
  std::string text = fmt::format("#!/bin/bash\n{}trap '' USR1\ncd {} || exit 1\n", profile_text(s),
                                 quoted_word(fs::current_path().string()));
  if (!s.profile.empty())  // it may come from the environment, which --export=NONE removes
    text += fmt::format("export TERRAZZO_SLURM_PROFILE={}\n", quoted_word(fs::absolute(s.profile).string()));
  text += fmt::format("exec ${{TERRAZZO_COORDINATOR:-{}}}",
                      quoted_word(fs::read_symlink("/proc/self/exe").string()));
  for (const auto& word : own_arguments())
    if (!word.starts_with("--job-role") && !word.starts_with("--job-plan")) text += " " + quoted_word(word);
  if (o.cache.empty()) text += " --cache " + quoted_word(fs::absolute(default_cache()).string());
  if (role == job_role::finisher && o.threads == 0) text += " --threads \"${SLURM_CPUS_ON_NODE:-0}\"";
  text += fmt::format(" --job-role={} --job-plan={}\n", role, plan.hash.text());
  const fs::path path = jobs_folder(o.out) / (role + ".sh");
  write_text_atomically(path, text);
  return path;
}

// Names the file that has changed, if one has.
void require_same_plan(const DetachablePlan& plan, const SlurmOptions& s) {
  if (plan.hash.text() == s.job_plan) return;
  if (std::error_code error; fs::exists(plan.sweep_file, error)) {
    FileHashes hashes;
    require_same_files(read_sweep_file(plan.sweep_file), hashes);
  }
  throw Error("input-changed",
              "the graph, its files or the program have changed since the command was detached",
              "restore them, or run the command again to start with the new ones");
}

std::optional<std::vector<slurm::Task>> queue() {
  try {
    return slurm::queue("terrazzo-");
  } catch (const Error&) {  // not installed here
    return {};
  }
}

std::atomic<bool> nearly_over{false};
void on_warning(int) { nearly_over = true; }

}  // namespace

const std::atomic<bool>* time_is_nearly_over() { return &nearly_over; }

const char* what_it_does(const DetachedJob& job) {
  return job.role == job_role::coordinator ? "coordinates" : "runs the rest of the graph";
}

std::vector<DetachedJob> detached_jobs(const fs::path& out, const std::vector<slurm::Task>& tasks) {
  std::vector<DetachedJob> found;
  for (const auto& task : tasks)
    for (const char* role : {job_role::coordinator, job_role::finisher})
      if (const std::string start = folder_prefix(out) + role + "-"; task.name.starts_with(start))
        found.push_back({task, role, task.name.substr(start.size())});
  return found;
}

std::optional<int> wait_for_detached(const DetachablePlan& plan, const GraphOptions& o,
                                     const SlurmOptions& s) {
  if (s.is_job()) {
    require_same_plan(plan, s);
    return {};
  }
  const std::atomic<bool>* cancel = cancel_on_interrupt();
  std::set<std::string> waited;  // the jobs that were waited for
  for (auto tasks = queue();; tasks = queue()) {
    bool active = !tasks.has_value() && !waited.empty();  // while the controller does not answer
    for (const auto& job : detached_jobs(o.out, tasks.value_or(std::vector<slurm::Task>()))) {
      const std::string id = job.task.id();
      if (waited.count(id) && job.task.state == "CANCELLED") {
        std::cerr << fmt::format("job {} was canceled from outside; rerun the same command to resume\n", id);
        return kNodeFailed;
      }
      if (!job.task.active() && !job.task.completing()) continue;
      if (!plan.hash.text().starts_with(job.plan))
        throw Error("other-sweep",
                    fmt::format("job {} {} for another command in '{}'", id, what_it_does(job), o.out),
                    fmt::format("cancel it with `scancel {}`, or use another output folder", id));
      active = true;
      if (waited.insert(id).second)
        std::cerr << fmt::format("note: job {} {}; see `terrazzo status {}`\n", id, what_it_does(job), o.out);
    }
    if (active && s.detach) return kDone;
    if (!active) break;
    const auto next = std::chrono::steady_clock::now() + std::chrono::duration<double>(s.poll);
    while (!*cancel && std::chrono::steady_clock::now() < next)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (!*cancel) continue;
    std::set<std::string> names;
    for (const auto& job : detached_jobs(o.out, tasks.value_or(std::vector<slurm::Task>())))
      names.insert(job.task.name);
    for (const auto& task : tasks.value_or(std::vector<slurm::Task>()))
      for (const auto& prefix : plan.job_prefixes)
        if (task.name.starts_with(prefix)) names.insert(task.name);
    for (const auto& name : names) slurm::cancel(name);
    std::cerr << "interrupted; canceled the jobs; rerun the same command to resume\n";
    return kInterrupted;
  }
  for (const char* role : {job_role::coordinator, job_role::finisher}) {  // no longer true
    std::error_code error;
    fs::remove(jobs_folder(o.out) / (std::string(role) + ".jsonl"), error);
  }
  return {};
}

void submit_detached(const std::string& role, const DetachablePlan& plan, const GraphOptions& o,
                     const SlurmOptions& s) {
  slurm::largest_array();  // throws if Slurm does not answer
  std::error_code error;
  fs::create_directories(jobs_folder(o.out), error);
  auto command = sbatch_arguments(job_name(role, o.out, plan.hash), jobs_folder(o.out), role + ".txt", o, s);
  // "singleton": never two at a time, such as this one and the one that it replaces.
  command.push_back("--dependency=singleton");
  if (role == job_role::coordinator) {
    for (const char* option : {"--nodes=1", "--ntasks=1", "--cpus-per-task=1", "--signal=B:USR1@120"})
      command.push_back(option);
    command.insert(command.end(), s.coordinator_options.begin(), s.coordinator_options.end());
  }
  command.push_back(write_script(role, plan, o, s).string());
  const auto job = slurm::submit(command);
  std::cerr << fmt::format("job {} {}; `terrazzo status {}` shows progress, and `scancel {}` cancels\n", job,
                           what_it_does({{}, role, ""}), o.out, job);
}

int run_as_job(const GraphOptions& o, const SlurmOptions& s, const std::function<int()>& command) {
  if (!s.is_job()) return command();
  struct sigaction action = {};
  action.sa_handler = on_warning;
  ::sigaction(SIGUSR1, &action, nullptr);
  const WorkerLog log(jobs_folder(o.out) / (s.job_role + ".jsonl"));
  const auto stopped = [&](const std::string& message) {
    log.write({{"event", "stopped"}, {"message", message}});
  };
  log.write({{"event", "started"}});
  try {
    const int code = command();
    if (code == kDone)
      log.write({{"event", "finished"}, {"status", "done"}});
    else if (code == kInterrupted)
      log.write({{"event", "interrupted"}});
    else
      stopped(fmt::format("ended with exit code {}; log: {}", code,
                          fs::absolute(jobs_folder(o.out) / (s.job_role + ".txt")).string()));
    return code;
  } catch (const Error& e) {
    stopped(e.diagnostic().message);
    throw;
  } catch (const std::exception& e) {
    stopped(exception_text(e));
    throw;
  }
}

}  // namespace terrazzo::cli
