// Runs `terrazzo paint` in a separate process, with raw sockets to it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace terrazzo::test {

class PaintProcess {
 public:
  // `folder`: its working folder.
  PaintProcess(const std::vector<std::string>& arguments, const std::filesystem::path& folder);
  ~PaintProcess();  // kills it if it is still running
  PaintProcess(const PaintProcess&) = delete;

  // Port and token from the printed address.
  int port() const { return port_; }
  const std::string& token() const { return token_; }

  // Opens a socket with a timeout of 20 s.
  int connect() const;
  // The head of a request, with the token, including the empty line.
  std::string head(const std::string& method, const std::string& path, const std::string& more = "") const;
  // Sends the request and returns the response, read until the connection closes.
  std::string ask(const std::string& request) const;
  std::string post(const std::string& path, const std::string& json) const;

  long peak_memory() const;  // kB
  // Sends the signal. Returns the exit code, or −1 if it is still running ten seconds later.
  int end(int signal);

 private:
  pid_t process_ = -1;
  int port_ = 0;
  std::string token_;
};

// Sends all of the text, unless the other side closes the connection.
void send_all(int socket, const std::string&);
// Receives until the other side closes the connection or 20 s pass without a byte.
std::string receive_all(int socket);

}  // namespace terrazzo::test
