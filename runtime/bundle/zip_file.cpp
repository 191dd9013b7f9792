#include "runtime/bundle/zip_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <set>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "graph/text/utf8.h"
#include "runtime/files.h"
#include "runtime/files/descriptor.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

using Archive = std::unique_ptr<zip_t, void (*)(zip_t*)>;

constexpr zip_int64_t kTime = 315'619'200;  // 1980-01-02, since archives tell no earlier time

Error damaged(const fs::path& zip, const std::string& why) {
  return Error("bad-bundle", fmt::format("'{}' is no bundle: {}", zip.string(), why),
               "ask for another copy of the file");
}

Archive open_archive(const fs::path& path) {
  int code = 0;
  Archive zip(zip_open(path.c_str(), ZIP_RDONLY, &code), zip_discard);
  if (zip) return zip;
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  const std::string why = zip_error_strerror(&error);
  zip_error_fini(&error);
  throw damaged(path, why);
}

}  // namespace

std::string trouble_with_name(const std::string& name) {
  if (name.empty() || name.size() > 1000 || find_invalid_utf8(name) != std::string::npos)
    return "is no file name";
  if (std::ranges::any_of(name, [](unsigned char c) { return c < 0x20 || c == '\\' || c == 0x7f; }))
    return "contains a control character or '\\'";
  if (name.starts_with('/')) return "is absolute";
  for (const auto& part : fs::path(name))
    if (part == ".." || part == "." || part.string().size() > 255)
      return "does not name a file below the folder";
  return {};
}

