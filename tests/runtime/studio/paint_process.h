// `terrazzo paint` as a process of its own, and raw sockets to it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace terrazzo::test {

class PaintProcess {
 public:
  // `folder`: where it runs.
  PaintProcess(const std::vector<std::string>& arguments, const std::filesystem::path& folder);
  ~PaintProcess();  // kill -9, where it still runs
  PaintProcess(const PaintProcess&) = delete;

  // From the address that it printed.
  int port() const { return port_; }
  const std::string& token() const { return token_; }

  // A socket to it that waits at most 20 s for an answer.
  int connect() const;
  // A request's head, with the token, up to the empty line.
  std::string head(const std::string& method, const std::string& path, const std::string& more = "") const;
  // What it answers to this: everything until it closes the connection.
  std::string ask(const std::string& request) const;
  std::string post(const std::string& path, const std::string& json) const;

  long peak_memory() const;  // kB
  // Sends the signal. The exit code, or −1 where it still runs ten seconds later.
  int end(int signal);

 private:
  pid_t process_ = -1;
  int port_ = 0;
  std::string token_;
};

// All of it, unless the other side closes the connection.
void send_all(int socket, const std::string&);
// Until the other side closes the connection or 20 s pass without a byte.
std::string receive_all(int socket);

}  // namespace terrazzo::test
