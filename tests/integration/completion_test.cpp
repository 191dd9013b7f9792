// Shell completion, as the scripts of `terrazzo completion` call it.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>

#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using Candidates = std::vector<std::string>;

Candidates lines_of(const std::string& text) {
  Candidates out;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

// The candidates for the last word. Checks that the program reports nothing else.
Candidates candidates(std::vector<std::string> words, const fs::path& folder = {}) {
  words.insert(words.begin(), {"complete", "--"});
  const auto run = test::run_program(words, {.folder = folder});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.err, "");
  return lines_of(run.out);
}

bool contains(const Candidates& all, const std::string& one) {
  return std::find(all.begin(), all.end(), one) != all.end();
}

// A folder with graph.yaml, which uses inner.yaml, and other files.
fs::path folder_with_graph() {
  const fs::path folder = test::temporary_folder();
  std::ofstream(folder / "graph.yaml") << R"(terrazzo: 1
parameters:
  photo: {type: path}
  method: {type: choice, choices: [fast, exact], default: fast}
nodes:
  stone: {type: Shape, params: {kind: sphere}}
  cut: {type: Section, inputs: {volume: no.such}}
  asset: {graph: inner.yaml}
outputs:
  result: stone.shapes
  cut: cut.image
)";
  std::ofstream(folder / "inner.yaml") << "terrazzo: 1\nparameters:\n  size: {type: number, default: 1}\n"
                                          "nodes:\n  pack: {type: Anneal}\n";
  std::ofstream(folder / "notes.txt") << "text";
  fs::create_directory(folder / "materials");
  return folder;
}

TEST(Completion, OffersCommandsAndTheirSubcommands) {
  EXPECT_EQ(candidates({"ex"}), Candidates{"explain"});
  EXPECT_EQ(candidates({"cache", ""}), (Candidates{"stats", "verify", "gc", "clear"}));
  EXPECT_TRUE(contains(candidates({""}), "sweep"));
  EXPECT_FALSE(contains(candidates({""}), "complete"));
  EXPECT_EQ(candidates({"no-such-command", ""}), Candidates{});
}

TEST(Completion, OffersTheOptionsOfTheCommandOnce) {
  EXPECT_EQ(candidates({"cache", "verify", "--s"}), (Candidates{"--sample", "--seed"}));
  EXPECT_EQ(candidates({"cache", "stats", "--s"}), Candidates{});
  EXPECT_EQ(candidates({"run", "g.yaml", "--quiet", "--q"}), Candidates{});
  EXPECT_EQ(candidates({"run", "g.yaml", "--set", "a.b=1", "--se"}), Candidates{"--set"});
  EXPECT_EQ(candidates({"schema", "--", "--h"}), Candidates{});
}

TEST(Completion, OffersTheValuesOfAnOption) {
  EXPECT_EQ(candidates({"graph", "g.yaml", "--format", ""}), (Candidates{"dot", "svg", "mermaid"}));
  EXPECT_EQ(candidates({"graph", "g.yaml", "--format=s"}), Candidates{"--format=svg"});
  EXPECT_EQ(candidates({"completion", ""}), (Candidates{"bash", "zsh", "fish"}));
  EXPECT_EQ(candidates({"run", "--threads", ""}, folder_with_graph()), Candidates{});
}

TEST(Completion, OffersFilesOfTheKindThatTheArgumentNeeds) {
  const auto folder = folder_with_graph();
  EXPECT_EQ(candidates({"run", ""}, folder), (Candidates{"graph.yaml", "inner.yaml", "materials/"}));
  EXPECT_EQ(candidates({"reproduce", "n"}, folder), Candidates{"notes.txt"});
  EXPECT_EQ(candidates({"run", "--out", ""}, folder), Candidates{"materials/"});
  EXPECT_EQ(candidates({"run", (folder / "gr").string()}), Candidates{(folder / "graph.yaml").string()});
}

TEST(Completion, OffersNodeTypes) {
  const auto shapes = candidates({"nodes", "Shape"});
  EXPECT_TRUE(contains(shapes, "ShapeEstimate"));
  EXPECT_FALSE(contains(shapes, "Anneal"));
  EXPECT_EQ(candidates({"nodes", "./in"}, folder_with_graph()), Candidates{"./inner.yaml"});
}

