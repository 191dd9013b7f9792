// Results do not depend on what the program that contains Terrazzo has set: the locale, and the
// floating-point environment of its threads.
#include <fmt/format.h>
#include <gtest/gtest.h>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

#include <algorithm>
#include <bit>
#include <cfenv>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <locale>
#include <sstream>

#include "nodes/data/table.h"
#include "runtime/codec.h"
#include "runtime/context.h"
#include "runtime/session.h"
#include "runtime/work.h"
#include "tests/contract/contents.h"
#include "tests/support/all_nodes.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"
#include "tests/torture/input_seeds.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

// As a German program sets it: 1,5 and 12.345. Compiled here, since few systems have it installed.
class GermanLocale {
 public:
  GermanLocale() {
    static const bool made = make();
    EXPECT_TRUE(made) << "localedef failed; the package 'locales' has its sources";
    if (!made) return;
    EXPECT_TRUE(std::setlocale(LC_ALL, kName));
    std::locale::global(std::locale(kName));
    char text[16];
    std::snprintf(text, sizeof text, "%.1f", 1.5);
    std::ostringstream out;
    out << 12345;
    EXPECT_EQ(std::string(text) + " " + out.str(), "1,5 12.345");
  }
  ~GermanLocale() { std::locale::global(std::locale::classic()), std::setlocale(LC_ALL, "C"); }

 private:
  static constexpr const char* kName = "de_DE.UTF-8";
  static bool make() {
    const fs::path folder = test::temporary_folder();
    ::setenv("LOCPATH", folder.c_str(), 1);
    const std::string command = "localedef --no-archive -i de_DE -f UTF-8 " + (folder / kName).string();
    return std::system(command.c_str()) == 0;
  }
};

// A thread that rounds down, and treats denormal numbers as zero where the processor can.
class StrangeArithmetic {
 public:
  StrangeArithmetic() {
    std::fegetenv(&before_);
    std::fesetround(FE_DOWNWARD);
#ifdef __SSE__
    _mm_setcsr(_mm_getcsr() | 0x8040);
#endif
  }
  ~StrangeArithmetic() { std::fesetenv(&before_); }
  static bool is_set() {
#ifdef __SSE__
    if ((_mm_getcsr() & 0x8040) != 0x8040) return false;
#endif
    return std::fegetround() == FE_DOWNWARD;
  }

 private:
  std::fenv_t before_;
};

std::string bytes_of(const Value& v) {
  BufferWriter out;
  v.type().encode(v.data(), out);
  return std::string(out.buffer.begin(), out.buffer.end());
}

// What a reader makes of a file; "" if it needs more than the file.
std::string content_of(const torture::InputSeed& seed, const fs::path& folder) {
  for (const auto& [name, content] : seed.files) std::ofstream(folder / name, std::ios::binary) << content;
  const std::string type = seed.reader.substr(0, seed.reader.find('.'));
  const NodeType* node = test::all_nodes().find(type);
  if (!node) return "";
  std::map<std::string, std::string> parameters;
  for (const Parameter& p : node->parameters)
    if (p.kind == ParameterKind::InputPath && !p.value)
      parameters[p.name] = (folder / seed.files.begin()->first).string();
  if (type == "LoadVolume") parameters["spacing"] = "0.5";
  try {
    const test::NodeRun run = test::run_node(type, {}, parameters, folder);
    std::string out;
    for (const auto& [port, value] : run.outputs) out += port + " " + bytes_of(value);
    for (const auto& [name, value] : run.metrics) out += fmt::format(" {} {}", name, value);
    return fmt::format("{} {}", out, fmt::join(run.warnings, " "));
  } catch (const Error&) {
    return "";
  }
}

TEST(HostSettings, ReadersIgnoreTheLocale) {
  const fs::path folder = test::temporary_folder();
  torture::write_input_seeds(folder, fs::path(TERRAZZO_SOURCE));
  const auto seeds = torture::read_input_seeds(folder);
  std::vector<std::string> expected;
  const fs::path place = test::temporary_folder();  // messages name it
  for (const auto& seed : seeds) expected.push_back(content_of(seed, place));
  const auto read = std::count_if(expected.begin(), expected.end(), [](const auto& s) { return !s.empty(); });
  EXPECT_GT(read, 40);
  const GermanLocale german;
  for (std::size_t i = 0; i < seeds.size(); ++i)
    EXPECT_TRUE(content_of(seeds[i], place) == expected[i])
        << seeds[i].reader << " " << seeds[i].files.begin()->first << " differs";
}

// Nodes whose parameters contain numbers as text, writers, and plots with numbers as labels.
TEST(HostSettings, NodesIgnoreTheLocale) {
  const std::vector<std::string> types = {"EditLabels",   "Export",       "DrawStrokes",
                                          "ContactSheet", "Distribution", "Palette"};
  std::map<std::string, nlohmann::json> expected;
  for (const auto& type : types)
    expected[type] = test::example_contents(test::all_nodes(), *test::all_nodes().find(type), 2);
  const GermanLocale german;
  for (const auto& type : types)
    EXPECT_EQ(test::example_contents(test::all_nodes(), *test::all_nodes().find(type), 2), expected[type])
        << type;
}

