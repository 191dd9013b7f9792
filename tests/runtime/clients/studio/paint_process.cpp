#include "tests/runtime/clients/studio/paint_process.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "tests/support/program.h"

namespace terrazzo::test {

PaintProcess::PaintProcess(const std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  const std::string program = (build_folder() / "terrazzo").string();
  int out[2];
  if (::pipe2(out, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  process_ = ::fork();
  if (process_ == 0) {
    ::dup2(out[1], 1);
    std::vector<char*> argv{const_cast<char*>(program.c_str()), const_cast<char*>("paint")};
    for (const auto& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    if (::chdir(folder.c_str()) == 0) ::execv(argv[0], argv.data());
    ::_exit(98);
  }
  ::close(out[1]);
  std::string line;
  for (char c; ::read(out[0], &c, 1) == 1 && c != '\n';) line += c;
  ::close(out[0]);
  const auto equals = line.find("/?token=");
  if (equals == std::string::npos) return;
  port_ = std::stoi(line.substr(std::string("http://127.0.0.1:").size()));
  token_ = line.substr(equals + 8);
}

PaintProcess::~PaintProcess() {
  if (process_ < 0) return;
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

int PaintProcess::connect() const {
  const int s = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const struct timeval wait = {20, 0};
  ::setsockopt(s, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
  ::setsockopt(s, SOL_SOCKET, SO_SNDTIMEO, &wait, sizeof wait);
  struct sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port_));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(s, reinterpret_cast<sockaddr*>(&to), sizeof to) != 0)
    throw std::runtime_error("no connection");
  return s;
}

std::string PaintProcess::head(const std::string& method, const std::string& path,
                               const std::string& more) const {
  return method + " " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) +
         "\r\nCookie: terrazzo_paint_" + std::to_string(port_) + "=" + token_ + "\r\n" + more + "\r\n";
}

std::string PaintProcess::ask(const std::string& request) const {
  const int s = connect();
  send_all(s, request);
  const std::string answer = receive_all(s);
  ::close(s);
  return answer;
}

std::string PaintProcess::post(const std::string& path, const std::string& json) const {
  return ask(
      head("POST", path,
           "Content-Type: application/json\r\nContent-Length: " + std::to_string(json.size()) + "\r\n") +
      json);
}

long PaintProcess::peak_memory() const {
  std::ifstream status("/proc/" + std::to_string(process_) + "/status");
  for (std::string name; status >> name;)
    if (long kilobytes = 0; name == "VmHWM:" && status >> kilobytes) return kilobytes;
  return 0;
}

int PaintProcess::end(int signal) {
  ::kill(process_, signal);
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  for (int status; std::chrono::steady_clock::now() < until;) {
    if (::waitpid(process_, &status, WNOHANG) == process_) {
      process_ = -1;
      return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return -1;
}

void send_all(int socket, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::send(socket, text.data() + done, text.size() - done, MSG_NOSIGNAL);
    if (n <= 0) return;
    done += static_cast<std::size_t>(n);
  }
}

std::string receive_all(int socket) {
  std::string out;
  char buffer[4096];
  for (ssize_t n; (n = ::recv(socket, buffer, sizeof buffer, 0)) > 0;)
    out.append(buffer, static_cast<std::size_t>(n));
  return out;
}

}  // namespace terrazzo::test