TEST(Completion, OffersTheParametersOfAGraphAndTheirValues) {
  const auto folder = folder_with_graph();
  const auto options = [&](const std::string& command, const std::string& option, const std::string& typed) {
    return candidates({command, "graph.yaml", option, typed}, folder);
  };
  EXPECT_EQ(options("run", "--param", ""), (Candidates{"photo=", "method="}));
  EXPECT_EQ(options("run", "--param", "method="), (Candidates{"method=fast", "method=exact"}));
  EXPECT_EQ(options("run", "--param", "photo=no"), Candidates{"photo=notes.txt"});
  EXPECT_EQ(options("run", "--set", "stone.ki"), Candidates{"stone.kind="});
  EXPECT_EQ(options("run", "--set", "cut.axis="),
            (Candidates{"cut.axis=x", "cut.axis=y", "cut.axis=z", "cut.axis=free", "cut.axis=random"}));
  EXPECT_EQ(options("run", "--set", "asset.s"), Candidates{"asset.size="});
  EXPECT_EQ(options("run", "--set", "asset/pack.si"), Candidates{"asset/pack.size="});
  EXPECT_EQ(options("sweep", "--vary", "method=fast,e"), Candidates{"method=fast,exact"});
  EXPECT_TRUE(contains(options("sweep", "--vary", ""), "cut.axis="));
  EXPECT_EQ(candidates({"run", "graph.yaml", "--set=stone.ki"}, folder), Candidates{"--set=stone.kind="});
}

TEST(Completion, OffersNodesAndOutputsOfAGraph) {
  const auto folder = folder_with_graph();
  EXPECT_EQ(candidates({"run", "graph.yaml", "--target", ""}, folder),
            (Candidates{"result", "cut", "stone", "asset/pack"}));
  EXPECT_EQ(candidates({"run", "graph.yaml", "--target", "stone."}, folder), Candidates{"stone.shapes"});
  const auto ports = candidates({"show", "graph.yaml", ""}, folder);
  EXPECT_TRUE(contains(ports, "result"));
  EXPECT_TRUE(contains(ports, "asset/pack.particles"));
  EXPECT_FALSE(contains(ports, "stone"));
}

TEST(Completion, UsesTheDefaultGraphIfNoneIsGiven) {
  EXPECT_EQ(candidates({"run", "--param", "pix"}), Candidates{"pixel_size="});
  EXPECT_EQ(candidates({"check", "--param", "pix"}), Candidates{});
}

TEST(Completion, OffersNothingForGraphsThatItCannotRead) {
  const auto folder = test::temporary_folder();
  std::ofstream(folder / "broken.yaml") << "terrazzo: 1\nnodes: {a: [\n";
  std::ofstream(folder / "bytes.yaml") << "terrazzo: 1\nnodes:\n  \xff\xfe\x01: {type: \x80}\n";
  std::ofstream(folder / "itself.yaml") << "terrazzo: 1\nnodes:\n  again: {graph: itself.yaml}\n";
  std::ofstream(folder / "piped.yaml") << "terrazzo: 1\nnodes:\n  inner: {graph: pipe.yaml}\n";
  ASSERT_EQ(::mkfifo((folder / "pipe.yaml").c_str(), 0600), 0);
  for (const char* graph : {"missing.yaml", "broken.yaml", "bytes.yaml", "itself.yaml", "pipe.yaml",
                            "piped.yaml", "", ".", "/dev/zero", "\xff\n\x1b[31m"})
    for (const char* option : {"--set", "--param", "--target"})
      EXPECT_EQ(candidates({"run", graph, option, ""}, folder), Candidates{}) << graph << ' ' << option;
}

