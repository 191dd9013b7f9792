#include "runtime/sweep_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <ctime>
#include <nlohmann/json.hpp>

#include "runtime/descriptor.h"
#include "runtime/host_name.h"
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

}  // namespace

fs::path jobs_folder(const fs::path& out) { return out / "jobs"; }
fs::path shared_report(const fs::path& out) { return jobs_folder(out) / "shared.json"; }

std::string chunk_name(std::size_t chunk, std::size_t chunks) {
  return fmt::format("chunk-{}-of-{}", chunk, chunks);
}

bool WorkerLog::write(json event) const {
  event["host"] = machine(), event["task"] = task();
  event["time"] = static_cast<std::int64_t>(std::time(nullptr));
  const std::string line = json_text(event) + "\n";
  // Opened for each line: network file systems show a line to others when the file is closed.
  const Descriptor file(::open(file_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  return file.fd >= 0 && ::write(file.fd, line.data(), line.size()) == static_cast<ssize_t>(line.size());
}

LogReader::LogReader(fs::path file, bool skip) : file_(std::move(file)) {
  std::error_code error;
  const auto size = fs::file_size(file_, error);
  if (skip && !error) offset_ = size;
}

std::vector<json> LogReader::news() {
  std::vector<json> out;
  const Descriptor file(::open(file_.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat s;
  if (file.fd < 0 || ::fstat(file.fd, &s) != 0 || static_cast<std::size_t>(s.st_size) <= offset_) return out;
  std::string text(static_cast<std::size_t>(s.st_size) - offset_, '\0');
  const ssize_t got = ::pread(file.fd, text.data(), text.size(), static_cast<off_t>(offset_));
  if (got <= 0) return out;
  text.resize(static_cast<std::size_t>(got));
  std::size_t at = 0;
  for (std::size_t end; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
    json line = json::parse(text.begin() + static_cast<std::ptrdiff_t>(at),
                            text.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
    if (line.is_object() && line.contains("event")) out.push_back(std::move(line));
  }
  offset_ += at;
  return out;
}

}  // namespace terrazzo
