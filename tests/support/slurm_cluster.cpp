#include "tests/support/slurm_cluster.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include "runtime/files.h"

namespace terrazzo::test {
namespace fs = std::filesystem;
namespace {

constexpr const char* node_names[] = {"n1", "n2", "n3"};

// Ports that nobody uses now.
std::vector<int> free_ports(std::size_t count) {
  std::vector<int> sockets, ports;
  for (std::size_t i = 0; i < count; ++i) {
    sockets.push_back(::socket(AF_INET, SOCK_STREAM, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ::bind(sockets.back(), reinterpret_cast<sockaddr*>(&address), size);
    ::getsockname(sockets.back(), reinterpret_cast<sockaddr*>(&address), &size);
    ports.push_back(ntohs(address.sin_port));
  }
  for (const int s : sockets) ::close(s);
  return ports;
}

bool installed(const char* program) {
  return run_command({"sh", "-c", std::string("command -v ") + program}).exit_code == 0;
}

std::string host_name() {
  char text[256] = {};
  ::gethostname(text, sizeof text - 1);
  return std::string(text).substr(0, std::string(text).find('.'));
}

pid_t parent_of(pid_t process) {
  const auto text = [&] {
    std::ifstream in(fmt::format("/proc/{}/stat", process));
    return std::string(std::istreambuf_iterator<char>(in), {});
  }();
  const auto end = text.rfind(')');
  if (end == std::string::npos) return 0;
  std::istringstream rest(text.substr(end + 1));
  std::string state;
  pid_t parent = 0;
  rest >> state >> parent;
  return parent;
}

}  // namespace

bool wait_until(double seconds, const std::function<bool()>& happened) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (happened()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return happened();
}

SlurmCluster::SlurmCluster(const fs::path& folder) : folder_(folder) {
  if (::geteuid() != 0) {
    trouble_ = "Slurm's daemons need root here";
    return;
  }
  for (const char* program : {"munged", "slurmctld", "slurmd", "sbatch"})
    if (!installed(program)) {
      trouble_ = fmt::format("{} is not installed (Debian packages slurm-wlm and munge)", program);
      return;
    }
  fs::create_directories(folder_ / "state");
  fs::permissions(folder_, fs::perms(0755));
  const auto ports = free_ports(4);
  const std::string at = folder_.string(), host = host_name();
  std::string config = fmt::format(
      "ClusterName=test\nSlurmctldHost={0}(127.0.0.1)\nSlurmUser=root\nSlurmdUser=root\nAuthInfo=socket={1}/"
      "munge\n"
      "SlurmctldPort={2}\nSlurmctldPidFile={1}/slurmctld.pid\nSlurmctldLogFile={1}/slurmctld.log\n"
      "StateSaveLocation={1}/state\nSlurmdSpoolDir={1}/spool-%n\nSlurmdPidFile={1}/%n.pid\nSlurmdLogFile={1}/"
      "%n.log\n"
      "ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n"
      "SelectTypeParameters=CR_CPU\nSlurmdParameters=config_overrides\nReturnToService=2\nSlurmdTimeout=5\n"
      "KillWait=2\nMpiDefault=none\nAccountingStorageType=accounting_storage/none\n"
      "JobAcctGatherType=jobacct_gather/none\n"
      "SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0\n",
      host, at, ports[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    config += fmt::format("NodeName={} NodeHostname={} NodeAddr=127.0.0.1 Port={} CPUs=2 State=UNKNOWN\n",
                          node_names[i], host, ports[i + 1]);
    fs::create_directories(folder_ / fmt::format("spool-{}", node_names[i]));
  }
  config += "PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n";
  std::ofstream(folder_ / "slurm.conf") << config;
  std::ofstream(folder_ / "key") << "a key of 32 bytes or more, which is no secret";
  fs::permissions(folder_ / "key", fs::perms(0600));
  start("munged", {"munged", "-F", "-f", "--key-file=" + at + "/key", "--socket=" + at + "/munge",
                   "--pid-file=" + at + "/munged.pid", "--log-file=" + at + "/munged.log",
                   "--seed-file=" + at + "/seed"});
  wait_until(5, [&] { return fs::exists(folder_ / "munge"); });
  start_controller();
  for (const char* name : node_names) start_node(name);
  const bool up = wait_until(20, [&] {
    const auto idle = command({"sinfo", "-h", "-N", "-o", "%N %T"}).out;
    return idle == "n1 idle\nn2 idle\nn3 idle\n";
  });
  if (!up)
    trouble_ = "Slurm does not start: " + read_file(folder_ / "slurmctld.out").value_or("") +
               read_file(folder_ / "n1.out").value_or("");
}

SlurmCluster::~SlurmCluster() {
  for (const char* name : node_names) kill_node(name);
  for (const char* name : {"slurmctld", "munged"}) kill(name);
}

std::string SlurmCluster::environment() const { return "SLURM_CONF=" + (folder_ / "slurm.conf").string(); }

ProgramRun SlurmCluster::command(const std::vector<std::string>& words) const {
  return run_command(words, {.environment = environment()});
}

std::vector<std::string> SlurmCluster::queue(const std::string& format) const {
  std::istringstream lines(command({"squeue", "-h", "-r", "-o", format}).out);
  std::vector<std::string> out;
  for (std::string line; std::getline(lines, line);) out.push_back(line);
  return out;
}

pid_t SlurmCluster::start(const std::string& name, const std::vector<std::string>& words) {
  const std::string out = (folder_ / (name + ".out")).string(), variable = environment();
  const pid_t child = ::fork();
  if (child == 0) {
    ::setsid();                          // an interrupt at the terminal is not for the daemons
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // but they end with the test
    const int null = ::open("/dev/null", O_RDONLY),
              file = ::open(out.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    ::dup2(null, 0), ::dup2(file, 1), ::dup2(file, 2);
    ::putenv(const_cast<char*>(variable.c_str()));
    std::vector<char*> argv;
    for (const auto& w : words) argv.push_back(const_cast<char*>(w.c_str()));
    argv.push_back(nullptr);
    ::execvp(argv[0], argv.data());
    ::_exit(98);
  }
  return daemons_[name] = child;
}

void SlurmCluster::kill(const std::string& name) {
  const auto it = daemons_.find(name);
  if (it == daemons_.end()) return;
  ::kill(it->second, SIGKILL);
  int status;
  ::waitpid(it->second, &status, 0);
  daemons_.erase(it);
}

void SlurmCluster::start_controller() {
  start("slurmctld", {"slurmctld", "-D", "-f", (folder_ / "slurm.conf").string()});
}

void SlurmCluster::kill_controller() { kill("slurmctld"); }

void SlurmCluster::start_node(const std::string& name) {
  start(name, {"slurmd", "-D", "-N", name, "-f", (folder_ / "slurm.conf").string()});
}

void SlurmCluster::start_again() const {
  for (const auto& line : queue("%i %r"))
    if (line.find("BeginTime") != std::string::npos)
      command({"scontrol", "update", "jobid=" + line.substr(0, line.find(' ')), "StartTime=now"});
}

std::vector<pid_t> SlurmCluster::tasks(const std::string& node) const {
  std::vector<pid_t> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/proc", error)) {
    const pid_t process = std::atoi(entry.path().filename().c_str());
    if (process <= 0) continue;
    std::ifstream in(entry.path() / "environ");
    const std::string all = '\0' + std::string(std::istreambuf_iterator<char>(in), {}) + '\0';
    const auto has = [&](const std::string& v) { return all.find('\0' + v + '\0') != std::string::npos; };
    if (!has(environment()) || all.find(std::string("\0SLURM_JOB_ID=", 14)) == std::string::npos) continue;
    if (node.empty() || has("SLURMD_NODENAME=" + node)) out.push_back(process);
  }
  return out;
}

void SlurmCluster::kill_node(const std::string& name) {
  kill(name);
  for (const pid_t task : tasks(name)) {
    const pid_t step = parent_of(task);
    if (step > 1 &&
        run_command({"grep", "-q", "slurmstepd", fmt::format("/proc/{}/cmdline", step)}).exit_code == 0)
      ::kill(step, SIGKILL);
    ::kill(task, SIGKILL);
  }
}

}  // namespace terrazzo::test
