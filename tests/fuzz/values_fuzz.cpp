// Fuzzes shapes, K matrices, size distributions and tables in JSON, and tables in CSV.
#include "graph/diagnostic.h"
#include "nodes/compare/load_table/read_table.h"
#include "nodes/shapes/load_shapes/read_shapes.h"
#include "nodes/sizes/load_distribution/read_distribution.h"
#include "nodes/sizes/load_kmatrix/read_kmatrix.h"

using namespace terrazzo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto read = [&](auto&& reader) {
    try {
      reader();
    } catch (const Error&) {
    }
  };
  read([&] { load_shapes::read_shapes(text, "fuzz.json"); });
  read([&] { load_kmatrix::read_kmatrix(text, "fuzz.json"); });
  read([&] { load_distribution::read_distribution(text, "fuzz.json"); });
  read([&] { load_table::read_json(text, "fuzz.json"); });
  read([&] { load_table::read_csv(text, "fuzz.csv"); });
  return 0;
}
