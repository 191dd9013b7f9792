// Loads and runs one fixture file per format version.
#include <gtest/gtest.h>

#include "runtime/evaluate.h"
#include "tests/support/arithmetic.h"
#include "tests/support/program.h"

namespace terrazzo {
namespace {

TEST(Format, FilesOfVersion1Run) {
  Diagnostics found;
  const Graph g =
      load_graph(test::source_folder() / "tests/graph/fixtures/format_1.yaml", test::arithmetic(), {}, found);
  for (const auto& d : found) ADD_FAILURE() << d.text();
  Store store(test::value_types(), {});
  FileHashes hashes;
  Evaluator e(test::value_types(), store, hashes);
  const RunResult r = e.run(g, {});
  EXPECT_EQ(test::number_of(e.value(g, r, g.wire_to("result"))), 2 + 1.5 + 1);
  EXPECT_EQ(g.doc, "Every construct once.");
  // The action keys must not change either, so that cached results stay valid.
  EXPECT_EQ(r.nodes[static_cast<std::size_t>(g.find("inner/clamp"))].key.text(),
            "c39a2df043ff97981c479a34fddc437a");
}

TEST(Format, AVersionToComeIsRefusedWithAWord) {
  Diagnostics found;
  load_graph_text("terrazzo: 2\nnodes:\n  a: {type: Constant}\n", "new.yaml", test::arithmetic(), {}, found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].text(),
            "new.yaml:1:1: error: format version '2' is not supported (the file needs a newer version of "
            "Terrazzo)");
}

}  // namespace
}  // namespace terrazzo
