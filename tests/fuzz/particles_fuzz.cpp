// Fuzzes packings in JSON.
#include "nodes/packing/load_particles/read_particles.h"

#include "graph/diagnostic.h"

using namespace terrazzo;
using namespace load_particles;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    read_particles(std::string(reinterpret_cast<const char*>(data), size), "fuzz.json");
  } catch (const Error&) {
  }
  return 0;
}
