// The manual page. What it must list is taken from the program's help.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <sstream>

#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

std::string manual_roff() {
  const auto run = test::run_program({"manual"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run.out;
}

// The manual without fonts and escapes.
std::string manual_as_text() {
  std::string text = std::regex_replace(manual_roff(), std::regex(R"(\\f[BIR])"), "");
  return std::regex_replace(text, std::regex(R"(\\-)"), "-");
}

struct Help {
  std::vector<std::string> options, commands;
};

Help help_of(std::vector<std::string> words) {
  words.push_back("--help");
  Help help;
  bool commands = false;
  std::istringstream in(test::run_program(words).out);
  for (std::string line; std::getline(in, line);) {
    commands |= line == "Subcommands:";
    std::smatch found;
    if (commands && std::regex_search(line, found, std::regex("^  ([a-z]+)")))
      help.commands.push_back(found[1]);
    else if (std::regex_search(line, found, std::regex("^  (?:-[a-z],)?(--[a-z-]+)")))
      help.options.push_back(found[1]);
  }
  return help;
}

// Calls `check` for every command that has no subcommands.
void for_each_command(const std::vector<std::string>& words,
                      const std::function<void(const std::vector<std::string>&, const Help&)>& check) {
  const Help help = help_of(words);
  if (help.commands.empty()) check(words, help);
  for (const auto& command : help.commands) {
    auto inner = words;
    inner.push_back(command);
    for_each_command(inner, check);
  }
}

TEST(Manual, ListsEveryCommandWithItsOptions) {
  const std::string text = manual_as_text();
  int commands = 0, options = 0;
  for_each_command({}, [&](const std::vector<std::string>& words, const Help& help) {
    std::string name = "terrazzo";
    for (const auto& w : words) name += " " + w;
    const auto start = text.find(".SS " + name);
    ASSERT_NE(start, std::string::npos) << name;
    const std::string section = text.substr(start, text.find("\n.S", start) - start);
    for (const auto& option : help.options) {
      if (option == "--help") continue;
      EXPECT_TRUE(std::regex_search(section, std::regex("\n(-[a-z], )?" + option + "[ \n]")))
          << name << ' ' << option;
      ++options;
    }
    ++commands;
  });
  EXPECT_GT(commands, 10);
  EXPECT_GT(options, 50);
  EXPECT_NE(text.find("\n--version\n"), std::string::npos);
  EXPECT_EQ(text.find("terrazzo complete "), std::string::npos);
}

TEST(Manual, CompletionOffersWhatHelpLists) {
  for_each_command({}, [&](const std::vector<std::string>& words, const Help& help) {
    std::vector<std::string> complete = {"complete", "--"};
    complete.insert(complete.end(), words.begin(), words.end());
    complete.push_back("--");
    std::string expected;
    for (const auto& option : help.options) expected += option + "\n";
    EXPECT_EQ(test::run_program(complete).out, expected) << words.back();
  });
}

TEST(Manual, ListsEveryEnvironmentVariableThatTheProgramReads) {
  const std::string text = manual_as_text();
  int variables = 0;
  for (const char* layer : {"graph", "runtime", "nodes"})
    for (const auto& file : fs::recursive_directory_iterator(test::source_folder() / layer)) {
      const std::string source = read_file(file.path()).value_or("");
      const std::regex read("getenv\\(\"([A-Z_]+)\"\\)");
      for (std::sregex_iterator it(source.begin(), source.end(), read), end; it != end; ++it, ++variables)
        EXPECT_NE(text.find("\n" + (*it)[1].str() + "\n"), std::string::npos) << (*it)[1];
    }
  EXPECT_GT(variables, 3);
}

// Without escapes, roff reads "-" as a hyphen, and a leading "." as a request.
TEST(Manual, EscapesText) {
  const std::string roff = manual_roff();
  EXPECT_TRUE(
      std::all_of(roff.begin(), roff.end(), [](char c) { return c == '\n' || (c >= ' ' && c < 127); }));
  EXPECT_FALSE(std::regex_search(roff, std::regex(R"([^\\]-)")));
  std::istringstream in(roff);
  for (std::string line; std::getline(in, line);)
    if (!line.empty() && (line[0] == '.' || line[0] == '\'')) {
      EXPECT_TRUE(std::regex_search(line, std::regex(R"(^\.(TH|SH|SS|TP|PP|RS|RE|nf|fi|br)\b)"))) << line;
    }
}

TEST(Manual, GroffRendersItWithoutWarnings) {
  const fs::path file = test::temporary_folder() / "terrazzo.1";
  std::ofstream(file) << manual_roff();
  const auto run = test::run_command({"groff", "-man", "-Tutf8", "-ww", file.string()});
  if (run.exit_code == 98) GTEST_SKIP() << "groff is not installed";
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.err, "");
  EXPECT_NE(run.out.find("NODE.PARAM=VALUE"), std::string::npos);
}

}  // namespace
}  // namespace terrazzo