TEST(Completion, SurvivesAnyWords) {
  const std::vector<std::vector<std::string>> lines = {{},
                                                       {"--"},
                                                       {"--="},
                                                       {"-"},
                                                       {"run", "--set"},
                                                       {"run", "\xff\xfe=", "\x1b[31m=\n"},
                                                       {"run", "--", "--", "--set", ""},
                                                       {"run", "--set=", "--param=", "=", "..."},
                                                       {"nodes", std::string(100'000, '/')},
                                                       {"show", "a", "b", "c", "d", "e"}};
  for (const auto& words : lines)
    for (const auto& c : candidates(words)) EXPECT_TRUE(c.starts_with(words.back())) << c;
}

TEST(Completion, OmitsNamesWithControlCharacters) {
  const auto folder = test::temporary_folder();
  for (const char* name : {"a\nb.yaml", "a\x1b[31m.yaml", "a\t.yaml", "a b.yaml"})
    std::ofstream(folder / name) << "terrazzo: 1\n";
  EXPECT_EQ(candidates({"run", "a"}, folder), Candidates{"a b.yaml"});
}

TEST(Completion, WritesNothing) {
  const auto folder = folder_with_graph();
  const auto home = test::temporary_folder();
  const auto before = std::distance(fs::recursive_directory_iterator(folder), {});
  const auto run = test::run_program({"complete", "--", "run", "graph.yaml", "--set", ""},
                                     {.environment = "XDG_CACHE_HOME=" + home.string(), .folder = folder});
  EXPECT_FALSE(run.out.empty());
  EXPECT_EQ(std::distance(fs::recursive_directory_iterator(folder), {}), before);
  EXPECT_FALSE(fs::exists(home / "terrazzo"));
}

// Loading the nodes takes 0.3 s, which a user notices.
TEST(Completion, LoadsNodesOnlyIfCandidatesDependOnThem) {
  const auto folder = folder_with_graph();
  const auto loads_nodes = [&](const std::vector<std::string>& words) {
    const auto logs = folder / "materials" / "logs";
    fs::create_directory(logs);
    std::vector<std::string> command = {"env",
                                        "LD_DEBUG=files",
                                        "LD_DEBUG_OUTPUT=" + (logs / "log").string(),
                                        (test::build_folder() / "terrazzo").string(),
                                        "complete",
                                        "--"};
    command.insert(command.end(), words.begin(), words.end());
    EXPECT_EQ(test::run_command(command, {.folder = folder}).exit_code, 0);
    std::string all;
    for (const auto& log : fs::directory_iterator(logs)) all += read_file(log.path()).value_or("");
    fs::remove_all(logs);
    EXPECT_NE(all.find("libterrazzo_runtime"), std::string::npos) << "the loader reported nothing";
    return all.find("libterrazzo_nodes") != std::string::npos;
  };
  EXPECT_FALSE(loads_nodes({""}));
  EXPECT_FALSE(loads_nodes({"run", "--"}));
  EXPECT_FALSE(loads_nodes({"run", ""}));
  EXPECT_FALSE(loads_nodes({"run", "graph.yaml", "--param", ""}));
  EXPECT_FALSE(loads_nodes({"run", "graph.yaml", "--target", ""}));
  EXPECT_FALSE(loads_nodes({"run", "graph.yaml", "--set", "asset.s"}));
  EXPECT_TRUE(loads_nodes({"nodes", ""}));
  EXPECT_TRUE(loads_nodes({"run", "graph.yaml", "--set", "stone."}));
}

// Writes the script for a shell to a file.
fs::path script_for(const std::string& shell) {
  const auto run = test::run_program({"completion", shell});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const fs::path file = test::temporary_folder() / ("terrazzo." + shell);
  std::ofstream(file) << run.out;
  return file;
}

bool installed(const std::string& shell) { return test::run_command({shell, "-c", "true"}).exit_code == 0; }

TEST(CompletionScripts, HaveValidSyntax) {
  ASSERT_TRUE(installed("bash"));
  for (const std::string shell : {"bash", "zsh", "fish"}) {
    if (!installed(shell)) continue;
    const auto run = test::run_command({shell, "-n", script_for(shell).string()});
    EXPECT_EQ(run.exit_code, 0) << shell;
    EXPECT_EQ(run.err, "") << shell;
  }
  EXPECT_EQ(test::run_program({"completion", "csh"}).exit_code, 2);
}

// `words`: as bash splits `line`, quoted for bash.
Candidates in_bash(const std::string& line, const std::string& words, const fs::path& folder) {
  const std::string program = (test::build_folder() / "terrazzo").string();
  const auto run = test::run_command(
      {"bash", "-c",
       "source '" + script_for("bash").string() + "'; COMP_LINE=$1; COMP_POINT=${#1}; COMP_WORDS=('" +
           program + "' " + words +
           "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _terrazzo; printf '%s\\n' \"${COMPREPLY[@]}\"",
       "bash", program + " " + line},
      {.folder = folder});
  EXPECT_EQ(run.err, "");
  return lines_of(run.out);
}

TEST(CompletionScripts, BashCompletes) {
  const auto folder = folder_with_graph();
  EXPECT_EQ(in_bash("cache ", "cache ''", folder), (Candidates{"stats", "verify", "gc", "clear"}));
  EXPECT_EQ(in_bash("run gr", "run gr", folder), Candidates{"graph.yaml"});
  // Bash replaces only what follows the '='.
  EXPECT_EQ(in_bash("run graph.yaml --set cut.axis=r", "run graph.yaml --set cut.axis = r", folder),
            Candidates{"random"});
  EXPECT_EQ(in_bash("run graph.yaml --param method=", "run graph.yaml --param method =", folder),
            (Candidates{"fast", "exact"}));
  fs::rename(folder / "graph.yaml", folder / "my graph.yaml");
  EXPECT_EQ(in_bash("run my", "run my", folder), Candidates{"my\\ graph.yaml"});
  EXPECT_EQ(in_bash("run my\\ graph.yaml --param ", "run 'my\\ graph.yaml' --param ''", folder),
            (Candidates{"photo=", "method="}));
}

TEST(CompletionScripts, FishCompletes) {
  if (!installed("fish")) GTEST_SKIP() << "fish is not installed";
  const auto run = test::run_command(
      {"fish", "-c",
       "set PATH '" + test::build_folder().string() + "' $PATH; source '" + script_for("fish").string() +
           "'; complete -C 'terrazzo run graph.yaml --param method='"},
      {.folder = folder_with_graph()});
  EXPECT_EQ(run.out, "method=exact\nmethod=fast\n") << run.err;
}

}  // namespace
}  // namespace terrazzo
