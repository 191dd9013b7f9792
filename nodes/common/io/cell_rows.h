// Rows of cells: CSV and its relatives, as spreadsheets and measuring programs write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace terrazzo {

struct CellRow {
  struct Cell {
    std::string text;
    bool quoted = false;
  };
  int line = 0;  // where the row begins; the first line is 1
  std::vector<Cell> cells;
};

struct CellFormat {
  // Possible separators. The first of them that divides the first row, and the second one into as many cells
  // (or one more, for a column without a name), separates the cells of all rows. If there is none, it is the
  // first that the first row contains outside of quotes, or else the table has one column. A blank means any
  // run of blanks and tabs. A first line such as "sep=;" names the separator instead.
  std::string_view separators = "\t;,";
  bool comments = false;           // skip lines that begin with #
  std::string parameter = "path";  // which parameter named the file, for errors
};

// Reads the rows of a text one after the other. Lines end with LF, CR LF, or CR. Empty lines and a byte order
// mark are skipped. Cells in
// double quotes may contain separators, ends of lines and, doubled, quotes (RFC 4180); other cells are
// trimmed.
class CellReader {
 public:
  // The text must outlive the reader. `file` is used in messages only.
  CellReader(std::string_view text, std::string file, CellFormat = {});

  char separator() const { return separator_; }  // 0: the table has one column
  // Returns false at the end. Throws Error "malformed-row" if a quotation mark is not closed.
  bool next(CellRow&);
  // Throws Error "malformed-row" unless the row has this many cells.
  void require_cells(const CellRow&, std::size_t count) const;
  // The number that is the whole cell, with a decimal comma unless commas separate cells; nan and inf too.
  std::optional<double> number(const CellRow::Cell&) const;
  // Throws Error "malformed-row" for a line.
  [[noreturn]] void malformed(int line, const std::string& what) const;

 private:
  char find_separator() const;
  void require_one_cell(const CellRow&) const;
  void read_quoted(CellRow::Cell&, int line);
  void skip_empty();

  std::string_view text_;
  std::string file_;
  CellFormat format_;
  std::size_t at_ = 0;
  int next_line_ = 1;
  char separator_ = '\0';
};

// Without blanks, tabs and carriage returns at both ends.
std::string_view trimmed_cell(std::string_view);

// The number that is the whole text; nullopt if it is not one. If `decimal_comma` is set and the text has one
// comma and no point, the comma is the decimal point.
std::optional<double> cell_number(std::string_view text, bool decimal_comma);

// Throws Error "malformed-row" with "FILE:LINE: WHAT".
[[noreturn]] void malformed_row(const std::string& file, int line, const std::string& what,
                                const std::string& parameter = "path");

}  // namespace terrazzo
