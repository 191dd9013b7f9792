// Foreign text in messages and text files.
#include "graph/text/utf8.h"

#include <gtest/gtest.h>

#include "graph/describe.h"
#include "graph/diagnostic.h"
#include "graph/document/raw_document.h"
#include "graph/document/yaml_text.h"
#include "graph/text/element_name.h"
#include "graph/text/escape_xml.h"
#include "tests/support/arithmetic.h"

namespace terrazzo {
namespace {

TEST(PrintableText, EscapesWhatSteersATerminal) {
  EXPECT_EQ(escape_controls("a\x1b[2Kb\x7f\x01"), "a\\u001b[2Kb\\u007f\\u0001");
  EXPECT_EQ(escape_controls("\u009b2K"), "\\u009b2K");  // CSI of ISO 6429 in one character
  EXPECT_EQ(escape_controls("\u202egnp.\u202c \u2066x\u2069 \u2028"),
            "\\u202egnp.\\u202c \\u2066x\\u2069 \\u2028");
  EXPECT_EQ(escape_controls("µm, 日本, עברית 𝄞"), "µm, 日本, עברית 𝄞");
  EXPECT_EQ(escape_controls("a\n\tb\r\nc\rd"), "a\n\tb\r\nc\\u000dd");
  EXPECT_EQ(escape_controls(std::string_view("\xe9\0", 2)), "\uFFFD\\u0000");
  EXPECT_EQ(escape_line("a\n\tb\r\n"), "a\\u000a\\u0009b\\u000d\\u000a");
  EXPECT_EQ(printable(" a \n\n b\x1b"), "a b\\u001b");
  EXPECT_EQ(printable(std::string(300, 'x')), std::string(200, 'x') + "...");
  EXPECT_EQ(printable(std::string(300, 'x'), std::string::npos), std::string(300, 'x'));
}

TEST(PrintableText, OfADiagnosticIsOneLine) {
  const Diagnostic d{
      Severity::Error, "bad-value", "'x\nerror: no, \x1b[1A' is wrong", "write\x07 y", {"a\nb.yaml", 3, 0},
      "n\x1b",         "p"};
  EXPECT_EQ(d.text(),
            "a\\u000ab.yaml:3: error: n\\u001b.p: 'x error: no, \\u001b[1A' is wrong (write\\u0007 y)");
}

TEST(PrintableText, NodeNamesAndOutputFilesHaveNoControlCharacters) {
  for (const char* name : {"a\nb", "a\x1b[2Kb", "a\tb", "a\u202eb", "a\u0085"})
    EXPECT_FALSE(is_node_name(name));
  for (const char* name : {"größe", "日本", "a[1]"}) EXPECT_TRUE(is_node_name(name));
  const Parameter path = Parameter::output_path("path");
  std::string why;
  EXPECT_TRUE(read_parameter(path, {false, {"a b/größe.png"}, {}}, why));
  EXPECT_FALSE(read_parameter(path, {false, {"a\n\"b.obj"}, {}}, why));
  EXPECT_NE(why.find("control characters"), std::string::npos) << why;
}

TEST(PrintableText, OfOtherFormatsStaysInItsQuotes) {
  EXPECT_EQ(escape_xml("<a\x1b&\u202e\">"), "&lt;a\\u001b&amp;\\u202e&quot;&gt;");
  EXPECT_EQ(yaml_word("a\u202eb\x1b"), "\"a\\u202eb\\u001b\"");
  EXPECT_EQ(read_written(yaml_word("a\u202eb\x1b\r\n")).text(), "a\u202eb\x1b\r\n");
  const Graph g = test::graph_of("nodes:\n  'a\"];x[\"<b>#\\': {type: Constant}\n");
  EXPECT_NE(draw_dot(g).find("[label=\"a\\\"];x[\\\"<b>#\\\\\\nConstant\"]"), std::string::npos)
      << draw_dot(g);
  EXPECT_NE(draw_mermaid(g).find("[\"a#quot;];x[#quot;&lt;b&gt;#35;\\<br/><i>Constant</i>\"]"),
            std::string::npos)
      << draw_mermaid(g);
}

}  // namespace
}  // namespace terrazzo
