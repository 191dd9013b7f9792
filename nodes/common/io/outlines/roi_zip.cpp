#include <fmt/format.h>
#include <zip.h>

#include <memory>

#include "nodes/common/io/outlines/outline_file.h"

namespace terrazzo {
namespace {

Error damaged_archive(const std::filesystem::path& path, const std::string& why) {
  return Error("unreadable-outlines", fmt::format("cannot read the zip archive '{}': {}", path.string(), why),
               "check that the file is complete, and that it is a set of ImageJ regions")
      .parameter("path");
}

// Memory grows with what is there, not with what the archive says. `held`: bytes of all entries so far.
std::string entry_of(zip_t* zip, zip_uint64_t index, const std::filesystem::path& path,
                     const Reading& reading, double& held) {
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(zip_fopen_index(zip, index, 0), zip_fclose);
  if (!file) throw damaged_archive(path, zip_strerror(zip));
  std::string out, part(1 << 16, '\0');
  for (;;) {
    const zip_int64_t read = zip_fread(file.get(), part.data(), part.size());
    if (read < 0) throw damaged_archive(path, zip_file_strerror(file.get()));
    if (read == 0) return out;
    out.append(part, 0, read);
    held += static_cast<double>(read);
    require_memory(held * 8, reading.memory, "the regions in '" + path.string() + "'");
  }
}

}  // namespace

OutlineFile read_roi_zip(const std::filesystem::path& path, const Reading& reading) {
  int code = 0;
  const std::unique_ptr<zip_t, void (*)(zip_t*)> zip(zip_open(path.c_str(), ZIP_RDONLY, &code), zip_discard);
  if (!zip) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string why = zip_error_strerror(&error);
    zip_error_fini(&error);
    throw damaged_archive(path, why);
  }
  OutlineFile out;
  double held = 0;
  const zip_int64_t count = zip_get_num_entries(zip.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    const char* text = zip_get_name(zip.get(), i, 0);
    const std::string name = text ? text : "";
    if (!name.ends_with(".roi")) continue;
    const std::string shown = fmt::format("region '{}'", printable(name));
    FileOutline one =
        read_roi(entry_of(zip.get(), i, path, reading, held), path.string() + "/" + printable(name));
    one.name = shown;
    out.sections = std::max(out.sections, one.section + 1);
    out.outlines.push_back(std::move(one));
  }
  return out;
}

}  // namespace terrazzo
