#include "runtime/clients/cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "runtime/clients/cli/output.h"

namespace terrazzo::cli {
namespace {

constexpr const char* kClearLine = "\r\x1b[K";

}  // namespace

ProgressLine::ProgressLine(Session& session, const std::vector<int>& targets, bool quiet, const Graph* graph)
    : kept_(session.graph()),
      graph_(graph ? graph : kept_.get()),
      line_(!quiet && ::isatty(STDERR_FILENO)),
      quiet_(quiet) {
  waiting_ = needed_nodes(*graph_, targets.empty() ? graph_->sinks() : targets);
  needed_ = std::count(waiting_.begin(), waiting_.end(), true);
  expected_.resize(graph_->nodes.size(), 0);
  for (std::size_t i = 0; i < expected_.size(); ++i)
    if (waiting_[i] && line_) expected_[i] = session.known_seconds(graph_->nodes[i]);
}

ProgressLine::~ProgressLine() { close(); }

void ProgressLine::close() { clear(); }

void ProgressLine::started(int node) {
  running_[node] = {};
  draw(true);
}

void ProgressLine::progress(int node, double fraction, const std::string& note) {
  At& at = running_[node];
  at.fraction = fraction;
  if (!note.empty()) at.note = note;
  if (!line_ && !quiet_ && Clock::now() - at.told > std::chrono::seconds(10)) {
    at.told = Clock::now();
    std::cerr << fmt::format("{}: {:.0f} %{}{}\n", path(node), 100 * fraction, at.note.empty() ? "" : ", ",
                             at.note);
  }
  draw(false);
}

void ProgressLine::finished(int node, const NodeResult& r) {
  running_.erase(node);
  waiting_[node] = false;
  ++done_;
  if (r.error || r.saved || (!quiet_ && !r.warnings.empty())) clear();
  if (r.error) std::cerr << r.error->text() << '\n';
  if (r.saved) std::cerr << r.saved->message.text() << '\n';
  if (!line_ && !quiet_ && r.status == Status::Computed && r.seconds >= 1)
    std::cerr << fmt::format("[{}/{}] {}: {:.1f} s\n", done_, needed_, path(node), r.seconds);
  if (!quiet_)
    for (const auto& w : r.warnings)
      std::cerr
          << Diagnostic{Severity::Warning, "note", w, {}, graph_->nodes[node].place, path(node), {}}.text()
          << '\n';
  draw(true);
}

// Most nodes use all threads and rarely run in parallel, so their times are added.
std::string ProgressLine::time_left() const {
  double seconds = 0;
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (!waiting_[i]) continue;
    const auto it = running_.find(static_cast<int>(i));
    if (it == running_.end()) {
      if (expected_[i] == 0) return "";  // no earlier run: the total is unknown
      seconds += expected_[i];
      continue;
    }
    const double gone = std::chrono::duration<double>(Clock::now() - it->second.start).count();
    const double fraction = it->second.fraction;
    if (expected_[i] > 0)
      seconds += std::max(expected_[i] - gone, 0.0);
    else if (fraction > 0.05)
      seconds += gone * (1 - fraction) / fraction;
    else
      return "";
  }
  return fmt::format(" about {:.0f} s left", std::ceil(seconds));
}

void ProgressLine::draw(bool now) {
  if (!line_) return;
  const auto time = Clock::now();
  if (!now && time - last_ < std::chrono::milliseconds(100)) return;
  last_ = time;
  std::string text = fmt::format("[{}/{}]{}", done_, needed_, time_left());
  for (const auto& [node, at] : running_) {
    text += fmt::format("  {} {:.0f}%", path(node), 100 * at.fraction);
    if (!at.note.empty()) text += " " + at.note;
  }
  if (text.size() > 110) text.resize(110);
  write_codes(std::cerr, kClearLine);
  std::cerr << text << std::flush;
  drawn_ = true;
}

void ProgressLine::clear() {
  if (drawn_) write_codes(std::cerr, kClearLine);
  drawn_ = false;
}

}  // namespace terrazzo::cli
