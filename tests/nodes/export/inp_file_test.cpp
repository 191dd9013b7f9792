// Meshes of voxels for Abaqus and CalculiX.
#include "nodes/export/formats/solvers/inp_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "nodes/export/regions.h"
#include "tests/nodes/export/voxel_files.h"

namespace terrazzo {
namespace {
using namespace exporting;
using test::exported;
using test::lines_of;
namespace fs = std::filesystem;

TEST(ExportInp, CountsFacesEdgesAndCorners) {
  const fs::path file = exported("block.inp", {{"volume", Value::of(test::formula_volume())},
                                               {"particles", Value::of(test::formula_particles())}});
  std::map<std::string, std::set<long>> sets;  // node sets
  std::map<std::string, std::vector<long>> order;
  long nodes = 0, elements = 0;
  std::string keyword, name;
  for (const std::string& line : lines_of(file)) {
    if (line.starts_with("**")) continue;
    if (line.starts_with("*")) {
      keyword = line.substr(0, line.find(','));
      name = line.substr(line.rfind('=') + 1);
      continue;
    }
    nodes += keyword == "*NODE";
    elements += keyword == "*ELEMENT";
    if (keyword != "*NSET") continue;
    std::istringstream in(line);
    for (std::string word; std::getline(in, word, ',');)
      sets[name].insert(std::stol(word)), order[name].push_back(std::stol(word));
  }
  EXPECT_EQ(nodes, 7 * 6 * 5);
  EXPECT_EQ(elements, 6 * 5 * 4);
  EXPECT_EQ(sets.size(), 6u + 6 + 12 + 8);
  EXPECT_EQ(sets["SIDE_X0"].size(), 6u * 5);
  EXPECT_EQ(sets["FACE_Y1"].size(), 5u * 3);
  EXPECT_EQ(sets["EDGE_Y0_Z1"].size(), 5u);
  EXPECT_EQ(sets["EDGE_X1_Y0"].size(), 3u);
  EXPECT_EQ(sets["CORNER_111"], std::set<long>{7 * 6 * 5});
  std::set<long> border;
  std::size_t sum = 0;
  for (const auto& [set, members] : sets)
    if (!set.starts_with("SIDE")) {
      border.insert(members.begin(), members.end());
      sum += members.size();
    }
  EXPECT_EQ(sum, border.size());                                 // no node is in two of them
  EXPECT_EQ(border.size(), std::size_t{7 * 6 * 5 - 5 * 4 * 3});  // and none of the border is missing
  // Equal positions are pairs: they differ by the length of the box.
  for (const auto& [a, b, step] : {std::tuple{"FACE_X0", "FACE_X1", 6L},
                                   {"FACE_Y0", "FACE_Y1", 7L * 5},
                                   {"FACE_Z0", "FACE_Z1", 7L * 6 * 4},
                                   {"EDGE_X0_Y0", "EDGE_X1_Y1", 6L + 7 * 5}}) {
    ASSERT_EQ(order[a].size(), order[b].size());
    for (std::size_t i = 0; i < order[a].size(); ++i) EXPECT_EQ(order[b][i] - order[a][i], step) << a;
  }
}

TEST(ExportInp, EquationsHoldForEveryAffineDeformation) {
  const fs::path file = exported("block.inp", {{"volume", Value::of(test::formula_volume())}});
  const auto lines = lines_of(file.parent_path() / "block_periodic.inp");
  const Vec3i n(7, 6, 5);
  const Mat3 gradient = (Mat3() << 0.1, 0.2, -0.3, 0.4, -0.5, 0.6, 0.7, 0.8, -0.9).finished();
  const auto displacement = [&](long node) {
    const long i = node - 1;
    return Vec3(gradient * Vec3(double(i % n.x()), double(i / n.x() % n.y()), double(i / n.x() / n.y())));
  };
  std::set<std::pair<long, int>> dependent;
  std::size_t at = 0;
  while (at < lines.size() && lines[at] != "*EQUATION") ++at;
  for (++at; at < lines.size();) {
    const int terms = std::stoi(lines[at++]);
    double sum = 0;
    std::vector<double> numbers;
    while (static_cast<int>(numbers.size()) < 3 * terms) {
      std::istringstream in(lines.at(at++));
      for (std::string word; std::getline(in, word, ',');) numbers.push_back(std::stod(word));
    }
    for (int t = 0; t < terms; ++t)
      sum +=
          numbers[3 * t + 2] * displacement(std::lround(numbers[3 * t]))[std::lround(numbers[3 * t + 1]) - 1];
    EXPECT_NEAR(sum, 0, 1e-12);
    EXPECT_TRUE(dependent.insert({std::lround(numbers[0]), std::lround(numbers[1])}).second);
  }
  // All nodes of the sides X1, Y1 and Z1 but the three corners that carry the deformation.
  EXPECT_EQ(dependent.size(), 3u * (7 * 6 * 5 - 6 * 5 * 4 - 3));
}

}  // namespace
}  // namespace terrazzo
