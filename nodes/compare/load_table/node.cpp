#include "graph/node_type.h"
#include "nodes/common/io/json_input.h"
#include "nodes/common/io/text_input.h"
#include "nodes/compare/load_table/read_table.h"
#include "runtime/context.h"

namespace terrazzo::load_table {
namespace {

std::string csv_text(const std::filesystem::path& file, Context& c) {
  try {
    std::string text = read_text(file, reading_of(c));
    require_memory(memory_to_read(text), c.memory(), "the table '" + file.string() + "'");
    return text;
  } catch (Error& e) {
    throw e.parameter("path");
  }
}

void compute(Context& c) {
  const auto& files = c.files("path");
  const std::string extension = files.empty() ? "" : files[0].extension().string();
  Table table;
  if (files.size() != 1 || extension == ".json" || extension == ".JSON") {
    const std::string text = json_text_in(c);  // reports several files
    require_memory(memory_to_read(text), c.memory(), "the table '" + files[0].string() + "'");
    table = read_json(text, files[0].string(), c.work());
  } else {
    table = read_csv(csv_text(files[0], c), files[0].string(), c.work());
  }
  c.metric("rows", table.rows.size());
  c.metric("columns", table.columns.size());
  c.output("table", std::move(table));
}

}  // namespace
}  // namespace terrazzo::load_table

namespace terrazzo {

NodeType load_table_node() {
  using namespace load_table;
  return NodeType("LoadTable", 2)
      .doc_("Reads a table from CSV, or from JSON that Export wrote.")
      .source_("RFC 4180")
      .output("table", "Table", "The table, with the columns and rows of the file")
      .parameter(Parameter::input_path("path").doc_(
          "A .json file of a table, or any other file as text with a header line, separated by tabs, "
          "semicolons or commas"))
      .compute_(compute);
}

}  // namespace terrazzo
