#include "runtime/clients/studio/server/event_log.h"

#include <utility>

namespace terrazzo::studio {
namespace {
constexpr std::size_t kMostEvents = 4000, kMostBytes = 32 << 20;
}

void EventLog::add(std::string type, std::string data) {
  const std::lock_guard lock(mutex_);
  bytes_ += data.size();
  events_.push_back({++last_, std::move(type), std::move(data)});
  while (events_.size() > 1 && (events_.size() > kMostEvents || bytes_ > kMostBytes)) {
    bytes_ -= events_.front().data.size();
    events_.pop_front();
  }
  changed_.notify_all();
}

std::uint64_t EventLog::last() const {
  const std::lock_guard lock(mutex_);
  return last_;
}

std::optional<std::vector<Event>> EventLog::after(std::uint64_t number,
                                                  std::chrono::milliseconds wait) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, wait, [&] { return ended_ || last_ != number; });
  if (number > last_ || number + events_.size() < last_) return {};
  return std::vector<Event>(events_.end() - (last_ - number), events_.end());
}

void EventLog::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

}  // namespace terrazzo::studio
