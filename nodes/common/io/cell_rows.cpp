#include "nodes/common/io/cell_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "graph/diagnostic.h"

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
  const std::string_view first = text_.substr(at_, text_.find('\n', at_) - at_);
  separator_ = format_.separators.back();
  for (const char c : format_.separators)
    if (first.find(c) != std::string_view::npos) {
      separator_ = c;
      break;
    }
}

bool CellReader::next(CellRow& row) {
  row.cells.clear();
  if (at_ >= text_.size()) return false;
  row.line = next_line_;
  const bool blanks = separator_ == ' ';
  row.cells.emplace_back();
  for (; at_ < text_.size() && text_[at_] != '\n'; ++at_) {
    const char c = text_[at_];
    CellRow::Cell& last = row.cells.back();
    const auto empty = [&] { return !last.quoted && trimmed_cell(last.text).empty(); };
    if (c == separator_ || (blanks && c == '\t')) {
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
  skip_empty();
  return true;
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
    if (text_[at_] == '\n') ++next_line_;
    if (text_[at_] != '"')
      cell.text += text_[at_];
    else if (at_ + 1 < text_.size() && text_[at_ + 1] == '"')
      cell.text += text_[at_++];
    else
      return;
  }
  malformed(line, "a quotation mark is not closed");
}

// Moves from the end of a line to the next that has cells.
void CellReader::skip_empty() {
  while (at_ < text_.size()) {
    if (text_[at_] == '\n') ++next_line_, ++at_;
    const auto end = std::min(text_.find('\n', at_), text_.size());
    const std::string_view line = trimmed_cell(text_.substr(at_, end - at_));
    if (!line.empty() && !(format_.comments && line[0] == '#')) return;
    at_ = end;
  }
}

}  // namespace terrazzo
