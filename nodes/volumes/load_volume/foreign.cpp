// Formats that LoadVolume does not read, recognized so that the message can say what the file is.
#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "nodes/volumes/load_volume/scan.h"

namespace terrazzo::load_volume {
namespace {

struct ForeignFormat {
  std::string_view beginning, what, hint;
};
constexpr ForeignFormat kForeign[] = {
    {"\x1f\x8b", "compressed by gzip", "decompress it first; only NIfTI files are read as .gz"},
    {"BZh", "compressed by bzip2", "decompress it first"},
    {"# vtk DataFile", "a VTK file of the legacy format", "save it as image data, .vti, in ParaView"},
    {"CDF\1", "a netCDF file", "save the array as .npy"},
    {"CDF\2", "a netCDF file", "save the array as .npy"},
    {"MATLAB 5.0", "a MATLAB file", "save the array as .npy, for example with scipy and numpy"},
    {"# AmiraMesh", "an Amira mesh", "export it as NRRD or a stack of TIFF pictures"},
    {"# Avizo", "an Avizo file", "export it as NRRD or a stack of TIFF pictures"}};

}  // namespace

void refuse_foreign(const std::filesystem::path& path) {
  const std::string head = read_beginning(path, 64);
  for (const ForeignFormat& f : kForeign)
    if (head.starts_with(f.beginning))
      throw Error("unreadable-volume",
                  fmt::format("'{}' is {}, which LoadVolume does not read", path.string(), f.what),
                  std::string(f.hint))
          .parameter("path");
}

Error no_volume(const std::filesystem::path& path, const Error& picture) {
  const std::string extension = path.extension().string();
  if (extension == ".raw" || extension == ".bin" || extension == ".dat" || extension == ".vol")
    return Error(picture.diagnostic().code,
                 picture.diagnostic().message + "; it may consist of bare numbers without a header",
                 "describe them in a header beside the file, .mhd (MetaImage) or .nhdr (NRRD), and name the "
                 "header")
        .parameter("path");
  return Error(picture.diagnostic().code, picture.diagnostic().message,
               picture.diagnostic().hint + (picture.diagnostic().hint.empty() ? "" : "; ") +
                   "volumes are read from OpenVDB, .vti, .dream3d, NIfTI, NRRD, MetaImage, MRC, .npy, DICOM "
                   "and "
                   "stacks of pictures")
      .parameter("path");
}

}  // namespace terrazzo::load_volume
