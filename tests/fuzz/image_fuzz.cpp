// Fuzzes images of every format, as photographs and as masks. The content determines the format.
#include <unistd.h>

#include <fstream>

#include "nodes/common/io/image_file.h"
#include "nodes/common/io/provenance.h"

using namespace terrazzo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string file =
      (std::filesystem::temp_directory_path() / ("fuzz-" + std::to_string(::getpid()) + ".picture")).string();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    Reading reading;
    reading.memory = 500'000'000;
    read_image(file, "auto", 1, reading);
  } catch (const Error&) {
  }
  read_provenance(file);
  ::unlink(file.c_str());
  return 0;
}
