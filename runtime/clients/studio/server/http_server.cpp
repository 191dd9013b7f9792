#include "runtime/clients/studio/server/http_server.h"

#include <condition_variable>
#include <deque>
#include <functional>
#include <iostream>
#include <system_error>
#include <thread>
#include <vector>

#include "graph/exception_text.h"

namespace terrazzo::studio {
namespace {

// A thread pool that starts threads on demand.
class Workers : public httplib::TaskQueue {
 public:
  Workers(std::size_t most, std::function<void()> all_busy) : most_(most), all_busy_(std::move(all_busy)) {}

  void enqueue(std::function<void()> job) override {
    bool busy = false;
    {
      const std::lock_guard lock(mutex_);
      jobs_.push_back(std::move(job));
      if (jobs_.size() > idle_) busy = !start();
    }
    ready_.notify_one();
    if (busy) all_busy_();
  }

  void shutdown() override {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    ready_.notify_all();
    for (auto& t : threads_) t.join();
  }

 private:
  // Starts a thread. False if no more threads are possible.
  bool start() {
    if (threads_.size() >= most_) return false;
    try {
      threads_.emplace_back([this] { work(); });
      return true;
    } catch (const std::system_error&) {
      if (threads_.empty()) throw;
      return false;  // the system refuses more threads; use those that exist
    }
  }

  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      ++idle_;
      ready_.wait(lock, [this] { return ended_ || !jobs_.empty(); });
      --idle_;
      if (jobs_.empty()) return;
      const auto job = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      job();
      lock.lock();
    }
  }

  std::size_t most_;
  std::function<void()> all_busy_;
  std::mutex mutex_;
  std::condition_variable ready_;
  std::deque<std::function<void()>> jobs_;
  std::vector<std::thread> threads_;
  std::size_t idle_ = 0;
  bool ended_ = false;
};

}  // namespace

HttpServer::HttpServer(std::string stream, ConnectionLimits limits)
    : stream_(std::move(stream)), limits_(limits) {
  set_payload_max_length(limits_.body);
  new_task_queue = [this] {
    // If end() was called before the server listened, it had nothing to close, so stop now.
    if (ended_) httplib::Server::stop();
    // The library listens with a backlog of 5, so a sixth simultaneous connection would wait 1 s for a retry.
    ::listen(svr_sock_, 128);
    return new Workers(limits_.threads, [this] { connections_.drop_oldest_waiting(); });
  };
}

void HttpServer::end() {
  ended_ = true;
  httplib::Server::stop();
  connections_.end();
}

bool HttpServer::process_and_close_socket(socket_t socket) {
  const auto handle = connections_.add(socket);
  {
    ConnectionStream stream(connections_, handle, limits_);
    bool closed = false;
    try {
      process_request(stream, true, closed, [&](httplib::Request& in) {
        if (!stream_.empty() && in.path == stream_) stream.stream();
        stream.expect_body(in.method == "POST" ? in.get_header_value<std::uint64_t>("Content-Length") : 0);
      });
      stream.drain();
    } catch (const std::exception& e) {
      std::cerr << "warning: a request failed: " << exception_text(e) << '\n';  // such as std::bad_alloc
    }
  }
  connections_.close(handle);
  return true;
}

}  // namespace terrazzo::studio
