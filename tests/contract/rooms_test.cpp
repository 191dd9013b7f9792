// The rooms of nodes/: which folder may include which, and whose namespace a folder's names are in
// (docs/decisions/0009).
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

std::string content(const fs::path& file) {
  std::ostringstream out;
  out << std::ifstream(file).rdbuf();
  return out.str();
}

// Rooms by level. A file may include its own room and rooms of lower levels. Node folders have level 11.
const std::map<std::string, int> kLevel = {{"data", 0},
                                           {"common/geometry", 1},
                                           {"common/texture", 2},
                                           {"common/stereology", 3},
                                           {"common/plot", 3},
                                           {"common/statistics", 3},
                                           {"common/io", 3},
                                           {"common/gl", 3},
                                           {"blocks", 4},
                                           {"solids/settings", 4},
                                           {"solids/exemplar", 5},
                                           {"solids/matching", 6},
                                           {"solids/whole", 7},
                                           {"solids/blockwise", 8},
                                           {"solids/reference_2011", 8},
                                           {"solids", 8},
                                           {"unfolding", 8},
                                           {"packing", 8},
                                           {"patch_fill", 9},
                                           {"tessellation", 9},
                                           {"residual", 9},
                                           {"carving", 10},
                                           {"segment/training", 12}};  // a program, not a node

std::string room_of(const std::string& path) {  // relative to nodes/
  for (const auto depth : {2, 1}) {
    std::string room;
    std::istringstream parts(path);
    std::string part;
    for (int i = 0; i < depth && std::getline(parts, part, '/'); ++i) room += (i ? "/" : "") + part;
    if (kLevel.count(room)) return room;
    if (depth == 1) return room;
  }
  return {};
}

int level_of(const std::string& room) {
  const auto it = kLevel.find(room);
  return it == kLevel.end() ? 11 : it->second;
}

TEST(Rooms, NoIncludePointsUpOrAcross) {
  const fs::path nodes = fs::path(TERRAZZO_SOURCE) / "nodes";
  const std::regex include("#include \"nodes/([^\"]+/[^\"]+)\"");
  int includes = 0;
  for (const auto& e : fs::recursive_directory_iterator(nodes)) {
    if (e.path().extension() != ".h" && e.path().extension() != ".cpp") continue;
    const std::string path = e.path().lexically_relative(nodes).string(), room = room_of(path);
    const std::string text = content(e.path());
    for (std::sregex_iterator it(text.begin(), text.end(), include), end; it != end; ++it) {
      const std::string other = room_of((*it)[1]);
      ++includes;
      if (other == room || (room == "solids" && other.rfind("solids/", 0) == 0)) continue;
      EXPECT_LT(level_of(other), level_of(room)) << path << " includes " << (*it)[1];
    }
  }
  EXPECT_GT(includes, 500);
}

TEST(Rooms, EveryNodeFolderHasItsOwnNamespace) {
  const fs::path nodes = fs::path(TERRAZZO_SOURCE) / "nodes";
  const std::regex opening("^namespace (terrazzo[a-z0-9_:]*) \\{", std::regex::multiline);
  int files = 0;
  for (const auto& e : fs::recursive_directory_iterator(nodes)) {
    const std::string folder = e.path().parent_path().filename();
    if (e.path().extension() != ".h" || !fs::exists(e.path().parent_path() / "node.cpp")) continue;
    const std::string text = content(e.path()),
                      own = "terrazzo::" + (folder == "export" ? "exporting" : folder);
    std::set<std::string> spaces;
    for (std::sregex_iterator it(text.begin(), text.end(), opening), end; it != end; ++it)
      spaces.insert((*it)[1]);
    spaces.erase("terrazzo");  // for forward declarations of shared types
    EXPECT_EQ(spaces, std::set<std::string>{own}) << e.path();
    ++files;
  }
  EXPECT_GT(files, 100);
}

}  // namespace
}  // namespace terrazzo
