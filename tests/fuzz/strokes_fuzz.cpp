// Fuzzes strokes as drawings and as lists.
#include <unistd.h>

#include <fstream>

#include "graph/diagnostic.h"
#include "nodes/cooccurrence/load_strokes/stroke_files.h"

using namespace terrazzo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string file =
      (std::filesystem::temp_directory_path() / ("fuzz-" + std::to_string(::getpid()) + ".strokes")).string();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  Reading reading;
  reading.memory = 500'000'000;
  try {
    if (size > 0 && data[0] == '<')
      load_strokes::read_svg(file, reading);
    else
      load_strokes::read_yaml(file, reading);
  } catch (const Error&) {
  }
  ::unlink(file.c_str());
  return 0;
}
