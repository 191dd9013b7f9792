#include "runtime/cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <iostream>

namespace terrazzo::cli {

ProgressLine::ProgressLine(const Graph& graph, std::size_t needed, bool quiet)
    : graph_(graph), needed_(needed), line_(!quiet && ::isatty(STDERR_FILENO)), quiet_(quiet) {}

ProgressLine::~ProgressLine() { clear(); }

void ProgressLine::started(int node) {
  running_[node] = {};
  draw(true);
}

void ProgressLine::progress(int node, double fraction, const std::string& note) {
  At& at = running_[node];
  at.fraction = fraction;
  if (!note.empty()) at.note = note;
  draw(false);
}

void ProgressLine::finished(int node, const NodeResult& r) {
  running_.erase(node);
  ++done_;
  if (r.error || (!quiet_ && !r.warnings.empty())) clear();
  if (r.error) std::cerr << r.error->text() << '\n';
  if (!quiet_)
    for (const auto& w : r.warnings)
      std::cerr << Diagnostic{Severity::Warning,
                              "note",
                              w,
                              {},
                              graph_.nodes[static_cast<std::size_t>(node)].place,
                              graph_.nodes[static_cast<std::size_t>(node)].path,
                              {}}
                       .text()
                << '\n';
  draw(true);
}

void ProgressLine::draw(bool now) {
  if (!line_) return;
  const auto time = std::chrono::steady_clock::now();
  if (!now && time - last_ < std::chrono::milliseconds(100)) return;
  last_ = time;
  std::string text = fmt::format("[{}/{}]", done_, needed_);
  for (const auto& [node, at] : running_) {
    text += fmt::format("  {} {:.0f}%", graph_.nodes[static_cast<std::size_t>(node)].path, 100 * at.fraction);
    if (!at.note.empty()) text += " " + at.note;
  }
  if (text.size() > 110) text.resize(110);
  std::cerr << "\r\x1b[K" << text << std::flush;
  drawn_ = true;
}

void ProgressLine::clear() {
  if (drawn_) std::cerr << "\r\x1b[K" << std::flush;
  drawn_ = false;
}

}  // namespace terrazzo::cli
