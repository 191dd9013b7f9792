// Rules for every C++ source: ./dev format has formatted it, and it reads numbers in any locale.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

TEST(Sources, AreFormatted) {
  if (std::system("clang-format --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no clang-format";
  const std::string command =
      std::string("cd '") + TERRAZZO_SOURCE +
      "' && find graph runtime nodes tests -name '*.cpp' -print0 -o -name '*.h' -print0 | "
      "xargs -0 clang-format --dry-run -Werror";
  EXPECT_EQ(std::system(command.c_str()), 0) << "run ./dev format";
}

// The longest function at the level of a namespace. The goal is 60 lines.
TEST(Sources, HaveNoFunctionOverAHundredLines) {
  const std::regex other("^(namespace|struct|class|enum|union|extern|template) |[=;]$|= \\{$");
  int functions = 0;
  for (const char* layer : {"graph", "runtime", "nodes"})
    for (const auto& e : fs::recursive_directory_iterator(fs::path(TERRAZZO_SOURCE) / layer)) {
      if (e.path().extension() != ".h" && e.path().extension() != ".cpp") continue;
      std::ifstream in(e.path());
      int number = 0, start = 0;
      bool function = false;
      for (std::string line; std::getline(in, line);) {
        ++number;
        if (line.empty() || line[0] == '/' || line[0] == '#') continue;
        const bool outside = line[0] != ' ';
        if (outside && line[0] == '}') {
          if (function) {
            ++functions;
            EXPECT_LE(number - start + 1, 100) << e.path() << ":" << start;
          }
          function = false;
        } else if (outside) {
          start = number;
          function = !std::regex_search(line, other);
        }
      }
    }
  EXPECT_GT(functions, 2000);
}

// Options are called so, and constants kCamelCase, but for words that are read as a list: placeholder::file.
TEST(Sources, NameOptionsAndConstantsOneWay) {
  const std::regex options(R"(\b(struct|class) \w+(Settings|Choice|Config|Params)\b)");
  const std::regex constant(R"(^ *(static |inline )*constexpr [\w:<>, ]+[ *&]([a-z]\w*)( =|\[|\{))");
  const std::set<std::string> words = {"runtime/clients/cli/placeholders.h", "runtime/sweep/sweep_log.h"};
  int constants = 0;
  for (const char* layer : {"graph", "runtime", "nodes"})
    for (const auto& e : fs::recursive_directory_iterator(fs::path(TERRAZZO_SOURCE) / layer)) {
      if (e.path().extension() != ".h" && e.path().extension() != ".cpp") continue;
      const std::string name = e.path().lexically_relative(TERRAZZO_SOURCE).string();
      std::ifstream in(e.path());
      int number = 0;
      for (std::string line; std::getline(in, line); ++number) {
        EXPECT_FALSE(std::regex_search(line, options)) << name << ":" << number + 1 << ": " << line;
        if (line.find("constexpr") == std::string::npos || words.count(name)) continue;
        ++constants;
        std::smatch found;
        if (!std::regex_search(line, found, constant)) continue;
        const std::string word = found[2];
        EXPECT_TRUE(word[0] == 'k' && word.size() > 1 && std::isupper(static_cast<unsigned char>(word[1])))
            << name << ":" << number + 1 << ": " << line;
      }
    }
  EXPECT_GT(constants, 500);
}

// Files whose streams carry words, lines or binary data, but no numbers as text.
const std::set<std::string> kStreams = {"nodes/common/io/pictures/color_config.cpp",
                                        "nodes/common/io/provenance_text.cpp",
                                        "nodes/data/volume.cpp",
                                        "nodes/cooccurrence/load_strokes/svg_file.cpp",
                                        "nodes/volumes/load_volume/vdb.cpp",
                                        "nodes/volumes/render_volume/tissue.cpp",
                                        "runtime/files/base64.cpp",
                                        "runtime/clients/studio/live/past_states.cpp"};

constexpr const char* kSuspects[] = {"sto", "strto",  "atof",  "locale", "as<",
                                     "as_", "printf", "scanf", "stream"};

// A program that contains Terrazzo may have set a locale in which 1,5 is a number and 1.5 is not.
TEST(Sources, ReadNumbersInAnyLocale) {
  const std::regex forbidden(
      R"(\b(stod|stof|stold|strtod|strtof|strtold|atof|setlocale)\b)"
      R"(|(\.|->)(as<(double|float)>|as_double|as_float)|\b(sn?printf|v?s?scanf|fscanf)\(.*%[-+ #0-9.*]*l?[aefgAEFG])");
  const std::regex streams(R"(\b([io]?stringstream)\b)");
  int files = 0;
  for (const char* layer : {"graph", "runtime", "nodes"})
    for (const auto& e : fs::recursive_directory_iterator(fs::path(TERRAZZO_SOURCE) / layer)) {
      if (e.path().extension() != ".h" && e.path().extension() != ".cpp") continue;
      const std::string name = e.path().lexically_relative(TERRAZZO_SOURCE).string();
      std::ifstream in(e.path());
      int number = 0;
      for (std::string line; std::getline(in, line); ++number) {
        if (std::none_of(std::begin(kSuspects), std::end(kSuspects),
                         [&](const char* word) { return line.find(word) != std::string::npos; }))
          continue;  // regular expressions are slow
        const std::string code = line.substr(0, line.find("//"));
        EXPECT_FALSE(std::regex_search(code, forbidden))
            << name << ":" << number + 1 << ": use graph/text/read_number.h or fmt: " << line;
        EXPECT_FALSE(std::regex_search(code, streams) && !kStreams.count(name))
            << name << ":" << number + 1
            << ": numbers in streams depend on the locale; use graph/text/read_number.h or "
            << "fmt, or name the file here if it has no numbers: " << line;
      }
      ++files;
    }
  EXPECT_GT(files, 500);
}

}  // namespace
}  // namespace terrazzo
