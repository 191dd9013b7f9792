// Reads tables from CSV and JSON.
#pragma once

#include <string>

#include "nodes/data/table.h"
#include "runtime/work.h"

namespace terrazzo::load_table {

// Reads a header and rows, separated by tabs, semicolons or commas (CellReader). Cells in double quotes are
// text and may contain separators and ends of lines; other cells are trimmed, and are numbers if all of their
// text is one (nan and inf too; with a decimal comma unless commas separate). Empty lines are skipped. `file`
// is used in messages only. Throws Error "no-column" without a header, "malformed-row" with file:line.
Table read_csv(const std::string& text, const std::string& file, const Work& = {});

// Reads `columns`, a list of names, and `rows`, lists of numbers, text and null for NaN, as Export and
// `terrazzo show --json` write them, with every number to the last bit. Throws Error "unreadable-file" if the
// structure is another, "bad-table" with the index of the row.
Table read_json(const std::string& text, const std::string& file, const Work& = {});

// Upper bound of the bytes that either needs, without the text.
double memory_to_read(const std::string& text);

}  // namespace terrazzo::load_table
