// Fuzzes EBSD maps, .ang and .ctf.
#include "graph/diagnostic.h"
#include "nodes/photograph/load_ebsd/grains.h"
#include "runtime/work.h"

using namespace terrazzo;
using namespace load_ebsd;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const EbsdMap map = text.starts_with("Channel") ? read_ctf(text, "fuzz.ctf") : read_ang(text, "fuzz.ang");
    grain_table(map, find_grains(map, {}, Work()));
    orientation_image(map, Work());
  } catch (const Error&) {
  }
  return 0;
}
