#include "nodes/common/io/cell_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "graph/diagnostic.h"
#include "nodes/common/io/text_input.h"

namespace terrazzo {

std::string_view trimmed_cell(std::string_view s) {
  const auto first = s.find_first_not_of(" \t\r"), last = s.find_last_not_of(" \t\r");
  return first == std::string_view::npos ? std::string_view() : s.substr(first, last - first + 1);
}

std::optional<double> cell_number(std::string_view text, bool decimal_comma) {
  std::string with_point;
  if (decimal_comma && text.find('.') == std::string_view::npos &&
      std::count(text.begin(), text.end(), ',') == 1) {
    with_point = text;
    std::replace(with_point.begin(), with_point.end(), ',', '.');
    text = with_point;
  }
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double v = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return v;
}

void malformed_row(const std::string& file, int line, const std::string& what, const std::string& parameter) {
  throw Error("malformed-row", fmt::format("{}:{}: {}", file, line, what), "correct or remove the row")
      .parameter(parameter);
}

CellReader::CellReader(std::string_view text, std::string file, CellFormat format)
    : text_(text), file_(std::move(file)), format_(std::move(format)) {
  if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;
  skip_empty();
  // Excel names the separator in a line of its own.
  const std::string_view first = text_.substr(at_, line_end(text_, at_) - at_);
  if (first.size() == 5 && first.starts_with("sep=")) {
    separator_ = first[4];
    at_ += first.size();
    skip_empty();
  } else {
    separator_ = find_separator();
  }
}

char CellReader::find_separator() const {
  char contained = '\0';  // the first separator that the header contains
  for (const char separator : format_.separators) {
    CellReader trial = *this;
    trial.separator_ = separator;
    CellRow header, row;
    try {
      trial.next(header);
      if (header.cells.size() < 2) continue;
      if (!contained) contained = separator;
      const std::size_t cells = trial.next(row) ? row.cells.size() : header.cells.size();
      if (cells == header.cells.size() || cells == header.cells.size() + 1) return separator;
      // "Area (µm²)" above single numbers is one column.
      if (separator == ' ' && cells == 1 && contained == ' ') contained = '\0';
    } catch (const Error&) {  // a quotation mark is not closed
    }
  }
  return contained;
}

bool CellReader::next(CellRow& row) {
  row.cells.clear();
  if (at_ >= text_.size()) return false;
  row.line = next_line_;
  const bool blanks = separator_ == ' ';
  row.cells.emplace_back();
  for (; at_ < text_.size() && text_[at_] != '\n' && text_[at_] != '\r'; ++at_) {
    const char c = text_[at_];
    CellRow::Cell& last = row.cells.back();
    const auto empty = [&] { return !last.quoted && trimmed_cell(last.text).empty(); };
    if (separator_ && (c == separator_ || (blanks && c == '\t'))) {
      if (!(blanks && empty())) row.cells.emplace_back();
    } else if (c == '"' && empty()) {
      read_quoted(last, row.line);
    } else if (!(last.quoted && trimmed_cell(text_.substr(at_, 1)).empty())) {  // no blanks after the quotes
      last.text += c;
    }
  }
  for (CellRow::Cell& c : row.cells)
    if (!c.quoted) c.text = trimmed_cell(c.text);
  if (blanks && row.cells.size() > 1 && row.cells.back().text.empty() && !row.cells.back().quoted)
    row.cells.pop_back();
  if (!separator_) require_one_cell(row);
  skip_empty();
  return true;
}

// Where the header has one column, what looks like a further cell is a mistake in the row.
void CellReader::require_one_cell(const CellRow& row) const {
  const CellRow::Cell& cell = row.cells[0];
  if (cell.quoted || cell_number(cell.text, true)) return;
  for (const char separator : format_.separators)
    if (separator != ' ')
      if (const auto n = std::count(cell.text.begin(), cell.text.end(), separator); n > 0)
        malformed(row.line, fmt::format("{} cells; 1 are expected", n + 1));
}

void CellReader::require_cells(const CellRow& row, std::size_t count) const {
  if (row.cells.size() != count)
    malformed(row.line, fmt::format("{} cells; {} are expected", row.cells.size(), count));
}

std::optional<double> CellReader::number(const CellRow::Cell& cell) const {
  return cell_number(cell.text, separator_ != ',');
}

void CellReader::malformed(int line, const std::string& what) const {
  malformed_row(file_, line, what, format_.parameter);
}

// From the opening quote to the closing one; two quotes are one.
void CellReader::read_quoted(CellRow::Cell& cell, int line) {
  cell = {"", true};
  for (++at_; at_ < text_.size(); ++at_) {
    // CR LF counts once, at its LF.
    const bool carriage = text_[at_] == '\r' && !(at_ + 1 < text_.size() && text_[at_ + 1] == '\n');
    if (text_[at_] == '\n' || carriage) ++next_line_;
    if (text_[at_] != '"')
      cell.text += text_[at_];
    else if (at_ + 1 < text_.size() && text_[at_ + 1] == '"')
      cell.text += text_[at_++];
    else
      return;
  }
  malformed(line, "a quotation mark is not closed");
}

// Moves from the start of the text or the end of a line to the next line that has cells.
void CellReader::skip_empty() {
  while (at_ < text_.size()) {
    if (text_[at_] == '\n' || text_[at_] == '\r') {
      ++next_line_;
      at_ = after_line_end(text_, at_);
    }
    const auto end = line_end(text_, at_);
    const std::string_view line = trimmed_cell(text_.substr(at_, end - at_));
    if (!line.empty() && !(format_.comments && line[0] == '#')) return;
    at_ = end;
  }
}

}  // namespace terrazzo
