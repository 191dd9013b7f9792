#include "runtime/clients/cli/output.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <mutex>
#include <string>

#include "graph/diagnostic.h"
#include "graph/text/utf8.h"
#include "runtime/clients/cli/options.h"

namespace terrazzo::cli {

// Passes text on with escapes. Keeps a character whose end is missing, and a carriage return, until more
// arrives. Threads may share it.
class EscapingBuffer : public std::streambuf {
 public:
  explicit EscapingBuffer(std::ostream& stream) : stream_(stream), target_(stream.rdbuf(this)) {}
  ~EscapingBuffer() override {
    release(true);
    stream_.rdbuf(target_);
  }
  EscapingBuffer(const EscapingBuffer&) = delete;
  EscapingBuffer& operator=(const EscapingBuffer&) = delete;

  // Writes without escapes.
  void write_raw(std::string_view text) {
    const std::lock_guard lock(mutex_);
    release(true);
    put(text);
    flush();
  }

  // Writes everything. Returns 0, or why something was lost.
  int finish() {
    const std::lock_guard lock(mutex_);
    release(true);
    flush();
    return failed_ ? reason_ : 0;
  }

 protected:
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    const std::lock_guard lock(mutex_);
    pending_.append(text, static_cast<std::size_t>(size));
    release(false);
    return failed_ ? 0 : size;
  }
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char one = traits_type::to_char_type(c);
    return xsputn(&one, 1) == 1 ? c : traits_type::eof();
  }
  int sync() override {
    const std::lock_guard lock(mutex_);
    flush();
    return failed_ ? -1 : 0;
  }

 private:
  // Bytes at the end of pending_ that may belong to what follows.
  std::size_t unfinished() const {
    if (pending_.ends_with('\r')) return 1;
    for (std::size_t n = 1; n <= std::min<std::size_t>(3, pending_.size()); ++n) {
      const unsigned char byte = pending_[pending_.size() - n];
      if (byte < 0x80) return 0;
      if (byte < 0xc0) continue;
      const std::size_t length = byte >= 0xf0 ? 4 : byte >= 0xe0 ? 3 : 2;
      return n < length ? n : 0;
    }
    return 0;
  }
  void release(bool all) {
    const std::size_t size = pending_.size() - (all ? 0 : unfinished());
    put(escape_controls(std::string_view(pending_).substr(0, size)));
    pending_.erase(0, size);
  }
  void put(std::string_view text) {
    errno = 0;
    const std::streamsize size = text.size();
    if (target_->sputn(text.data(), size) != size) fail();
  }
  void flush() {
    errno = 0;
    if (target_->pubsync() != 0) fail();
  }
  void fail() {
    if (!failed_) reason_ = errno ? errno : EIO;
    failed_ = true;
  }

  std::ostream& stream_;
  std::streambuf* target_;
  std::string pending_;
  std::mutex mutex_;
  bool failed_ = false;
  int reason_ = 0;
};

namespace {

// A file that is opened must not become standard output because that is closed. Reading from the first of
// these files and writing to the others fails, as it would if they were closed.
void occupy_standard_files() {
  for (int file = 0; file < 3; ++file)
    if (::fcntl(file, F_GETFD) == -1 && ::open("/dev/null", file == 0 ? O_WRONLY : O_RDONLY) == -1) return;
}

}  // namespace

Output::Output() {
  occupy_standard_files();
  out_ = std::make_unique<EscapingBuffer>(std::cout);
  err_ = std::make_unique<EscapingBuffer>(std::cerr);
}

Output::~Output() = default;

int Output::finish(int exit_code) {
  const int out = out_->finish();
  if (out != 0 && out != EPIPE)
    std::cerr << "error: cannot write to standard output: " << std::strerror(out) << '\n';
  const bool lost = out != 0 || err_->finish() != 0;
  return lost && exit_code == kDone ? kNodeFailed : exit_code;
}

void write_codes(std::ostream& stream, std::string_view codes) {
  if (auto* buffer = dynamic_cast<EscapingBuffer*>(stream.rdbuf()))
    buffer->write_raw(codes);
  else
    stream << codes << std::flush;
}

void require_output() {
  if (!std::cout) throw Error("write-failed", "cannot write to standard output", "redirect it to a file");
}

}  // namespace terrazzo::cli
