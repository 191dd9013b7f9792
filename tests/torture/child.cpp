#include "tests/torture/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <new>
#include <stdexcept>

#include "nodes/common/io/provenance.h"
#include "nodes/register_nodes.h"
#include "runtime/files.h"

namespace terrazzo::torture {
namespace fs = std::filesystem;
namespace {

int command_line(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {"terrazzo"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (auto& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  return run_command_line(static_cast<int>(words.size()), argv.data(), {node_set, nullptr});
}

void become(const std::vector<std::string>& arguments, const ChildOptions& o) {
  if (o.faults) {
    const FaultPlan& p = *o.faults;
    ::setenv("LD_PRELOAD", TERRAZZO_FAULT_LIBRARY, 1);
    ::setenv(
        "TERRAZZO_FAULTS",
        fmt::format("{} {} {} {} {:d} {}", p.seed, p.rate, p.operations, p.full_after, p.passing, p.folder)
            .c_str(),
        1);
  }
  std::vector<std::string> words = {o.program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (auto& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  ::execv(argv[0], argv.data());
  ::_exit(98);
}

void redirect(const fs::path& file, int to) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0 || ::dup2(fd, to) < 0) ::_exit(97);
}

}  // namespace

const NodeSet& node_set() {
  static const NodeSet all = [] {
    NodeSet set;
    register_nodes(set.registry);
    register_value_types(set.types);
    set.read_provenance = read_provenance;
    return set;
  }();
  return all;
}

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

FaultCounts& fault_counts() {
  static FaultCounts* counts = [] {
    void* at =
        ::mmap(nullptr, sizeof(FaultCounts), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED) throw std::runtime_error("no shared memory for counts");
    return new (at) FaultCounts;
  }();
  return *counts;
}

Child::Child(const std::vector<std::string>& arguments, const fs::path& folder, const ChildOptions& o)
    : Child(
          [&]() -> int {
            if (o.program.empty()) return command_line(arguments);
            become(arguments, o);
            return 98;
          },
          folder, o) {}

Child::Child(const std::function<int()>& work, const fs::path& folder, const ChildOptions& o) {
  static int serial = 0;
  out_ = folder / fmt::format("stdout{}", ++serial % 16);
  err_ = folder / fmt::format("stderr{}", serial % 16);
  node_set();
  fault_counts();
  std::fflush(nullptr);
  start_ = now();
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("cannot fork");
  if (pid_ > 0) return;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  redirect(out_, 1);
  redirect(err_, 2);
  if (o.largest_file >= 0) {
    const struct rlimit limit = {static_cast<rlim_t>(o.largest_file), static_cast<rlim_t>(o.largest_file)};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::signal(SIGXFSZ, SIG_IGN);  // write() then fails with EFBIG
  }
  int code = 96;
  try {
    if (o.faults && o.program.empty()) terrazzo_begin_faults(&*o.faults, &fault_counts());
    code = work();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "uncaught: %s\n", e.what());
  }
  std::fflush(nullptr);
  ::_exit(code);
}

Child::Child(Child&& other) noexcept
    : pid_(other.pid_), start_(other.start_), out_(std::move(other.out_)), err_(std::move(other.err_)) {
  other.pid_ = -1;
}

Child::~Child() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

Ended Child::wait(double kill_after) {
  Ended e;
  bool killed = false;
  int status = 0;
  while (true) {
    if (!killed && kill_after >= 0 && now() - start_ >= kill_after) killed = true, ::kill(pid_, SIGKILL);
    if (now() - start_ > 60) e.hung = true, ::kill(pid_, SIGKILL);
    const pid_t got = ::waitpid(pid_, &status, WNOHANG);
    if (got == pid_) break;
    if (got < 0 && errno != EINTR) throw std::runtime_error("waitpid failed");
    ::usleep(100);
  }
  pid_ = -1;
  e.seconds = now() - start_;
  if (WIFEXITED(status)) e.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) e.signal = WTERMSIG(status);
  e.out = read_file(out_).value_or("");
  e.err = read_file(err_).value_or("");
  return e;
}

Ended run(const std::vector<std::string>& arguments, const fs::path& folder, const ChildOptions& o,
          double kill_after) {
  return Child(arguments, folder, o).wait(kill_after);
}

std::string Ended::text() const {
  return fmt::format("{}, printed: {}{}",
                     hung     ? "it hung"
                     : signal ? fmt::format("signal {}", signal)
                              : fmt::format("exit code {}", exit_code),
                     out.substr(0, 2000), err.substr(0, 4000));
}

}  // namespace terrazzo::torture
