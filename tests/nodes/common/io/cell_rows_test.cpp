#include "nodes/common/io/cell_rows.h"

#include <gtest/gtest.h>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace {

// Every row as "LINE:cell|cell", quoted cells in quotes.
std::vector<std::string> rows_of(const std::string& text, CellFormat format = {}) {
  CellReader reader(text, "t.csv", std::move(format));
  std::vector<std::string> out;
  for (CellRow row; reader.next(row);) {
    std::string line;
    for (const auto& c : row.cells)
      line +=
          (line.empty() ? std::to_string(row.line) + ":" : "|") + (c.quoted ? '"' + c.text + '"' : c.text);
    out.push_back(line);
  }
  return out;
}
using Rows = std::vector<std::string>;

TEST(CellRows, TheFirstRowNamesTheSeparator) {
  EXPECT_EQ(rows_of("a,b\n1,2\n"), (Rows{"1:a|b", "2:1|2"}));
  EXPECT_EQ(rows_of("a;b,c\n1,5;2\n"), (Rows{"1:a|b,c", "2:1,5|2"}));
  EXPECT_EQ(rows_of("\xef\xbb\xbf\n a\tb;c \r\n\r\n1\t"), (Rows{"2:a|b;c", "4:1|"}));
  EXPECT_EQ(rows_of("a b\n"), (Rows{"1:a b"}));
  EXPECT_EQ(rows_of(""), Rows{});
  EXPECT_EQ(rows_of("\n \r\n"), Rows{});
}

TEST(CellRows, BlanksSeparateWhereAsked) {
  const CellFormat format{.separators = "\t;, "};
  EXPECT_EQ(rows_of("  a  b\n 1 \t 2 \n", format), (Rows{"1:a|b", "2:1|2"}));
  EXPECT_EQ(rows_of("a b,c\n1, 2\n", format), (Rows{"1:a b|c", "2:1|2"}));
  EXPECT_EQ(rows_of("\"a b\" \"\"\n", format), (Rows{"1:\"a b\"|\"\""}));
}

// "Area (µm²)" is one column where rows have one number, and two where they have two.
TEST(CellRows, RowsTellWhetherBlanksInTheHeaderSeparate) {
  const CellFormat format{.separators = "\t;, "};
  EXPECT_EQ(rows_of("Area (µm²)\n1.5\n2\n", format), (Rows{"1:Area (µm²)", "2:1.5", "3:2"}));
  EXPECT_EQ(rows_of("Area (µm²)\n1,5\n2\n", format), (Rows{"1:Area (µm²)", "2:1,5", "3:2"}));
  EXPECT_EQ(rows_of("Area Mean\n1 2\n", format), (Rows{"1:Area|Mean", "2:1|2"}));
  EXPECT_EQ(rows_of("Area Mean\n1 2 3\n", format), (Rows{"1:Area|Mean", "2:1|2|3"}));  // a number of the row
}

TEST(CellRows, TheSeparatorDividesHeaderAndRowsAlike) {
  EXPECT_EQ(rows_of("a;b,c\n1,2\n"), (Rows{"1:a;b|c", "2:1|2"}));
  EXPECT_EQ(rows_of("\"Area; µm²\",Mean\n1,2\n"), (Rows{"1:\"Area; µm²\"|Mean", "2:1|2"}));
  EXPECT_EQ(rows_of("\"Area, µm²\"\n1,5\n"), (Rows{"1:\"Area, µm²\"", "2:1,5"}));
  EXPECT_EQ(rows_of("sep=;\na,b;c\n1;2\n"), (Rows{"2:a,b|c", "3:1|2"}));
}

TEST(CellRows, LinesEndInThreeWays) {
  const Rows expected{"1:a|b", "3:1|2", "4:\"x\n\"|3", "6:4|5"};
  EXPECT_EQ(rows_of("a,b\n\n1,2\n\"x\n\",3\n4,5\n"), expected);
  EXPECT_EQ(rows_of("a,b\r\r1,2\r\"x\n\",3\r4,5"), expected);
  EXPECT_EQ(rows_of("a,b\r\n\r\n1,2\r\n\"x\n\",3\r\n4,5\r\n"), expected);
  EXPECT_EQ(rows_of("a\n\"x\r\ny\rz\"\nb\n"), (Rows{"1:a", "2:\"x\r\ny\rz\"", "5:b"}));
}

TEST(CellRows, QuotesMayContainEverything) {
  EXPECT_EQ(rows_of("x,y\n\"a,\n\"\"b\"\"\" ,c\nd,\"\"\n"), (Rows{"1:x|y", "2:\"a,\n\"b\"\"|c", "4:d|\"\""}));
  EXPECT_EQ(rows_of("5\" pipe,2\n"), (Rows{"1:5\" pipe|2"}));  // quotes count only at the start of a cell
}

TEST(CellRows, CommentsAreSkippedWhereAsked) {
  EXPECT_EQ(rows_of("# one\na\n #two\nb\n", {.comments = true}), (Rows{"2:a", "4:b"}));
  EXPECT_EQ(rows_of("# one\na\n"), (Rows{"1:# one", "2:a"}));
}

TEST(CellRows, NumbersFillTheirCells) {
  EXPECT_EQ(cell_number("1.5", false), 1.5);
  EXPECT_EQ(cell_number("+2e3", false), 2000);
  EXPECT_EQ(cell_number("1,5", true), 1.5);
  for (const char* text : {"", "+", "+-1", "1,5", "1 ", "1.5.2", "1e999", "x"})
    EXPECT_FALSE(cell_number(text, false)) << text;
  for (const char* text : {"1,234.5", "1,2,3"}) EXPECT_FALSE(cell_number(text, true)) << text;
}

TEST(CellRows, ErrorsNameFileLineAndParameter) {
  const auto diagnostic = [](const std::string& text) {
    try {
      CellReader reader(text, "t.csv", {.parameter = "key"});
      for (CellRow row; reader.next(row);) reader.require_cells(row, 2);
    } catch (const Error& e) {
      return e.diagnostic();
    }
    return Diagnostic{};
  };
  const Diagnostic short_row = diagnostic("a,b\n\n1\n");
  EXPECT_EQ(short_row.code, "malformed-row");
  EXPECT_EQ(short_row.message, "t.csv:3: 1 cells; 2 are expected");
  EXPECT_EQ(short_row.hint, "correct or remove the row");
  EXPECT_EQ(short_row.parameter, "key");
  EXPECT_EQ(diagnostic("a,b\n1,\"2\n3").message, "t.csv:2: a quotation mark is not closed");
}

}  // namespace
}  // namespace terrazzo
