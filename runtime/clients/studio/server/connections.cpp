#include "runtime/clients/studio/server/connections.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace terrazzo::studio {

Connections::Handle Connections::add(int socket) {
  const std::lock_guard lock(mutex_);
  if (ended_) ::shutdown(socket, SHUT_RDWR);
  return open_.insert(open_.end(), {socket});
}

void Connections::set_waiting(Handle h, bool waiting) {
  const std::lock_guard lock(mutex_);
  h->waiting = waiting;
}

void Connections::close(Handle h) {
  const std::lock_guard lock(mutex_);
  ::close(h->socket);
  open_.erase(h);
}

void Connections::drop_oldest_waiting() {
  const std::lock_guard lock(mutex_);
  const auto oldest = std::find_if(open_.begin(), open_.end(), [](const Entry& e) { return e.waiting; });
  if (oldest == open_.end()) return;
  ::shutdown(oldest->socket, SHUT_RDWR);
  oldest->waiting = false;
}

void Connections::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  for (const Entry& e : open_) ::shutdown(e.socket, SHUT_RDWR);
}

ConnectionStream::ConnectionStream(Connections& connections, Connections::Handle handle,
                                   const ConnectionLimits& limits)
    : connections_(connections),
      handle_(handle),
      limits_(limits),
      left_(limits.head),
      read_until_(Clock::now() + limits.read) {}

void ConnectionStream::expect_body(std::size_t bytes) {
  in_body_ = true;
  left_ = std::min(bytes, limits_.body);
  if (limits_.slowest > 0) read_until_ += std::chrono::milliseconds(1000 * left_ / limits_.slowest);
  if (left_ == 0) connections_.set_waiting(handle_, false);
}

bool ConnectionStream::wait(short events, Clock::time_point until) const {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    if (left <= 0) return false;
    struct pollfd p = {handle_->socket, events, 0};
    const int n = ::poll(&p, 1, static_cast<int>(left));
    if (n > 0) return true;
    if (n == 0 || errno != EINTR) return false;
  }
}

ssize_t ConnectionStream::read(char* to, std::size_t size) {
  if (left_ == 0) return -1;
  if (at_ == filled_) {
    if (!wait(POLLIN, read_until_)) return -1;
    const ssize_t n = ::recv(handle_->socket, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return read(to, size);
    if (n <= 0) return n;
    at_ = 0;
    filled_ = n;
  }
  const std::size_t n = std::min({size, filled_ - at_, left_});
  std::memcpy(to, buffer_.data() + at_, n);
  at_ += n;
  left_ -= n;
  if (in_body_ && left_ == 0) connections_.set_waiting(handle_, false);
  return n;
}

bool ConnectionStream::is_writable() const {
  if (!streams_) return true;
  struct pollfd p = {handle_->socket, POLLRDHUP, 0};
  return ::poll(&p, 1, 0) == 0 || !(p.revents & (POLLRDHUP | POLLHUP | POLLERR));
}

ssize_t ConnectionStream::write(const char* from, std::size_t size) {
  if (streams_ || write_until_ == Clock::time_point{}) write_until_ = Clock::now() + limits_.write;
  while (true) {
    if (!wait(POLLOUT, write_until_)) return -1;
    const ssize_t n = ::send(handle_->socket, from, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n >= 0 || (errno != EAGAIN && errno != EINTR)) return n;
  }
}

void ConnectionStream::drain() {
  ::shutdown(handle_->socket, SHUT_WR);
  connections_.set_waiting(handle_, true);
  const auto until = Clock::now() + std::chrono::milliseconds(500);
  for (std::size_t left = 8 << 20; left > 0;) {
    if (!wait(POLLIN, until)) return;
    const ssize_t n = ::recv(handle_->socket, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) return;
    left -= std::min<std::size_t>(left, std::max<ssize_t>(n, 0));
  }
}

}  // namespace terrazzo::studio
