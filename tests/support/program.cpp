#include "tests/support/program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <thread>

#include "runtime/files.h"
#include "tests/support/run_node.h"

namespace terrazzo::test {
namespace fs = std::filesystem;

namespace {
// A sanitizer reports on the child's standard error, which most tests don't look at.
void fail_on_sanitizer_report(const ProgramRun& run) {
  for (const char* report : {"ThreadSanitizer:", "AddressSanitizer:", "LeakSanitizer:", "runtime error:"})
    if (run.err.find(report) != std::string::npos) {
      ADD_FAILURE() << "a sanitizer reports (exit code " << run.exit_code << "):\n" << run.err;
      return;
    }
}
}  // namespace

ProgramRun run_command(const std::vector<std::string>& command, const ProgramOptions& options) {
  const fs::path base = temporary_folder();
  const fs::path out = base / "stdout", err = base / "stderr";
  const pid_t child = ::fork();
  if (child == 0) {
    if (!options.folder.empty() && ::chdir(options.folder.c_str()) != 0) ::_exit(99);
    const int o = ::open(out.c_str(), O_WRONLY | O_CREAT, 0600),
              e = ::open(err.c_str(), O_WRONLY | O_CREAT, 0600);
    ::dup2(o, 1);
    ::dup2(e, 2);
    if (options.largest_file >= 0) {
      const struct rlimit limit = {static_cast<rlim_t>(options.largest_file),
                                   static_cast<rlim_t>(options.largest_file)};
      ::setrlimit(RLIMIT_FSIZE, &limit);
      std::signal(SIGXFSZ, SIG_IGN);  // write() then fails with EFBIG, like ENOSPC on a full disk
    }
    if (options.address_space >= 0) {
      const struct rlimit limit = {static_cast<rlim_t>(options.address_space),
                                   static_cast<rlim_t>(options.address_space)};
      ::setrlimit(RLIMIT_AS, &limit);
    }
    if (!options.environment.empty()) ::putenv(const_cast<char*>(options.environment.c_str()));
    std::vector<char*> argv;
    for (const auto& a : command) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    ::execvp(argv[0], argv.data());
    ::_exit(98);
  }
  if (const double after = std::max(options.interrupt_after, options.kill_after); after >= 0) {
    std::this_thread::sleep_for(std::chrono::duration<double>(after));
    ::kill(child, options.kill_after >= 0 ? SIGKILL : SIGINT);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ProgramRun run;
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  run.out = read_file(out).value_or("");
  run.err = read_file(err).value_or("");
  fail_on_sanitizer_report(run);
  return run;
}

ProgramRun run_program(const std::vector<std::string>& arguments, const ProgramOptions& options) {
  std::vector<std::string> command{TERRAZZO_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return run_command(command, options);
}

bool has_pid_namespaces() {
  return run_command({"unshare", "--pid", "--fork", "sh", "-c", "test $$ -lt 10"}).exit_code == 0;
}

std::array<ProgramRun, 2> run_twice_with_one_process_id(const std::vector<std::string>& arguments) {
  std::vector<std::string> command = {"unshare", "--pid", "--fork", TERRAZZO_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::array<ProgramRun, 2> runs;
  std::thread processes[2];
  for (std::size_t i = 0; i < 2; ++i) processes[i] = std::thread([&, i] { runs[i] = run_command(command); });
  for (auto& p : processes) p.join();
  return runs;
}

fs::path source_folder() { return TERRAZZO_SOURCE; }
fs::path build_folder() { return fs::path(TERRAZZO_PROGRAM).parent_path(); }

}  // namespace terrazzo::test
