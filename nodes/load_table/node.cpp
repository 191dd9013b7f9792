#include "graph/node_type.h"
#include "graph/utf8.h"
#include "nodes/common/io/json_input.h"
#include "nodes/common/io/reading.h"
#include "nodes/load_table/read_table.h"
#include "runtime/context.h"

namespace terrazzo::load_table {
namespace {

void compute(Context& c) {
  const std::string text = json_text_in(c);
  const auto& path = c.files("path")[0];
  require_memory(memory_to_read(text), c.memory(), "the table '" + path.string() + "'");
  const std::string file = path.string(), extension = path.extension().string();
  Table table;
  if (extension == ".json" || extension == ".JSON") {
    table = read_json(text, file, c.work());
  } else {
    const std::string read = valid_utf8(text);
    if (read != text)
      c.warn("'" + path.filename().string() + "' is not UTF-8: invalid bytes are read as U+FFFD");
    table = read_csv(read, file, c.work());
  }
  c.metric("rows", static_cast<double>(table.rows.size()));
  c.metric("columns", static_cast<double>(table.columns.size()));
  c.output("table", std::move(table));
}

}  // namespace
}  // namespace terrazzo::load_table

namespace terrazzo {

NodeType load_table_node() {
  using namespace load_table;
  return NodeType("LoadTable", 1)
      .doc_("Reads a table from CSV, or from JSON that Export wrote.")
      .source_("RFC 4180")
      .output("table", "Table", "The table, with the columns and rows of the file")
      .parameter(Parameter::input_path("path").doc_(
          "A .json file of a table, or any other file as text with a header line, separated by tabs, "
          "semicolons or commas"))
      .compute_(compute);
}

}  // namespace terrazzo
