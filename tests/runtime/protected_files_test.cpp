// What a graph reads is not overwritten, whatever path leads to it.
#include "runtime/files/protected_files.h"

#include <gtest/gtest.h>

#include <fstream>

#include "runtime/evaluate.h"
#include "runtime/files.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

class Protected : public ::testing::Test {
 protected:
  Protected() {
    fs::create_directories(out);
    std::ofstream(folder / "data.csv") << "mine";
    std::ofstream(folder / "inner.yaml") << "terrazzo: 1\nnodes:\n  a: {type: Constant, params: {value: 1}}\n"
                                            "outputs: {out: a.out}\n";
  }
  Graph load(const std::string& writers) {
    std::ofstream(folder / "g.yaml") << "terrazzo: 1\nnodes:\n"
                                        "  size: {type: FileSize, params: {path: data.csv}}\n"
                                        "  part: {graph: inner.yaml}\n"
                                     << writers;
    Diagnostics found;
    Graph g = load_graph(folder / "g.yaml", test::arithmetic(), {}, found);
    for (const auto& d : found) ADD_FAILURE() << d.text();
    return g;
  }
  // The error of the node `w`, which writes to this path below the output folder.
  std::string error(const std::string& path) {
    const Graph g = load("  w: {type: Write, inputs: {in: part.out}, params: {path: \"" + path + "\"}}\n");
    const RunResult r = run(g);
    const auto& e = r.nodes[static_cast<std::size_t>(g.find("w"))].error;
    return e ? e->code : "";
  }
  RunResult run(const Graph& g) {
    Store store(test::value_types(), {});
    FileHashes hashes;
    RunOptions o;
    o.output_folder = out;
    return Evaluator(test::value_types(), store, hashes).run(g, o);
  }
  const fs::path folder = test::temporary_folder(), out = folder / "out";
};

TEST_F(Protected, InputsGraphAndSubgraphsStayThroughLinksAndSecondNames) {
  fs::create_hard_link(folder / "data.csv", out / "hard.csv");
  fs::create_symlink("../data.csv", out / "soft.csv");
  fs::create_hard_link(folder / "inner.yaml", out / "inner.csv");
  EXPECT_EQ(error("hard.csv"), "overwrites-input");
  EXPECT_EQ(error("soft.csv"), "overwrites-input");
  EXPECT_EQ(error("inner.csv"), "overwrites-input");
  fs::create_hard_link(folder / "g.yaml", out / "g.csv");
  EXPECT_EQ(error("g.csv"), "overwrites-input");
  EXPECT_EQ(read_file(folder / "data.csv"), "mine");
  EXPECT_EQ(read_file(out / "hard.csv"), "mine");
  EXPECT_EQ(error("free.csv"), "");
}

TEST_F(Protected, OneFileIsNotWrittenByTwoNodes) {
  fs::create_directories(out / "a");
  fs::create_directory_symlink("a", out / "b");
  const Graph g = load(
      "  one: {type: Write, inputs: {in: part.out}, params: {path: a/x.csv}}\n"
      "  two: {type: Write, inputs: {in: size.out}, params: {path: b/x.csv}}\n");
  const RunResult r = run(g);
  EXPECT_EQ(test::count(r, Status::Failed), 1);
  for (const auto& n : r.nodes)
    if (n.error) EXPECT_EQ(n.error->code, "same-file") << n.error->text();
}

TEST_F(Protected, EveryWriterOfFilesAsks) {
  const ProtectedFiles keep(load(""));
  for (const char* name : {"data.csv", "g.yaml", "inner.yaml"}) {
    const auto before = read_file(folder / name);
    EXPECT_EQ(test::code_of([&] { write_text_atomically(folder / name, keep, "x"); }), "overwrites-input");
    EXPECT_EQ(read_file(folder / name), before);
  }
  write_text_atomically(folder / "new.txt", keep, "x");
  EXPECT_EQ(read_file(folder / "new.txt"), "x");
}

}  // namespace
}  // namespace terrazzo