const char* const kUnfolding = R"(terrazzo: 1
parameters:
  fraction: {type: number, default: 0.25, min: 0.125, max: 0.5}
nodes:
  sizes: {type: Distribution, params: {mean: 2.5, sd: 0.5, classes: 3, volume_fraction: "${fraction}"}}
  sphere: {type: Shape, params: {kind: sphere}}
  matrix: {type: KMatrix, inputs: {shapes: sphere.shapes}, params: {classes: 3, method: analytic}}
)";

std::map<std::string, std::map<std::string, double>> metrics_of(const fs::path& cache, Status expected) {
  Session session(test::all_nodes(), test::value_types(), {.cache_folder = cache, .threads = 2});
  for (const auto& d : session.open_text(kUnfolding, "unfolding.yaml")) ADD_FAILURE() << d.text();
  const auto evaluation = session.evaluate();
  const RunResult& result = evaluation->wait();
  std::map<std::string, std::map<std::string, double>> out;
  for (std::size_t i = 0; i < result.nodes.size(); ++i) {
    EXPECT_EQ(result.nodes[i].status, expected) << session.graph()->nodes[i].path;
    out[session.graph()->nodes[i].path] = result.nodes[i].metrics;
  }
  return out;
}

TEST(HostSettings, CachedResultsIgnoreTheLocale) {
  const fs::path plain = test::temporary_folder(), foreign = test::temporary_folder();
  const auto expected = metrics_of(plain, Status::Computed);
  std::size_t fractions = 0;
  for (const auto& [node, metrics] : expected)
    for (const auto& [name, value] : metrics) fractions += value != std::floor(value);
  ASSERT_GT(fractions, 0u) << "this graph has no metric that could lose its decimals";
  {
    const GermanLocale german;
    EXPECT_EQ(metrics_of(plain, Status::Disk), expected);
    EXPECT_EQ(metrics_of(foreign, Status::Computed), expected);
    EXPECT_EQ(metrics_of(foreign, Status::Disk), expected);
  }
  EXPECT_EQ(metrics_of(foreign, Status::Disk), expected);
}

// Sums of denormal numbers, and sums that depend on the rounding, by ranges on several threads.
std::vector<double> sums(const Work& work) {
  volatile double one = 1, smallest = 1e-310;  // no constants, which the compiler would fold
  std::vector<double> out(1280);
  work.parallel(640, 10, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (int k = 3; k < 10; ++k) out[2 * i] += one / k, out[2 * i + 1] += smallest / k;
  });
  return out;
}

TEST(HostSettings, LoopsIgnoreTheArithmeticOfTheThread) {
  const auto bits = [](const std::vector<double>& v) {
    return std::string(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(double));
  };
  const std::string expected = bits(sums(Work()));
  const StrangeArithmetic strange;
  EXPECT_TRUE(bits(sums(Work())) == expected);
  EXPECT_TRUE(StrangeArithmetic::is_set());
}

// The number of threads is one that no other test uses, so that no arena exists before.
std::string table_of_sums(int threads) {
  static const Registry registry = [] {
    Registry r;
    r.add(NodeType("Sums", 1).doc_("test").output("out", "Table", "sums").compute_([](Context& c) {
      const std::vector<double> loop = sums(c.work());
      volatile double three = 3, denormal = 1e-310;
      Table table{{"sum", "third", "denormal"}, {}};
      for (const double sum : loop) table.rows.push_back({sum, 1 / three, denormal / three});
      c.output("out", std::move(table));
    }));
    return r;
  }();
  Session session(registry, test::value_types(), {.threads = threads});
  for (const auto& d : session.open_text("terrazzo: 1\nnodes: {sums: {type: Sums}}\n", "sums.yaml"))
    ADD_FAILURE() << d.text();
  return bytes_of(session.value("sums"));
}

TEST(HostSettings, RunsIgnoreTheArithmeticOfTheThread) {
  const std::string expected = table_of_sums(11);
  const StrangeArithmetic strange;
  EXPECT_TRUE(table_of_sums(13) == expected);
  EXPECT_TRUE(table_of_sums(1) == expected);
  EXPECT_TRUE(StrangeArithmetic::is_set()) << "the settings of the host's thread are its own";
}

// Loops of other libraries, such as OpenVDB's, and the reading of numbers in a graph.
TEST(HostSettings, NodesIgnoreTheArithmeticOfTheThread) {
  for (const char* type : {"Voxelize", "Unfold", "Distribution"}) {
    const NodeType& node = *test::all_nodes().find(type);
    const nlohmann::json expected = test::example_contents(test::all_nodes(), node, 9);
    const StrangeArithmetic strange;
    EXPECT_EQ(test::example_contents(test::all_nodes(), node, 10), expected) << type;
  }
}

}  // namespace
}  // namespace terrazzo
