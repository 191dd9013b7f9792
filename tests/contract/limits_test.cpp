// Every number of every node has limits, and at them a node gives a value or an error, or can be canceled.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <limits>
#include <memory>
#include <set>
#include <thread>

#include "runtime/cache/action_key.h"
#include "runtime/compute_node.h"
#include "runtime/evaluate.h"
#include "tests/contract/contents.h"
#include "tests/support/all_nodes.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

bool is_whole(const Parameter& p) { return p.kind == ParameterKind::Int || p.kind == ParameterKind::Ints; }
bool is_list(const Parameter& p) { return p.kind == ParameterKind::Ints || p.kind == ParameterKind::Numbers; }
bool is_number(const Parameter& p) {
  return is_whole(p) || p.kind == ParameterKind::Number || p.kind == ParameterKind::Numbers;
}

WrittenValue written(const Parameter& p, const std::string& text) {
  if (p.kind == ParameterKind::Color) return {true, {text, text, text}, {}};
  if (!is_list(p)) return {false, {text}, {}};
  return {true, std::vector<std::string>(std::max<std::size_t>(p.min_count, 1), text), {}};
}

std::vector<double> numbers_in(const ParameterValue& v) {
  if (const auto* i = std::get_if<std::int64_t>(&v)) return {static_cast<double>(*i)};
  if (const auto* d = std::get_if<double>(&v)) return {*d};
  if (const auto* d = std::get_if<std::vector<double>>(&v)) return *d;
  std::vector<double> out;
  for (const auto i : std::get<std::vector<std::int64_t>>(v)) out.push_back(static_cast<double>(i));
  return out;
}

TEST(Limits, EveryNumberOfEveryNodeHasThem) {
  int numbers = 0;
  for (const NodeType* type : test::all_nodes().all())
    for (const Parameter& p : type->parameters) {
      if (!is_number(p)) continue;
      const std::string name = type->name + "." + p.name;
      EXPECT_TRUE(std::isfinite(p.min) && std::isfinite(p.max)) << name << " has no range";
      EXPECT_LE(std::abs(p.min), 1e30) << name;
      EXPECT_LE(std::abs(p.max), 1e30) << name;
      EXPECT_FALSE(p.min_open && p.min == 0 && !is_whole(p))
          << name << " may be so close to 0 that its reciprocal is infinite; write range(1e-9, …)";
      ++numbers;
    }
  EXPECT_GT(numbers, 200);
}

TEST(Limits, NoNumberIsReadThatArithmeticCannotTake) {
  for (const NodeType* type : test::all_nodes().all())
    for (const Parameter& p : type->parameters) {
      if (!is_number(p) && p.kind != ParameterKind::Color) continue;
      for (const char* text : {"1e300",
                               "-1e300",
                               "1.7976931348623157e308",
                               "-1.7976931348623157e308",
                               "5e-324",
                               "-5e-324",
                               "1e-300",
                               "1e-31",
                               "1e400",
                               "inf",
                               "-inf",
                               "nan",
                               "9223372036854775807",
                               "-9223372036854775808",
                               "9223372036854775808",
                               "9007199254740993",
                               "2147483648",
                               "-2147483649",
                               "4294967296",
                               "-1",
                               "0"}) {
        std::string why;
        const auto value = read_parameter(p, written(p, text), why);
        if (!value) {
          EXPECT_FALSE(why.empty());
          continue;
        }
        for (const double v : numbers_in(*value)) {
          EXPECT_TRUE(v == 0 || (std::abs(v) >= 1e-30 && std::abs(v) <= 1e30))
              << type->name << "." << p.name << " " << v;
          EXPECT_TRUE(v >= p.min && v <= p.max) << type->name << "." << p.name << " " << v;
        }
      }
    }
}

// --- Running nodes at their limits, in a child process that survives nothing

struct Case {
  const GraphNode* node;
  std::string parameter;
  ParameterValue value;
  std::string text;
};

