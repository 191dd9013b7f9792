// Standard output and standard error of a command.
#pragma once

#include <memory>
#include <ostream>
#include <string_view>

namespace terrazzo::cli {

class EscapingBuffer;

// While it exists, std::cout and std::cerr escape the characters that steer a terminal (escape_controls),
// since what a command prints may come from a stranger's graph or file.
class Output {
 public:
  Output();
  ~Output();
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  // Flushes both. Returns `exit_code`, or `kNodeFailed` instead of success if something printed was lost.
  // Says so, unless the reader of a pipe has gone.
  int finish(int exit_code);

 private:
  std::unique_ptr<EscapingBuffer> out_, err_;
};

// Writes codes that steer the terminal, such as "\r\x1b[K", and flushes.
void write_codes(std::ostream&, std::string_view codes);

// Throws Error "write-failed" if standard output cannot be written.
void require_output();

}  // namespace terrazzo::cli