namespace {

struct Entry {
  zip_uint64_t index;
  std::string name;
  std::uint64_t bytes;  // as the archive says
};

std::string lower(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

Entry entry_at(zip_t* zip, zip_uint64_t index, const fs::path& path) {
  zip_stat_t stat;
  if (zip_stat_index(zip, index, 0, &stat) != 0) throw damaged(path, zip_strerror(zip));
  constexpr zip_uint64_t kNeeded = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_ENCRYPTION_METHOD;
  if ((stat.valid & kNeeded) != kNeeded) throw damaged(path, "an entry has no name or size");
  const Entry out{index, stat.name, stat.size};
  const std::string shown = printable(out.name);
  if (const std::string why = trouble_with_name(out.name); !why.empty())
    throw damaged(path, fmt::format("the name '{}' {}", shown, why));
  if (stat.encryption_method != ZIP_EM_NONE) throw damaged(path, "'" + shown + "' is encrypted");
  zip_uint8_t system = 0;
  zip_uint32_t attributes = 0;
  if (zip_file_get_external_attributes(zip, index, 0, &system, &attributes) != 0)
    throw damaged(path, zip_strerror(zip));
  const mode_t mode = attributes >> 16;
  const bool plain = (mode & S_IFMT) == 0 || S_ISREG(mode) || S_ISDIR(mode);
  if (system == ZIP_OPSYS_UNIX && !plain) throw damaged(path, "'" + shown + "' is a link or a device");
  return out;
}

std::vector<Entry> entries_of(zip_t* zip, const fs::path& path) {
  const zip_int64_t count = zip_get_num_entries(zip, 0);
  if (count > static_cast<zip_int64_t>(kMostBundleFiles))
    throw Error("too-large",
                fmt::format("'{}' holds {} files; the limit is {}", path.string(), count, kMostBundleFiles));
  std::vector<Entry> out;
  std::set<std::string> names;
  std::uint64_t bytes = 0;
  for (zip_int64_t i = 0; i < count; ++i) {
    Entry e = entry_at(zip, i, path);
    if (e.name.ends_with('/')) continue;
    if (!names.insert(lower(e.name)).second) throw damaged(path, "'" + e.name + "' occurs twice");
    if (e.bytes > kMostBundleBytes || (bytes += e.bytes) > kMostBundleBytes)
      throw Error("too-large", fmt::format("the files in '{}' have more than {} GB", path.string(),
                                           kMostBundleBytes >> 30));
    out.push_back(std::move(e));
  }
  return out;
}

// Passes the content of an entry piece by piece. It has exactly the bytes that the archive says.
template <class Take>
void read_entry(zip_t* zip, const Entry& e, const fs::path& path, Take&& take) {
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(zip_fopen_index(zip, e.index, 0), zip_fclose);
  if (!file) throw damaged(path, fmt::format("'{}': {}", e.name, zip_strerror(zip)));
  std::string part(1 << 20, '\0');
  std::uint64_t bytes = 0;
  for (;;) {  // to its end, where libzip compares the checksum
    const zip_int64_t read = zip_fread(file.get(), part.data(), part.size());
    if (read < 0) throw damaged(path, fmt::format("'{}': {}", e.name, zip_file_strerror(file.get())));
    if (read == 0) break;
    if ((bytes += read) > e.bytes) break;
    take(part.substr(0, read));
  }
  if (bytes != e.bytes)
    throw damaged(path,
                  fmt::format("'{}' does not have the {} bytes that the archive says", e.name, e.bytes));
}

}  // namespace

bool is_zip_file(const fs::path& path) {
  const std::string head = read_beginning(path, 4);
  return head == "PK\3\4" || head == "PK\5\6";  // the second one is empty
}

void write_zip(const fs::path& to, const std::vector<BundleFile>& files) {
  const auto failed = [&](const std::string& why) {
    return Error("write-failed", fmt::format("cannot write '{}': {}", to.string(), why));
  };
  int code = 0;
  Archive zip(zip_open(to.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code), zip_discard);
  if (!zip) throw failed("it cannot be opened");
  for (const BundleFile& f : files) {
    zip_source_t* source = f.from.empty() ? zip_source_buffer(zip.get(), f.text.data(), f.text.size(), 0)
                                          : zip_source_file(zip.get(), f.from.c_str(), 0, -1);
    const zip_int64_t at = source ? zip_file_add(zip.get(), f.name.c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    if (at < 0) {
      if (source) zip_source_free(source);
      throw failed(zip_strerror(zip.get()));
    }
    zip_file_set_mtime(zip.get(), at, kTime, 0);
    zip_file_set_external_attributes(zip.get(), at, 0, ZIP_OPSYS_UNIX, (S_IFREG | 0644u) << 16);
  }
  if (zip_close(zip.get()) != 0) throw failed(zip_strerror(zip.get()));
  zip.release();
}

void extract_zip(const fs::path& path, const fs::path& folder) {
  const Archive zip = open_archive(path);
  const auto entries = entries_of(zip.get(), path);
  std::uint64_t bytes = 0;
  for (const Entry& e : entries) bytes += e.bytes;
  std::error_code error;
  if (const auto space = fs::space(folder, error); !error && space.available < bytes)
    throw Error("too-large", fmt::format("the files in '{}' need {} MB, more than '{}' has", path.string(),
                                         bytes / 1'000'000, folder.string()));
  for (const Entry& e : entries) {
    const fs::path to = folder / e.name;
    fs::create_directories(to.parent_path(), error);
    const Descriptor file(::open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
    if (error || file.fd < 0) throw Error("write-failed", fmt::format("cannot write '{}'", to.string()));
    read_entry(zip.get(), e, path, [&](const std::string& part) { write_all(file.fd, part, to); });
  }
}

std::optional<std::string> read_from_zip(const fs::path& path, const std::string& name, std::uint64_t most) {
  const Archive zip = open_archive(path);
  for (const Entry& e : entries_of(zip.get(), path)) {
    if (e.name != name) continue;
    if (e.bytes > most) return {};
    std::string out;
    read_entry(zip.get(), e, path, [&](const std::string& part) { out += part; });
    return out;
  }
  return {};
}

}  // namespace terrazzo
