// Server sockets that slow clients cannot block: deadlines apply to a whole request, not to each read.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <list>
#include <mutex>

#include <httplib.h>  // last: <resolv.h>, which it brings in, redefines a name of Eigen's

namespace terrazzo::studio {

struct ConnectionLimits {
  std::size_t head = 16 << 10, body = 1 << 20;  // maximum bytes of a request
  std::chrono::milliseconds read{3000};         // for the whole request, apart from slow bodies
  std::size_t slowest = 0;                      // bytes of a body per second that extend `read`; 0: none
  std::chrono::milliseconds write{20000};       // for the whole response
  std::size_t threads = 64;                     // maximum number of simultaneous connections
};

// The open sockets. Shutting one down wakes the thread that waits for it.
class Connections {
 public:
  struct Entry {
    int socket;
    bool waiting = true;  // the request is incomplete
  };
  using Handle = std::list<Entry>::iterator;

  Handle add(int socket);
  void set_waiting(Handle, bool);
  void close(Handle);
  // Shuts down the oldest connection whose request is incomplete.
  void drop_oldest_waiting();
  // Shuts down all open connections, and every connection added later.
  void end();

 private:
  std::mutex mutex_;
  std::list<Entry> open_;  // oldest first
  bool ended_ = false;
};

// One connection, for one request and one response.
class ConnectionStream : public httplib::Stream {
 public:
  ConnectionStream(Connections&, Connections::Handle, const ConnectionLimits&);

  // Call for a response that goes on for long: its deadline applies to each write.
  void stream() { streams_ = true; }
  // Call when the request's head was read and `bytes` bytes of body follow.
  void expect_body(std::size_t bytes);
  // Reads and discards what the client still sends, for a short time. Closing a socket with unread bytes
  // would reset the connection before the client has read the response.
  void drain();

  bool is_readable() const override { return true; }
  bool is_writable() const override;  // false once the client of a stream is gone
  ssize_t read(char* to, std::size_t size) override;
  ssize_t write(const char* from, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    ip = "127.0.0.1";
    port = 0;
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    ip = "127.0.0.1";
    port = 0;
  }
  socket_t socket() const override { return handle_->socket; }

 private:
  using Clock = std::chrono::steady_clock;
  bool wait(short events, Clock::time_point until) const;

  Connections& connections_;
  Connections::Handle handle_;
  const ConnectionLimits& limits_;
  std::array<char, 4096> buffer_;
  std::size_t at_ = 0, filled_ = 0;
  std::size_t left_;  // bytes that may still be read
  bool in_body_ = false, streams_ = false;
  Clock::time_point read_until_, write_until_{};
};

}  // namespace terrazzo::studio
