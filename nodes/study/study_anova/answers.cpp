#include "nodes/study/study_anova/answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "graph/diagnostic.h"
#include "nodes/common/io/cell_rows.h"
#include "nodes/common/io/reading.h"

namespace terrazzo::study_anova {

namespace {

// The rows of a file, with the columns `names` in that order, whatever their order in the file.
class NamedRows {
 public:
  NamedRows(const std::string& text, const std::string& file, const std::string& parameter,
            std::initializer_list<const char*> names)
      : rows_(text, file, {.separators = ",", .parameter = parameter}) {
    const auto missing = [&](const std::string& what) {
      return Error("no-column", file + what, "use the file as the study wrote it").parameter(parameter);
    };
    if (!rows_.next(row_)) throw missing(" is empty");
    count_ = row_.cells.size();
    for (const char* name : names) {
      const auto found = std::find_if(row_.cells.begin(), row_.cells.end(),
                                      [&](const CellRow::Cell& c) { return c.text == name; });
      if (found == row_.cells.end()) throw missing(fmt::format(" has no column '{}'", name));
      at_.push_back(found - row_.cells.begin());
    }
  }

  bool next() {
    if (!rows_.next(row_)) return false;
    rows_.require_cells(row_, count_);
    return true;
  }
  // Cells of the row that was read last, by position in `names`.
  const std::string& text(std::size_t k) const { return row_.cells[at_[k]].text; }
  double number(std::size_t k) const {
    const auto v = cell_number(text(k), false);
    if (!v || !std::isfinite(*v)) malformed(fmt::format("'{}' is not a number", printable(text(k))));
    return *v;
  }
  int screen(std::size_t k) const {
    const double v = number(k);
    if (v < 0 || v > 1e9 || v != std::floor(v))
      malformed(fmt::format("'{}' is not the number of a screen", printable(text(k))));
    return static_cast<int>(v);
  }
  int line() const { return row_.line; }
  [[noreturn]] void malformed(const std::string& what) const { rows_.malformed(row_.line, what); }

 private:
  CellReader rows_;
  CellRow row_;
  std::size_t count_ = 0;
  std::vector<std::size_t> at_;
};

}  // namespace

std::map<int, KeyEntry> read_key(const std::string& text, const std::string& file) {
  NamedRows rows(text, file, "key", {"screen", "shape", "method", "decoy"});
  std::map<int, KeyEntry> out;
  while (rows.next()) {
    const std::string& decoy = rows.text(3);
    if (decoy != "left" && decoy != "right" && decoy != "none")
      rows.malformed(fmt::format("decoy must be left, right or none; it is '{}'", printable(decoy)));
    out[rows.screen(0)] = {rows.text(1), rows.text(2), decoy};
  }
  return out;
}

std::vector<Answer> read_answers(const std::string& text, const std::string& file,
                                 const std::map<int, KeyEntry>& key) {
  NamedRows rows(text, file, "answers", {"participant", "screen", "choice", "seconds"});
  std::vector<Answer> out;
  while (rows.next()) {
    const auto entry = key.find(rows.screen(1));
    if (entry == key.end())
      throw Error("no-such-screen",
                  fmt::format("{}:{}: the key has no screen {}", file, rows.line(), printable(rows.text(1))),
                  "use the key of the same study")
          .parameter("answers");
    const std::string& choice = rows.text(2);
    if (choice != "left" && choice != "right")
      rows.malformed(fmt::format("choice must be left or right; it is '{}'", printable(choice)));
    out.push_back({rows.text(0), entry->second.shape, entry->second.method, entry->second.decoy, choice,
                   rows.number(3)});
  }
  return out;
}

}  // namespace terrazzo::study_anova
