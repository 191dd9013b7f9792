// Writes zip archives, as other programs do, for tests of readers.
#pragma once

#include <zip.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace terrazzo::test {

// Entries by name and content. `password`: encrypts them.
inline std::filesystem::path write_zip(const std::filesystem::path& path,
                                       const std::vector<std::pair<std::string, std::string>>& entries,
                                       const char* password = nullptr) {
  zip_t* zip = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  for (const auto& [name, content] : entries) {
    zip_source_t* source = zip_source_buffer(zip, content.data(), content.size(), 0);
    const zip_int64_t at = zip_file_add(zip, name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (at < 0) throw std::runtime_error(zip_strerror(zip));
    if (password) zip_file_set_encryption(zip, at, ZIP_EM_TRAD_PKWARE, password);
  }
  if (zip_close(zip) != 0) throw std::runtime_error(zip_strerror(zip));
  return path;
}

}  // namespace terrazzo::test
