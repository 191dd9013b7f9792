// A hundred and twenty random edits of the default graph: exactly the affected nodes are recomputed, and
// every result equals that of a run from scratch.
#include <gtest/gtest.h>

#include <set>

#include "nodes/common/io/image_file.h"
#include "nodes/register_nodes.h"
#include "runtime/random.h"
#include "runtime/session.h"
#include "tests/support/arithmetic.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

// The default graph, small.
const Overrides small{{{"pack.size", "22"},
                       {"voxels.resolution", "16"},
                       {"detail.size", "16"},
                       {"section.width", "14"},
                       {"section.height", "14"},
                       {"observer.crop", "32"},
                       {"observer.crops", "16"},
                       {"kmatrix.orientations", "40"},
                       {"sections.planes", "2"},
                       {"block.samples", "1"},
                       {"block.width", "48"},
                       {"block.height", "48"},
                       {"sheet.cell", "48"},
                       {"unfold.bootstrap", "0"},
                       {"segment.method", "clusters"},  // the network takes seconds, and fit too
                       {"shape.method", "morphed_generalized_cylinder"}},
                      {},
                      {}};

const std::vector<std::pair<std::string, std::vector<std::string>>> edits = {
    {"colorize.seed", {"1", "2", "3"}},
    {"pack.seed", {"1", "2"}},
    {"voxels.resolution", {"16", "[16]", "20"}},  // [16] is 16
    {"segment.split", {"0.5", "0.45"}},
    {"shape.seed", {"1", "2"}},
    {"detail.seed", {"1", "2", "3"}},
    {"sections.seed", {"1", "2", "3"}},
    {"block.samples", {"1", "2"}},
    {"sheet.background", {"light", "dark"}},
    {"unfold.classes", {"5", "6"}},
    {"compare.tolerance", {"0.1"}},
    {"photo.pixel_size", {"0.1", "0.1000"}}};  // the same number

// A part of the default photograph, since Segment and DetailSolid take as long as their picture is large.
fs::path small_photo(const fs::path& folder) {
  const Image all = read_image(test::source_folder() / "graphs/samples/section.png");
  Image part(320, 320, 1, all.pixel_size);
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x) part.at(x, y) = all.at(x, y);
  write_image(folder / "photo.png", part);
  return folder / "photo.png";
}

TEST(Edits, AreIncrementalAndMinimal) {
  Registry registry;
  register_nodes(registry);
  const auto base = test::temporary_folder();
  const auto file = test::source_folder() / "graphs/materials/terrazzo.yaml";
  Session session(
      registry, test::value_types(),
      {.cache_folder = base / "cache", .output_folder = base / "out", .keep_intermediates = true});
  Overrides settings = small;
  settings.set.emplace_back("photo.path", small_photo(base).string());
  for (const auto& d : session.open(file, settings)) ADD_FAILURE() << d.text();
  std::set<Hash> known;
  std::map<std::string, Hash> written;  // action record behind each written file
  int clean_runs = 0;
  for (int i = 0; i < 120; ++i) {
    Random random(11, 0, static_cast<std::uint64_t>(i));
    const auto& [target, values] = edits[random.below(edits.size())];
    for (const auto& d : session.set(target, values[random.below(values.size())]))
      if (d.code != "unknown-parameter") ADD_FAILURE() << d.text();
    const auto evaluation = session.evaluate();
    const RunResult& r = evaluation->wait();
    const Graph& g = evaluation->graph();
    for (std::size_t k = 0; k < g.nodes.size(); ++k) {
      const NodeResult& n = r.nodes[k];
      if (n.error) ADD_FAILURE() << n.error->text();
      if (n.status == Status::Unneeded) continue;
      // A node is computed if and only if its action key is new; an unchanged result ends the change. A file
      // is also written again if another version has taken its name since.
      const bool fresh = known.insert(n.record).second;
      const bool overwritten =
          g.nodes[k].type->writes_files && std::exchange(written[g.nodes[k].path], n.record) != n.record;
      EXPECT_EQ(n.status == Status::Computed, fresh || overwritten) << i << ": " << g.nodes[k].path;
    }
    if (HasFailure()) return;
    if (i % 20 != 19) continue;
    Session clean(registry, test::value_types(), {.output_folder = base / "clean"});
    clean.open(file, session.overrides());
    const auto again = clean.evaluate();
    for (std::size_t k = 0; k < g.nodes.size(); ++k)
      EXPECT_EQ(again->wait().nodes[k].outputs, r.nodes[k].outputs) << i << ": " << g.nodes[k].path;
    ++clean_runs;
  }
  EXPECT_EQ(clean_runs, 6);
}

}  // namespace
}  // namespace terrazzo
