// Numbered events that clients follow. A client that was away resumes at the number it saw last.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace terrazzo::studio {

struct Event {
  std::uint64_t number;
  std::string type, data;  // data: JSON on one line
};

class EventLog {
 public:
  void add(std::string type, std::string data);
  std::uint64_t last() const;
  // The events after a number, or nothing if they are no longer kept or the number is from another session.
  // Waits for one at most this long; the list is empty if there was none.
  std::optional<std::vector<Event>> after(std::uint64_t number, std::chrono::milliseconds wait) const;
  // Ends all waits, now and later.
  void end();

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::deque<Event> events_;  // the most recent ones
  std::uint64_t last_ = 0;
  std::size_t bytes_ = 0;
  bool ended_ = false;
};

}  // namespace terrazzo::studio
