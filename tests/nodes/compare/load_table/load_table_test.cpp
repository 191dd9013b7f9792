#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "nodes/compare/load_table/read_table.h"
#include "runtime/json_text.h"
#include "tests/support/code_of.h"
#include "tests/support/stored_values.h"

namespace terrazzo {
namespace {
using namespace load_table;
using Cell = Table::Cell;
using Row = std::vector<Cell>;

Table mixed() {
  Table t;
  t.columns = {"area mm²", "", "a,b"};
  t.rows = {
      {0.1 + 0.2, Cell("1.5"), Cell("")}, {-0.0, Cell(" x\n\"y\""), std::nan("")}, {5e-324, 1e300, 3.0}};
  return t;
}

TEST(LoadTable, GivesWhatExportWroteToJson) {
  for (const Table& t : {mixed(), Table{}, Table{{"a"}, {}}}) {
    const auto run = test::run_node("LoadTable", {}, {{"path", test::exported_json(t)}});
    EXPECT_EQ(test::bytes_of(run.output<Table>("table")), test::bytes_of(t));
    EXPECT_EQ(run.metrics.at("rows"), t.rows.size());
  }
}

TEST(LoadTable, GivesWhatExportWroteToCsv) {
  Table t = mixed();
  t.rows[0][1] = 1.5;  // the text "1.5" would come back as a number
  t.rows[2][2] = -std::numeric_limits<double>::infinity();
  const auto folder = test::temporary_folder();
  test::run_node("Export", {{"table", Value::of(t)}}, {{"path", "a.csv"}}, folder);
  const auto run = test::run_node("LoadTable", {}, {{"path", (folder / "a.csv").string()}});
  EXPECT_EQ(test::bytes_of(run.output<Table>("table")), test::bytes_of(t));
}

TEST(LoadTable, TheWaysThatProgramsWrite) {
  const auto rows = [](const std::string& text) { return read_csv(text, "t.csv").rows; };
  const std::vector<Row> expected = {{1.5, Cell("a b")}, {-20.0, Cell("")}};
  EXPECT_EQ(rows("x,y\n1.5,a b\n-20,\n"), expected);
  EXPECT_EQ(rows("\xef\xbb\xbfx;y\r\n1,5;\"a b\"\r\n-2e1; \r\n"), expected);  // decimal commas
  EXPECT_EQ(rows("\n\"x\"\t\"y\"\n\n 1.5 \ta b\n-20\t\"\"\n  \n"), expected);
  EXPECT_EQ(rows("x,y\n+1.5,a b\n-20,"), expected);
  const std::vector<Row> quoted = {{Cell("1"), Cell("a,\n\"b\"")}, {Cell("1.5.2"), Cell("+-1")}};
  EXPECT_EQ(rows("x,y\n\"1\" ,\"a,\n\"\"b\"\"\"\n1.5.2,+-1\n"), quoted);
  EXPECT_EQ(read_csv("a b\n", "t.csv").columns, std::vector<std::string>{"a b"});
}

TEST(LoadTable, MalformedRowsAreNamed) {
  const auto message = [](const std::string& text) {
    try {
      read_csv(text, "t.csv");
    } catch (const Error& e) {
      return e.diagnostic().code + " " + e.diagnostic().message;
    }
    return std::string();
  };
  EXPECT_EQ(message("x,y\n\"a\nb\",1\n\n1\n"), "malformed-row t.csv:5: 1 cells; 2 are expected");
  EXPECT_EQ(message("x,y\n1,2,3\n"), "malformed-row t.csv:2: 3 cells; 2 are expected");
  EXPECT_EQ(message("x,y\n1,\"2\n"), "malformed-row t.csv:2: a quotation mark is not closed");
  EXPECT_EQ(message(" \n").substr(0, 9), "no-column");
}

TEST(LoadTable, WrongJsonIsNamed) {
  const auto code = [](const std::string& text) { return test::code_of([&] { read_json(text, "t.json"); }); };
  EXPECT_EQ(code("{\"columns\":[\"a\"],\"rows\":[[1]]}"), "");
  EXPECT_EQ(code("{\"columns\":[\"a\"],\"rows\":[[1]"), "unreadable-file");
  EXPECT_EQ(code("[1]"), "bad-table");
  EXPECT_EQ(code("{\"columns\":[1],\"rows\":[[1]]}"), "bad-table");
  EXPECT_EQ(code("{\"columns\":[\"a\"]}"), "bad-table");
  EXPECT_EQ(code("{\"columns\":[\"a\"],\"rows\":[[1,2]]}"), "bad-table");
  EXPECT_EQ(code("{\"columns\":[\"a\"],\"rows\":[[true]]}"), "bad-table");
  EXPECT_EQ(code("{\"columns\":[\"a\"],\"rows\":[1]}"), "bad-table");
}

Table loaded(const std::string& bytes) {
  const auto file = test::temporary_folder() / "a.csv";
  std::ofstream(file, std::ios::binary) << bytes;
  return test::run_node("LoadTable", {}, {{"path", file.string()}}).output<Table>("table");
}

TEST(LoadTable, EncodingsAndLineEndsDoNotMatter) {
  const Table expected = read_csv("Fläche,b\n1.5,é\n", "t.csv");
  EXPECT_EQ(test::bytes_of(loaded("Fläche,b\r1.5,é\r")), test::bytes_of(expected));
  EXPECT_EQ(test::bytes_of(loaded("\xef\xbb\xbf"
                                  "Fläche,b\r\n1.5,é\r\n")),
            test::bytes_of(expected));
  EXPECT_EQ(test::bytes_of(loaded("Fl\xe4"
                                  "che,b\n1.5,\xe9\n")),
            test::bytes_of(expected));
  std::string wide = "\xff\xfe";
  for (const char16_t c : std::u16string(u"Fläche,b\n1.5,é\n"))
    wide += {static_cast<char>(c & 0xff), static_cast<char>(c >> 8)};
  EXPECT_EQ(test::bytes_of(loaded(wide)), test::bytes_of(expected));
}

TEST(LoadTable, OneColumnMayHaveDecimalCommas) {
  const auto rows = [](const std::string& text) { return read_csv(text, "t.csv").rows; };
  EXPECT_EQ(rows("Area (µm²)\n1,5\n-20\n"), (std::vector<Row>{{1.5}, {-20.0}}));
  EXPECT_EQ(test::code_of([&] { rows("place\nOslo, Norway\n"); }), "malformed-row");
  EXPECT_EQ(test::code_of([&] { rows("x\n1;2\n"); }), "malformed-row");
}

TEST(LoadTable, InvalidTextIsReadAsWindows1252WithAWarning) {
  const auto file = test::temporary_folder() / "a.csv";
  std::ofstream(file) << "x\n\xff\n";
  const auto run = test::run_node("LoadTable", {}, {{"path", file.string()}});
  EXPECT_EQ(run.output<Table>("table").rows[0][0], Cell("ÿ"));
  EXPECT_EQ(run.warnings.size(), 1u);
}

TEST(LoadTable, ReadsTheReportedFiles) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const auto run = test::run_node("LoadTable", {}, {{"path", (data / "reports/utf16.csv").string()}});
  const Table& table = run.output<Table>("table");
  EXPECT_EQ(table.columns, std::vector<std::string>{"area"});
  EXPECT_EQ(table.rows.size(), 400u);
  EXPECT_EQ(table.rows[0][0], Cell(3.118547));
  const auto areas =
      test::run_node("LoadTable", {}, {{"path", (data / "reports/header_um2_one_column.csv").string()}});
  EXPECT_EQ(areas.output<Table>("table").columns, std::vector<std::string>{"Area (µm²)"});
}

}  // namespace
}  // namespace terrazzo
