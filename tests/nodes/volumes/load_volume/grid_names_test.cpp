#include <gtest/gtest.h>
#include <openvdb/io/File.h>

#include "nodes/data/volume.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

// Reports and glTF require UTF-8; OpenVDB files allow any bytes.
TEST(LoadVolume, GridNamesThatAreNotUtf8AreReplacedWithAWarning) {
  initialize_openvdb();
  const auto file = test::temporary_folder() / "names.vdb";
  auto grid = openvdb::FloatGrid::create(0);
  grid->setName("densit\xe9");
  grid->tree().setValue(openvdb::Coord(1, 2, 3), 7);
  openvdb::io::File(file.string()).write({grid});
  const auto run = test::run_node("LoadVolume", {}, {{"path", "'" + file.string() + "'"}});
  const auto read = run.output<Volume>("volume").find<openvdb::FloatGrid>("densit\uFFFD");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->tree().getValue(openvdb::Coord(1, 2, 3)), 7);
  bool said = false;
  for (const auto& w : run.warnings) said = said || w.find("not UTF-8") != std::string::npos;
  EXPECT_TRUE(said);
}

}  // namespace
}  // namespace terrazzo
