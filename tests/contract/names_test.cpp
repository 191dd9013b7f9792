// Two types with the same name in one namespace link silently and crash at run time, so no two headers may
// define the same type.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

TEST(Names, NoTwoHeadersDefineOneType) {
  const std::regex definition("^(?:struct|class) ([A-Z][A-Za-z0-9]*)(?: final)?(?: :[^:].*)? \\{");
  const std::regex opening("^namespace (terrazzo[a-z0-9_:]*) \\{");
  std::map<std::string, std::string> where;
  for (const auto* layer : {"graph", "runtime", "nodes"})
    for (const auto& e : fs::recursive_directory_iterator(fs::path(TERRAZZO_SOURCE) / layer)) {
      if (e.path().extension() != ".h") continue;
      std::ifstream in(e.path());
      std::smatch match;
      std::string space;
      for (std::string line; std::getline(in, line);)
        if (std::regex_search(line, match, opening)) {
          space = match[1];
        } else if (std::regex_search(line, match, definition)) {
          const std::string name = space + "::" + match[1].str();
          const auto [it, fresh] = where.emplace(name, e.path().string());
          EXPECT_TRUE(fresh) << name << " is defined in " << it->second << " and in " << e.path();
        }
    }
  EXPECT_GT(where.size(), 50u);
}

}  // namespace
}  // namespace terrazzo
