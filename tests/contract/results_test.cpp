// docs/results.md repeats numbers of the pages below docs/results/. A number that is measured again must
// change in both, so every number of a claim must stand in the section that the claim links to.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "runtime/files.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

// The anchor that GitHub gives a heading: lower case, without punctuation, blanks as hyphens.
std::string anchor_of(const std::string& heading) {
  std::string out;
  for (const char c : heading)
    if (c == ' ')
      out += '-';
    else if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_')
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

// The sections of a page by anchor, each with its subsections; the whole page is under "".
std::map<std::string, std::string> sections_of(const std::string& page) {
  std::map<std::string, std::string> out{{"", page}};
  std::vector<std::pair<std::size_t, std::string>> open;  // level and anchor
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t level = line.find_first_not_of('#');
    if (level != 0 && level != std::string::npos && line[level] == ' ') {
      while (!open.empty() && open.back().first >= level) open.pop_back();
      open.emplace_back(level, anchor_of(line.substr(level + 1)));
    }
    for (const auto& [depth, anchor] : open) out[anchor] += line + "\n";
  }
  return out;
}

struct Link {
  std::string page, anchor;
};

std::vector<Link> links_of(const std::string& text) {
  static const std::regex link(R"(\]\((results/[a-z0-9-]+\.md)(?:#([^)]*))?\))");
  std::vector<Link> out;
  for (std::sregex_iterator it(text.begin(), text.end(), link), end; it != end; ++it)
    out.push_back({(*it)[1], (*it)[2]});
  return out;
}

// Numbers with their thousands separators, such as 12,000; without those in code and in the targets of links.
std::vector<std::string> numbers_of(const std::string& text) {
  static const std::regex code("`[^`]*`"), target(R"(\]\([^)]*\))"),
      number(R"((?:^|[^A-Za-z0-9_.])(\d+(?:,\d{3})*(?:\.\d+)?))");
  const std::string prose = std::regex_replace(std::regex_replace(text, code, " "), target, "]");
  std::vector<std::string> out;
  for (std::sregex_iterator it(prose.begin(), prose.end(), number), end; it != end; ++it)
    out.push_back((*it)[1]);
  return out;
}

struct Claim {
  std::string text;
  std::vector<Link> links;
};

std::vector<std::string> cells_of(const std::string& row) {
  std::vector<std::string> out;
  for (std::size_t from = 2, to; (to = row.find(" |", from)) != std::string::npos; from = to + 3)
    out.push_back(row.substr(from, to - from));
  return out;
}

// The column "ours" of each row of the table, whose row without a link goes with the one above, and each item
// of "What fell short", which also goes with the pages that its heading links to.
std::vector<Claim> claims_of(const std::string& summary) {
  std::vector<Claim> out;
  std::vector<Link> row, heading;
  std::istringstream lines(summary);
  bool item = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| ", 0) == 0 && line.rfind("| claim", 0) != 0) {
      if (const auto links = links_of(line); !links.empty()) row = links;
      out.push_back({cells_of(line).at(1), row});
    } else if (line.rfind("**", 0) == 0) {
      heading = links_of(line);
    } else if (line.rfind("- ", 0) == 0) {
      out.push_back({line, heading});
    } else if (item && line.rfind("  ", 0) == 0) {
      out.back().text += line;
    }
    item = line.rfind("- ", 0) == 0 || (item && line.rfind("  ", 0) == 0);
    if (line.rfind("- ", 0) == 0 || item)
      for (const Link& link : links_of(line)) out.back().links.push_back(link);
  }
  return out;
}

TEST(Results, EveryNumberOfTheSummaryStandsInItsSection) {
  const fs::path docs = fs::path(TERRAZZO_SOURCE) / "docs";
  std::map<std::string, std::map<std::string, std::string>> pages;
  std::size_t checked = 0;
  for (const Claim& claim : claims_of(read_file(docs / "results.md").value_or(""))) {
    EXPECT_FALSE(claim.links.empty()) << claim.text;
    std::set<std::string> measured;
    for (const Link& link : claim.links) {
      if (!pages.count(link.page)) pages[link.page] = sections_of(read_file(docs / link.page).value_or(""));
      const auto section = pages[link.page].find(link.anchor);
      ASSERT_NE(section, pages[link.page].end()) << link.page << "#" << link.anchor;
      std::string text = section->second;
      std::erase(text, '`');  // a number may be part of a command there
      for (const auto& number : numbers_of(text)) measured.insert(number);
    }
    for (const auto& number : numbers_of(claim.text)) {
      EXPECT_TRUE(measured.count(number))
          << number << " is not in the section that is linked: " << claim.text;
      ++checked;
    }
  }
  EXPECT_GT(checked, 100u);
}

TEST(Results, TheCheckSeesADifferentNumber) {
  const auto claims = claims_of(
      "| claim | ours | peer | command |\n|---|---|---|---|\n"
      "| [A](results/a.md#some-part), time | 12,000 s at `--n 3` | 7 | x |\n| The same | 0.5 % | | x |\n\n"
      "**B** ([page](results/b.md))\n\n- It takes 4.2 s,\n  goal 9 s ([c](results/c.md)).\n\nEnd 8\n");
  ASSERT_EQ(claims.size(), 3u);
  EXPECT_EQ(numbers_of(claims[0].text), std::vector<std::string>{"12,000"});
  EXPECT_EQ(claims[1].links.at(0).anchor, "some-part");
  EXPECT_EQ(numbers_of(claims[2].text), (std::vector<std::string>{"4.2", "9"}));
  EXPECT_EQ(claims[2].links.size(), 2u);
  const auto sections = sections_of("# Page\n1\n## Some part\n12,000\n### Below\n5\n## Other\n6\n");
  EXPECT_EQ(numbers_of(sections.at("some-part")), (std::vector<std::string>{"12,000", "5"}));
}

}  // namespace
}  // namespace terrazzo
