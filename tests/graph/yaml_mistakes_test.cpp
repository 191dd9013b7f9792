// Common mistakes in YAML, and numbers in the locale of a host program.
#include <gtest/gtest.h>

#include "graph/document/raw_document.h"
#include "tests/support/german_locale.h"

namespace terrazzo {
namespace {

// The first message of a document, as "line:column: message (hint)".
std::string first_message(const std::string& text) {
  Diagnostics found;
  read_document("terrazzo: 1\n" + text, "g.yaml", found);
  if (found.empty()) return "";
  const Diagnostic& d = found[0];
  return std::to_string(d.place.line) + ":" + std::to_string(d.place.column) + ": " + d.message +
         (d.hint.empty() ? "" : " (" + d.hint + ")");
}

TEST(YamlMistakes, ATabIsNamed) {
  const std::string tab = "a tab indents this line, which YAML does not allow (indent with spaces)";
  EXPECT_EQ(first_message("nodes:\n\ta: {type: Constant}\n"), "3:1: " + tab);
  EXPECT_EQ(first_message("nodes:\n  a:\n  \ttype: Constant\n"), "4:3: " + tab);
  EXPECT_EQ(first_message("nodes:\n  a:\n    type: Constant\n\t\tparams: {value: 1}\n"), "5:1: " + tab);
  // Elsewhere a tab separates words.
  EXPECT_EQ(first_message("nodes:\n  a:\t{type:\tConstant}\t# x\n"), "");
  EXPECT_EQ(first_message("doc: |\n  two lines\n  \tthe second with a tab\nnodes:\n  a: {type: Constant}\n"),
            "");
}

TEST(YamlMistakes, AColorWithoutQuotesIsNamed) {
  const std::string comment = "YAML reads '#c0b8a8' as a comment (put it in quotes: \"#c0b8a8\")";
  EXPECT_EQ(
      first_message("nodes:\n  a:\n    type: Constant\n    params:\n      color: #c0b8a8\n      value: 1\n"),
      "6:14: " + comment);
  EXPECT_EQ(
      first_message(
          "nodes:\n  a:\n    type: Constant\n    params:\n      colors:\n        - #c0b8a8\n        - x\n"),
      "7:11: " + comment);
  EXPECT_EQ(first_message("nodes:\n  a: {type: Constant, params: {color: #c0b8a8, value: 1}}\n"),
            "3:39: " + comment);
  EXPECT_EQ(first_message("nodes:\n  a: {type: Constant, params: {colors: [#c0b8a8, #fff]}}\n"),
            "3:41: " + comment);
  EXPECT_EQ(first_message("nodes:\n  a: {type: Constant, params: {colors: ['#000000', #c0b8a8]}}\n"),
            "3:52: " + comment);
  EXPECT_EQ(
      first_message(
          "parameters:\n  c: {type: color, default: '#fff'} #c0b8a8\nnodes:\n  a: {type: Constant} # fff\n"),
      "");
  EXPECT_EQ(first_message("nodes:\n  a:\n    type: Constant\n    params:\n      value:\n"),
            "6:7: 'value' must be a value or a list of values");
}

TEST(YamlMistakes, OnTheCommandLineToo) {
  EXPECT_EQ(read_written("#c0b8a8").text(), "#c0b8a8");
  try {
    read_written("[#c0b8a8, #ffffff]");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(e.diagnostic().hint.find("quotes"), std::string::npos);
  }
}

TEST(YamlMistakes, NumbersDoNotDependOnTheLocale) {
  const test::GermanLocale german;
  Diagnostics found;
  const RawDocument doc = read_document(
      "terrazzo: 1\nparameters: {p: {type: number, default: 1.5, min: 0.25, max: 1234.5}}\nnodes: {}\n",
      "g.yaml", found);
  ASSERT_TRUE(found.empty()) << found[0].text();
  EXPECT_EQ(doc.parameters.at(0).declaration.min, 0.25);
  EXPECT_EQ(doc.parameters.at(0).declaration.max, 1234.5);
}

}  // namespace
}  // namespace terrazzo
