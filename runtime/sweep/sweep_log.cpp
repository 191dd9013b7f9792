#include "runtime/sweep/sweep_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <initializer_list>
#include <nlohmann/json.hpp>

#include "graph/input_file.h"
#include "runtime/files.h"
#include "runtime/files/descriptor.h"
#include "runtime/files/host_name.h"
#include "runtime/files/json_input.h"
#include "runtime/json_text.h"

namespace terrazzo {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

// "12_3" for a task of an array, "12" for a job, "process 4711" without Slurm.
std::string task() {
  const std::string array = variable("SLURM_ARRAY_JOB_ID"), job = variable("SLURM_JOB_ID");
  if (!array.empty()) return array + "_" + variable("SLURM_ARRAY_TASK_ID");
  return job.empty() ? fmt::format("process {}", ::getpid()) : job;
}

std::string machine() {
  if (const std::string node = variable("SLURMD_NODENAME"); !node.empty()) return node;
  return host_name();
}

// Whether every entry that somebody reads has its type.
bool is_event(const json& line) {
  if (!line.is_object() || !line.contains("event")) return false;
  for (const auto& [name, v] : line.items()) {
    const auto is = [&name = name](std::initializer_list<const char*> names) {  // Clang 14 needs its name
      return std::find(names.begin(), names.end(), name) != names.end();
    };
    bool good = true;
    if (is({"event", "host", "task", "sweep", "status", "message"}))
      good = v.is_string();
    else if (is({"point", "computed", "cached", "twice"}))
      good = v.is_number_unsigned();
    else if (is({"time"}))
      good = v.is_number_integer();
    else if (is({"seconds", "twice_seconds"}))
      good = v.is_number();
    else if (is({"errors"}))
      good = v.is_array() && std::all_of(v.begin(), v.end(), [](const json& e) { return e.is_string(); });
    if (!good) return false;
  }
  return true;
}

}  // namespace

fs::path jobs_folder(const fs::path& out) { return out / "jobs"; }
fs::path shared_report(const fs::path& out) { return jobs_folder(out) / "shared.json"; }

std::string chunk_name(std::size_t chunk, std::size_t chunks) {
  return fmt::format("chunk-{}-of-{}", chunk, chunks);
}

bool WorkerLog::write(json event) const {
  event["host"] = machine();
  event["task"] = task();
  event["time"] = static_cast<std::int64_t>(std::time(nullptr));
  const std::string line = json_text(event) + "\n";
  // Opened for each line: network file systems show a line to others when the file is closed. A pipe or a
  // link in its place gets nothing.
  const Descriptor file(
      ::open(file_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC, 0666));
  struct stat s;
  return file.fd >= 0 && ::fstat(file.fd, &s) == 0 && S_ISREG(s.st_mode) &&
         ::write(file.fd, line.data(), line.size()) == static_cast<ssize_t>(line.size());
}

LogReader::LogReader(fs::path file, bool skip) : file_(std::move(file)) {
  std::error_code error;
  const auto size = fs::file_size(file_, error);
  if (skip && !error) offset_ = size;
}

std::vector<json> LogReader::news() {
  std::vector<json> out;
  const InputFile file(file_);
  if (!file || file.size() <= offset_) return out;
  if (file.size() - offset_ > kMostTextBytes) {
    ++damaged_;
    return out;
  }
  std::string text(file.size() - offset_, '\0');
  const ssize_t got = ::pread(file.descriptor(), text.data(), text.size(), offset_);
  if (got <= 0) return out;
  text.resize(got);
  std::size_t at = 0;
  for (std::size_t end; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
    json line = json_or_null(std::string_view(text).substr(at, end - at));
    if (is_event(line))
      out.push_back(std::move(line));
    else if (end > at)
      ++damaged_;
  }
  offset_ += at;
  return out;
}

}  // namespace terrazzo
