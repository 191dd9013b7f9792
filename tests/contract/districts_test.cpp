// The districts of nodes/: which folder may include which, and whose namespace a folder's names are in
// (docs/decisions/0030).
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "runtime/files.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

// The districts in the order in which the data passes. A file may include its own folder, the libraries of
// its district, and earlier districts. Never another node.
const std::vector<std::string> kDistricts = {"data",         "common",  "photograph", "sizes",  "shapes",
                                             "packing",      "color",   "solids",     "media",  "detail",
                                             "cooccurrence", "volumes", "properties", "bodies", "textures",
                                             "compare",      "study",   "export"};

// Libraries of districts, by level. A library may include those of lower levels in its district.
const std::map<std::string, int> kLibraries = {
    {"common/geometry", 0},  {"common/texture", 1},    {"common/stereology", 2},
    {"common/plot", 2},      {"common/statistics", 2}, {"common/io", 2},
    {"common/gl", 2},        {"photograph/marks", 0},  {"sizes/unfolding", 0},
    {"packing/rigid", 0},    {"packing/cells", 1},     {"packing/deposit", 1},
    {"solids/synthesis", 0}, {"solids/patch_fill", 1}, {"media/micrograph", 0},
    {"media/annealing", 1},  {"detail/residual", 0},   {"cooccurrence/strokes", 0},
    {"volumes/blocks", 0},   {"bodies/carving", 0},    {"bodies/cutting", 0},
    {"textures/relief", 0}};
const int kNode = 2, kProgram = 3;  // levels of node folders, and of programs that use them
// Within solids/synthesis. The files at its top have the last level.
const std::map<std::string, int> kSynthesis = {{"options", 0}, {"exemplar", 1},  {"matching", 2},
                                               {"whole", 3},   {"blockwise", 4}, {"reference_2011", 4}};

struct Place {
  std::string district, name, inner;
  int level = 0;
};

// Of a path relative to nodes/, such as sizes/unfold/figure.h.
Place place_of(const fs::path& path) {
  Place place;
  auto part = path.begin();
  place.district = part->string();
  const bool in_folder = std::distance(path.begin(), path.end()) > 2;
  place.name = in_folder ? place.district + "/" + std::next(part)->string() : place.district;
  const auto library = kLibraries.find(place.name);
  place.level = library == kLibraries.end() ? kNode : library->second;
  if (std::distance(path.begin(), path.end()) > 3) place.inner = std::next(path.begin(), 2)->string();
  if (path.string().find("/training/") != std::string::npos) place.level = kProgram;
  return place;
}

bool may_include(const Place& place, const Place& other) {
  if (place.district != other.district) {
    const auto at = [](const std::string& district) {
      return std::find(kDistricts.begin(), kDistricts.end(), district) - kDistricts.begin();
    };
    const bool shared =
        other.district == "data" || other.district == "common" || kLibraries.count(other.name);
    return shared && at(other.district) < at(place.district);
  }
  if (place.name == "solids/synthesis" && place.name == other.name && place.inner != other.inner)
    return place.inner.empty() ||
           (!other.inner.empty() && kSynthesis.at(other.inner) < kSynthesis.at(place.inner));
  return place.name == other.name || place.district == "export" || other.level < place.level;
}

TEST(Districts, NoIncludePointsUpOrAcross) {
  const fs::path nodes = fs::path(TERRAZZO_SOURCE) / "nodes";
  const std::regex include("#include \"nodes/([^\"]+/[^\"]+)\"");
  int includes = 0;
  for (const auto& e : fs::recursive_directory_iterator(nodes)) {
    if (e.path().extension() != ".h" && e.path().extension() != ".cpp") continue;
    const fs::path path = e.path().lexically_relative(nodes);
    if (!path.has_parent_path()) continue;  // register_nodes.h, above all districts
    const Place place = place_of(path);
    ASSERT_TRUE(std::count(kDistricts.begin(), kDistricts.end(), place.district))
        << path << " is in no district";
    const std::string text = read_file(e.path()).value_or("");
    for (std::sregex_iterator it(text.begin(), text.end(), include), end; it != end; ++it, ++includes)
      EXPECT_TRUE(may_include(place, place_of(fs::path((*it)[1])))) << path << " includes " << (*it)[1];
  }
  EXPECT_GT(includes, 500);
}

TEST(Districts, NoFolderHoldsMoreThanFortyFiles) {
  std::map<fs::path, int> files;
  for (const char* layer : {"graph", "runtime", "nodes"})
    for (const auto& e : fs::recursive_directory_iterator(fs::path(TERRAZZO_SOURCE) / layer))
      if (e.path().extension() == ".h" || e.path().extension() == ".cpp") ++files[e.path().parent_path()];
  EXPECT_GT(files.size(), 80u);
  for (const auto& [folder, count] : files) EXPECT_LE(count, 40) << folder;
}

TEST(Districts, EveryDistrictHasAReadme) {
  for (const auto& district : kDistricts)
    EXPECT_TRUE(fs::exists(fs::path(TERRAZZO_SOURCE) / "nodes" / district / "README.md")) << district;
}

// The folder of the node that a file belongs to, or "" in a library.
fs::path node_of(fs::path file) {
  for (fs::path folder = file.parent_path(); folder.filename() != "nodes"; folder = folder.parent_path())
    if (fs::exists(folder / "node.cpp")) return folder;
  return {};
}

TEST(Districts, EveryNodeFolderHasItsOwnNamespace) {
  const fs::path nodes = fs::path(TERRAZZO_SOURCE) / "nodes";
  const std::regex opening("^namespace (terrazzo[a-z0-9_:]*) \\{", std::regex::multiline);
  int files = 0;
  for (const auto& e : fs::recursive_directory_iterator(nodes)) {
    if (e.path().extension() != ".h" || node_of(e.path()).empty()) continue;
    const std::string folder = node_of(e.path()).filename();
    const std::string text = read_file(e.path()).value_or(""),
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
