// Fuzzes volumes as NIfTI, DICOM, images, OpenVDB, NRRD, MetaImage, MRC, NumPy arrays and zip
// archives of images. The first byte selects the format.
#include <unistd.h>

#include <fstream>

#include "graph/diagnostic.h"
#include "nodes/volumes/load_volume/scan.h"
#include "nodes/volumes/load_volume/slices.h"
#include "nodes/volumes/load_volume/vdb.h"
#include "nodes/volumes/load_volume/zip.h"

using namespace terrazzo;

// OpenVDB's RootNode::readTopology loses the node that it is reading when the file ends within it.
extern "C" const char* __lsan_default_suppressions() { return "leak:readTopology\n"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const char* const formats[] = {".nii", ".dcm", ".tif", ".vdb", ".nrrd",
                                        ".mha", ".mrc", ".npy", ".zip"};
  if (size == 0) return 0;
  const int format = data[0] % std::size(formats);
  const std::string file =
      (std::filesystem::temp_directory_path() / ("fuzz-" + std::to_string(::getpid()))).string() +
      formats[format];
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data) + 1, static_cast<std::streamsize>(size - 1));
  Reading reading;
  reading.memory = 500'000'000;
  try {
    if (format == 0)
      load_volume::read_nifti(file, {}, reading);
    else if (format == 1)
      load_volume::read_dicom({file}, {}, reading);
    else if (format == 2)
      load_volume::read_slices({file}, {}, {}, reading);
    else if (format == 3)
      load_volume::read_vdb(file, "", reading);
    else if (format == 4)
      load_volume::read_nrrd(file, {}, reading);
    else if (format == 5)
      load_volume::read_metaimage(file, {}, reading);
    else if (format == 6)
      load_volume::read_mrc(file, {}, reading);
    else if (format == 7)
      load_volume::read_npy(file, {}, reading);
    else
      load_volume::read_zip(file, "", {}, {}, reading);
  } catch (const Error&) {
  }
  ::unlink(file.c_str());
  return 0;
}
