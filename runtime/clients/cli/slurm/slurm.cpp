#include "runtime/clients/cli/slurm/slurm.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "graph/diagnostic.h"
#include "runtime/files/subprocess.h"

namespace terrazzo::cli::slurm {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> out;
  std::size_t at = 0;
  while (at < text.size()) {
    const auto end = std::min(text.find('\n', at), text.size());
    if (end > at) out.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

template <class Number>
std::optional<Number> number_in(const std::string& text) {
  Number n{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), n);
  if (error != std::errc() || end == text.data()) return {};
  return n;
}

std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace

std::size_t largest_array() {
  Subprocess config;
  try {
    config = run_subprocess({"scontrol", "show", "config"});
  } catch (const Error& e) {
    throw Error("no-slurm", e.diagnostic().message,
                "--executor slurm needs Slurm's commands on this machine; --plan writes a sweep for another "
                "scheduler");
  }
  if (config.exit_code != 0)
    throw Error("no-slurm", "Slurm's controller does not answer: " + one_line(config.err),
                "check with `scontrol ping`");
  std::size_t array = 1001, jobs = 10000;  // Slurm's defaults
  for (const auto& line : lines_of(config.out)) {
    const auto equals = line.find("= ");
    if (equals == std::string::npos) continue;
    const auto value = number_in<std::size_t>(line.substr(equals + 2));
    if (line.starts_with("MaxArraySize") && value) array = *value;
    if (line.starts_with("MaxJobCount") && value) jobs = *value;
  }
  return std::max<std::size_t>(1, std::min(array, jobs / 2));  // others have jobs too
}

std::string Task::id() const { return number ? fmt::format("{}_{}", job, *number) : std::to_string(job); }

bool Task::active() const {
  static const std::array ended = {"COMPLETING", "COMPLETED", "FAILED",        "CANCELLED",
                                   "TIMEOUT",    "NODE_FAIL", "OUT_OF_MEMORY", "PREEMPTED",
                                   "BOOT_FAIL",  "DEADLINE",  "REVOKED"};
  return std::find(ended.begin(), ended.end(), state) == ended.end();
}

bool Task::launch_failed() const {
  return state == "PENDING" &&
         (reason.find("requeued held") != std::string::npos || reason == "JobHoldMaxRequeue");
}

std::optional<std::vector<Task>> queue(const std::string& prefix) {
  const Subprocess squeue =
      run_subprocess({"squeue", "-h", "-r", "-t", "all", "--me", "-o", "%i|%j|%T|%N|%r"});
  if (squeue.exit_code != 0) return {};
  std::vector<Task> out;
  for (const auto& line : lines_of(squeue.out)) {
    std::array<std::string, 5> cells;
    std::size_t at = 0;
    for (std::size_t k = 0; k < cells.size() && at <= line.size(); ++k) {
      const auto end = k + 1 < cells.size() ? std::min(line.find('|', at), line.size()) : line.size();
      cells[k] = line.substr(at, end - at);
      at = end + 1;
    }
    if (!cells[1].starts_with(prefix)) continue;
    Task task;
    task.job = number_in<std::uint64_t>(cells[0]).value_or(0);
    if (const auto bar = cells[0].find('_'); bar != std::string::npos)
      task.number = number_in<std::size_t>(cells[0].substr(bar + 1));
    task.name = cells[1];
    task.state = cells[2];
    task.node = cells[3];
    task.reason = cells[4];
    out.push_back(std::move(task));
  }
  return out;
}

std::uint64_t submit(const std::vector<std::string>& arguments) {
  std::vector<std::string> command = {"sbatch", "--parsable"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const Subprocess sbatch = run_subprocess(command);
  const auto job = number_in<std::uint64_t>(sbatch.out);
  if (sbatch.exit_code != 0 || !job)
    throw Error("sbatch-failed", "Slurm refused the job: " + one_line(sbatch.err),
                "check --partition, --slurm and the profile");
  return *job;
}

void cancel(const std::string& name) { run_subprocess({"scancel", "--me", "--name=" + name}); }

void cancel_task(const std::string& id) { run_subprocess({"scancel", id}); }

std::vector<std::string> nodes(const std::string& partition) {
  std::vector<std::string> command = {"sinfo", "-h", "-N", "-o", "%N"};
  if (!partition.empty()) command.push_back("--partition=" + partition);
  auto out = lines_of(run_subprocess(command).out);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::vector<std::string> words(const std::string& text) {
  std::vector<std::string> out;
  std::string word;
  bool inside = false;
  char quote = 0;
  for (const char c : text) {
    if (quote) {
      if (c == quote)
        quote = 0;
      else
        word += c;
    } else if (c == '\'' || c == '"') {
      quote = c;
      inside = true;
    } else if (c == ' ' || c == '\t' || c == '\n') {
      if (inside) out.push_back(std::move(word));
      word.clear();
      inside = false;
    } else {
      word += c;
      inside = true;
    }
  }
  if (quote) throw Error("usage", fmt::format("--slurm \"{}\": a quote is not closed", text));
  if (inside) out.push_back(std::move(word));
  return out;
}

std::string ranges(const std::vector<std::size_t>& numbers) {
  std::string out;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    out += (out.empty() ? "" : ",") + std::to_string(numbers[i]);
    if (last > i) out += "-" + std::to_string(numbers[last]);
    i = last + 1;
  }
  return out;
}

}  // namespace terrazzo::cli::slurm