// The limits of each number in the node's example, and the smallest numbers beside 0.
std::vector<Case> cases_of(const Graph& graph, const NodeType& type) {
  std::vector<Case> out;
  std::set<std::string> seen;
  for (const GraphNode& node : graph.nodes)
    for (const Parameter& p : type.parameters) {
      if (node.type != &type || !is_number(p) || !seen.insert(p.name).second) continue;
      for (const double number : {p.min, p.max, 1e-30, -1e-30}) {
        const std::string text =
            is_whole(p) ? fmt::format("{}", static_cast<std::int64_t>(number)) : fmt::format("{}", number);
        std::string why;
        if (auto value = read_parameter(p, written(p, text), why))
          if (std::abs(number) != 1e-30 || !is_whole(p))
            out.push_back({&node, p.name, std::move(*value), text});
      }
    }
  return out;
}

// Seconds that all threads of this process have computed. On a busy machine, they are fewer than have passed.
double computed() {
  timespec t{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Cancels a computation after some time, and ends the process if it then continues for too long.
class Deadline {
 public:
  Deadline(std::atomic<bool>& cancel, double seconds)
      : thread_([this, &cancel, seconds] {
          if (wait(seconds)) return;
          cancel = true;
          if (!wait(20)) std::abort();
        }) {}
  ~Deadline() {
    done_ = true;
    thread_.join();
  }

 private:
  // Whether the computation ended before it took this long.
  bool wait(double seconds) const {
    const double end = computed() + seconds;
    while (!done_ && computed() < end) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return done_;
  }
  std::atomic<bool> done_{false};
  std::thread thread_;
};

class Runner {
 public:
  explicit Runner(fs::path folder)
      : folder_(std::move(folder)),
        store_(test::value_types(), folder_ / "cache"),
        evaluator_(test::value_types(), store_, hashes_) {
    if (const char* seconds = std::getenv("TERRAZZO_LIMITS_SECONDS")) seconds_ = std::atof(seconds);
  }

  // Runs the cases of a node type from number `first` on, and says each before it begins.
  void run(const NodeType& type, std::size_t first) {
    Diagnostics found;
    const Graph graph = load_graph(test::example_file(type), test::all_nodes(), {}, found);
    const std::vector<Case> cases = cases_of(graph, type);
    RunOptions options;
    options.threads = 2;
    options.output_folder = folder_ / "out";
    for (const auto& c : cases)
      for (const auto& [port, wires] : c.node->inputs)
        for (const auto& w : wires) options.targets.push_back(w.node);
    RunResult result;
    if (first < cases.size() && !options.targets.empty()) result = evaluator_.run(graph, options);
    for (std::size_t k = first; k < cases.size(); ++k) {
      say(fmt::format("case {} {} = {}", k, cases[k].parameter, cases[k].text));
      say("result " + outcome(graph, result, cases[k]));
    }
    say("end");
  }

  static void say(const std::string& line) {
    std::printf("limits: %s\n", line.c_str());
    std::fflush(stdout);
  }

 private:
  std::string outcome(const Graph& graph, const RunResult& result, const Case& c) {
    std::atomic<bool> cancel{false};
    ComputeRequest request;
    request.type = c.node->type;
    std::map<std::string, ParameterValue> set;
    for (const auto& [name, p] : c.node->parameters) set[name] = p.value;
    set[c.parameter] = c.value;
    request.parameters = effective_parameters(*c.node->type, set);
    request.output_folder = folder_ / "limits";
    request.provenance = "{}";
    request.memory = 1'000'000'000;
    request.files = input_files(*c.node, hashes_).paths;
    for (const auto& [port, wires] : c.node->inputs)
      for (const auto& w : wires) request.inputs[port].push_back(evaluator_.value(graph, result, w));
    request.work = Work(&cancel, nullptr);
    const Deadline deadline(cancel, seconds_);
    try {
      const ComputeResult out = compute_node(std::move(request));
      for (const auto& [port, value] : out.outputs) {
        BufferWriter bytes;
        value.type().encode(value.data(), bytes);
      }
      return "value";
    } catch (const Cancelled&) {
      return "canceled";
    } catch (const Error& e) {
      const auto& code = e.diagnostic().code;
      return (code == "failed" || code == "node-bug" ? "WRONG " : "error ") + code + " " +
             e.diagnostic().message;
    }
  }

  const fs::path folder_;
  double seconds_ = 0.06;
  Store store_;
  FileHashes hashes_;
  Evaluator evaluator_;
};

// The other end of the pipes below: "TYPE FIRST_CASE" on each line.
TEST(DISABLED_LimitsServer, Serve) {
  const char* folder = std::getenv("TERRAZZO_LIMITS_FOLDER");
  ASSERT_TRUE(folder);
  const rlimit memory{6'000'000'000, 6'000'000'000}, no_core{0, 0};
  ::setrlimit(RLIMIT_AS, &memory);
  ::setrlimit(RLIMIT_CORE, &no_core);
  Runner runner(folder);
  char type[100];
  std::size_t first = 0;
  while (std::scanf("%99s %zu", type, &first) == 2) runner.run(*test::all_nodes().find(type), first);
}

// A process of this program that runs the test above.
class Server {
 public:
  explicit Server(const fs::path& folder) {
    int in[2], out[2];
    if (::pipe2(in, O_CLOEXEC) != 0 || ::pipe2(out, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    ::setenv("TERRAZZO_LIMITS_FOLDER", folder.c_str(), 1);
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(in[0], STDIN_FILENO), ::dup2(out[1], STDOUT_FILENO);
      ::execl("/proc/self/exe", "terrazzo_tests", "--gtest_filter=DISABLED_LimitsServer.Serve",
              "--gtest_also_run_disabled_tests", static_cast<char*>(nullptr));
      ::_exit(1);
    }
    ::close(in[0]), ::close(out[1]);
    in_ = ::fdopen(in[1], "w");
    out_ = ::fdopen(out[0], "r");
  }
  ~Server() {
    std::fclose(in_);
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    std::fclose(out_);
  }
  void ask(const std::string& type, std::size_t first) {
    std::fprintf(in_, "%s %zu\n", type.c_str(), first);
    std::fflush(in_);
  }
  // The next line; nothing if the process has ended.
  std::optional<std::string> line() {
    constexpr std::string_view mark = "limits: ";
    char text[4096];
    while (std::fgets(text, sizeof text, out_)) {
      const std::string all = text;
      if (all.starts_with(mark)) return all.substr(mark.size(), all.size() - mark.size() - 1);
    }
    return {};
  }

 private:
  pid_t pid_ = -1;
  std::FILE *in_ = nullptr, *out_ = nullptr;
};

class LimitsOfEveryNode : public ::testing::TestWithParam<std::string> {
 protected:
  static void TearDownTestSuite() { server().reset(); }
  static std::unique_ptr<Server>& server() {
    static std::unique_ptr<Server> one;
    return one;
  }
};

TEST_P(LimitsOfEveryNode, GiveAValueOrAnError) {
  static const fs::path folder = test::temporary_folder();
  std::size_t next = 0;
  while (true) {
    if (!server()) server() = std::make_unique<Server>(folder);
    server()->ask(GetParam(), next);
    std::string last = "(its inputs)";
    std::optional<std::string> line;
    while ((line = server()->line()) && *line != "end") {
      if (line->starts_with("case ")) {
        last = *line;
        next = std::stoul(line->substr(5)) + 1;
      } else if (std::getenv("TERRAZZO_LIMITS_SHOW")) {
        std::printf("%s %s: %s\n", GetParam().c_str(), last.c_str(), line->c_str());
      }
      EXPECT_FALSE(line->starts_with("result WRONG")) << last << ": " << *line;
    }
    if (line) return;
    server().reset();
    ADD_FAILURE() << GetParam() << " ended the process, or could not be canceled: " << last;
    if (last == "(its inputs)") return;
  }
}

INSTANTIATE_TEST_SUITE_P(Contract, LimitsOfEveryNode, ::testing::ValuesIn(test::all_nodes().names()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace terrazzo
