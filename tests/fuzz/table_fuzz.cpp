// Fuzzes tables of profiles.
#include "nodes/sizes/load_profiles/profile_table.h"

using namespace terrazzo;
using namespace load_profiles;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    read_profiles(std::string(reinterpret_cast<const char*>(data), size), "fuzz.csv", profile_unit("mm"));
  } catch (const Error&) {
  }
  return 0;
}
