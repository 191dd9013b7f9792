#include "runtime/evaluate.h"

#include "runtime/run.h"

namespace terrazzo {

bool Evaluator::begin(const Hash& key, const std::function<std::function<void()>()>& later) {
  const std::lock_guard lock(mutex_);
  const auto [it, mine] = busy_.try_emplace(key);
  if (!mine) it->second.push_back(later());
  return mine;
}

void Evaluator::end(const Hash& key) {
  std::vector<std::function<void()>> waiting;
  {
    const std::lock_guard lock(mutex_);
    const auto it = busy_.find(key);
    waiting = std::move(it->second);
    busy_.erase(it);
  }
  for (const auto& resume : waiting) resume();
}

RunResult Evaluator::run(const Graph& graph, const RunOptions& options) {
  return Run(*this, graph, options).run();
}

Value Evaluator::value(const Graph& graph, const RunResult& result, const Wire& wire,
                       const RunOptions& options) {
  return Run::fetch(*this, graph, result, wire, options);
}

}  // namespace terrazzo
