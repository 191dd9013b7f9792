#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "graph/node_type.h"
#include "nodes/data/table.h"
#include "nodes/volumes/blocks/block_grids.h"
#include "runtime/context.h"

namespace terrazzo::block_index {
namespace {

// "solid_{}.vdb" → "solid_17.vdb"
std::string file_of(const std::string& pattern, std::size_t block) {
  const auto at = pattern.find("{}");
  return at == std::string::npos ? pattern
                                 : pattern.substr(0, at) + std::to_string(block) + pattern.substr(at + 2);
}

void check(const NodeParameters& p) {
  const std::string files = p.text("files");
  if (!files.empty() && files.find("{}") == std::string::npos)
    throw Error("bad-value", fmt::format("the name '{}' is the same for all blocks", files),
                "write {} where the number of the block belongs, as in solid_{}.vdb")
        .parameter("files");
}

void compute(Context& c) {
  const std::size_t count = c.count("volumes");
  const std::string files = c.text("files");
  blocks::BlockGrids grids(count);
  Table out{{"block"}, {}};
  if (!files.empty()) out.columns.push_back("file");
  for (const char* column : {"x", "y", "z", "size x", "size y", "size z"})
    out.columns.push_back(std::string(column) + " voxels");
  for (std::size_t k = 0; k < count; ++k) {
    c.work().check();
    const Value value = c.nth("volumes", k);
    const blocks::Box box = grids.add(value.as<Volume>());
    std::vector<Table::Cell> row = {static_cast<double>(k)};
    if (!files.empty()) row.emplace_back(file_of(files, k));
    for (const Vec3i& v : {box.low, box.size})
      for (int a = 0; a < 3; ++a) row.emplace_back(static_cast<double>(v[a]));
    out.rows.push_back(std::move(row));
    c.work().done(k + 1, count);
  }
  const blocks::Box whole = grids.whole(c.boolean("periodic"));
  c.metric("blocks", count);
  c.metric("voxels", whole.size.cast<double>().prod());
  c.output("table", std::move(out));
}

}  // namespace
}  // namespace terrazzo::block_index

namespace terrazzo {

NodeType block_index_node() {
  using namespace block_index;
  return NodeType("BlockIndex", 1)
      .doc_("Lists where the blocks of a solid lie: the index of a solid that stays in one file per block.")
      .source_("None: reads the boxes of volumes")
      .input_list(
          "volumes", {"Volume"},
          "The blocks, in the order of their files: all blocks of one cut, each once, with equal grids. "
          "Every voxel of a block has a value.")
      .one_at_a_time()
      .output("table", "Table",
              "One row per block: its position in the list, from 0, its file, its first voxel and its size")
      .parameter(
          Parameter::text("files", "")
              .doc_("Names of the files, where {} stands for the position of the block. Empty: the table has "
                    "no column `file`."))
      .parameter(Parameter::boolean("periodic", true)
                     .doc_("The solid tiles. Its voxels must then begin at (0, 0, 0)."))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
