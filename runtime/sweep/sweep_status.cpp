#include "runtime/sweep/sweep_status.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "runtime/files.h"
#include "runtime/report/report_format.h"
#include "runtime/sweep/sweep_log.h"

namespace terrazzo {
namespace fs = std::filesystem;
using nlohmann::json;
using State = PointStatus::State;
namespace {

void take_event(SweepStatus& status, const json& event, int log, std::vector<std::string>& errors) {
  LogStatus& l = status.logs[log];
  const std::string what = event.at("event");
  l.host = event.value("host", "");
  l.task = event.value("task", "");
  const auto index = event.value("point", std::size_t{0});
  const bool known = index >= 1 && index <= status.points.size();
  if (what == "stopped" || what == "refused" || what == "interrupted") {
    l.trouble = what == "interrupted" ? "interrupted" : event.value("message", "");
    if (l.point > 0) {
      auto& point = status.points[l.point - 1];
      if (point.state == State::Running) point.state = State::Waiting;
    }
    l.point = 0;
  } else if (what == "started") {
    l.trouble.clear();
    l.finished = false;
    if (!known) return;
    l.point = index;
    l.since = event.value("time", std::int64_t{0});
    status.points[index - 1] = {State::Running, log};
  } else if (what == "finished") {
    l.trouble.clear();
    status.computed += event.value("computed", std::size_t{0});
    status.cached += event.value("cached", std::size_t{0});
    status.twice += event.value("twice", std::size_t{0});
    const bool failed = event.value("status", "") != "done";
    std::string message;
    if (failed)
      for (const auto& e : event.value("errors", std::vector<std::string>()))
        message += (message.empty() ? "" : "; ") + e;
    if (!known) {
      l.trouble = message;
      l.finished = !failed;
      return;
    }
    l.point = 0;
    status.seconds += event.value("seconds", 0.0);
    ++status.timed;
    status.points[index - 1] = {failed ? State::Failed : State::Done, log};
    errors[index - 1] = message;
  }
}

}  // namespace

std::size_t SweepStatus::count(State state) const {
  return std::count_if(points.begin(), points.end(), [&](const PointStatus& p) { return p.state == state; });
}

SweepStatus sweep_status(const fs::path& folder, const fs::path& out) {
  SweepStatus status;
  status.sweep = read_sweep_file(folder / "sweep.json");
  const Hash hash = status.sweep.hash();
  status.points.resize(status.sweep.points.size());
  std::vector<std::string> errors(status.points.size());
  struct Event {
    std::int64_t time;
    int log;
    json event;
  };
  std::vector<Event> events;
  std::error_code error;
  std::vector<fs::path> files;
  for (const auto& place : std::set{jobs_folder(folder), jobs_folder(out)})
    for (const auto& entry : fs::directory_iterator(place, error))
      if (entry.path().extension() == ".jsonl") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    const int log = status.logs.size();
    status.logs.push_back(
        {fs::path(file).replace_extension(".txt"), file.stem().string(), "", "", 0, 0, "", false});
    LogReader reader(file, false);
    for (auto& event : reader.news())
      if (event.value("sweep", hash.text()) == hash.text())
        events.push_back({event.value("time", std::int64_t{0}), log, std::move(event)});
    if (reader.damaged() > 0) status.damaged.emplace_back(file, reader.damaged());
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.time < b.time; });
  for (const auto& e : events) take_event(status, e.event, e.log, errors);
  // A local run writes no log, and a line may be lost.
  for (std::size_t i = 0; i < status.points.size(); ++i) {
    if (status.points[i].state == State::Done || status.points[i].state == State::Failed) continue;
    const fs::path place = folder / status.sweep.points[i].folder;
    const json report = read_report(place / "report.json");
    if (!report.is_object() || report.value("sweep", "") != hash.text()) continue;
    const PointSummary summary = summary_of(report);
    if (summary.status == "done" && !is_finished_point(report, hash, place)) continue;
    status.points[i].state = summary.status == "done" ? State::Done : State::Failed;
    status.seconds += summary.seconds;
    ++status.timed;
    status.computed += summary.computed;
    status.cached += summary.cached;
    for (const auto& e : summary.errors) errors[i] += (errors[i].empty() ? "" : "; ") + e;
  }
  for (std::size_t i = 0; i < status.points.size(); ++i)
    if (status.points[i].state == State::Failed)
      status.failures.push_back({i + 1, status.points[i].log, errors[i]});
  for (std::size_t k = 0; k < status.logs.size(); ++k)
    if (const LogStatus& log = status.logs[k];
        !log.trouble.empty() && (log.name == job_role::coordinator || log.name == job_role::finisher ||
                                 status.count(State::Done) < status.points.size()))
      status.failures.push_back({0, static_cast<int>(k), log.trouble});
  return status;
}

std::string point_log(const SweepStatus& status, std::size_t point) {
  const int log = status.points.at(point).log;
  const std::string folder = status.sweep.points[point].folder;
  const auto text = log < 0 ? std::nullopt : read_file(status.logs[log].text);
  const std::string start = "=== " + folder + " started\n";
  const auto at = text ? text->rfind(start) : std::string::npos;
  if (at == std::string::npos)
    throw Error("no-log", fmt::format("there is no log of {}", folder),
                "only jobs of Slurm keep what they print; its results are in " + folder + "/report.json");
  const auto next = text->find("\n=== ", at + start.size());
  const auto end = next == std::string::npos ? text->size() : text->find('\n', next + 1);
  return text->substr(at, end == std::string::npos ? end : end + 1 - at);
}

}  // namespace terrazzo
