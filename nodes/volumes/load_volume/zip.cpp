#include "nodes/volumes/load_volume/zip.h"

#include <fmt/format.h>
#include <fnmatch.h>
#include <zip.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "nodes/common/io/pictures/picture_check.h"
#include "nodes/common/io/pictures/picture_content.h"
#include "runtime/files/natural_order.h"

namespace terrazzo::load_volume {
namespace {

struct ZipEntry {
  std::uint64_t index = 0, bytes = 0;  // bytes: as the archive says
  std::string name;
};

class ZipArchive {
 public:
  explicit ZipArchive(const std::filesystem::path& path) : path_(path) {
    int code = 0;
    zip_.reset(zip_open(path.c_str(), ZIP_RDONLY, &code));
    if (zip_) return;
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string why = zip_error_strerror(&error);
    zip_error_fini(&error);
    throw damaged(why);
  }

  std::vector<ZipEntry> entries() const {
    std::vector<ZipEntry> out;
    const zip_int64_t count = zip_get_num_entries(zip_.get(), 0);
    for (zip_int64_t i = 0; i < count; ++i) {
      zip_stat_t stat;
      if (zip_stat_index(zip_.get(), i, 0, &stat) != 0) throw damaged(zip_strerror(zip_.get()));
      const std::string name = stat.name;
      if (name.ends_with('/')) continue;
      if (stat.encryption_method != ZIP_EM_NONE)
        throw Error("unreadable-volume",
                    fmt::format("'{}' in '{}' is encrypted", printable(name), path_.string()),
                    "extract the archive with its password")
            .parameter("path");
      out.push_back({static_cast<std::uint64_t>(i), stat.size, name});
    }
    return out;
  }

  // Its first bytes, or all of them, which libzip then compares with their checksum. Memory grows with what
  // is there, not with what the archive says.
  std::string read(const ZipEntry& entry, std::uint64_t most) const {
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(zip_fopen_index(zip_.get(), entry.index, 0),
                                                                 zip_fclose);
    if (!file) throw damaged(fmt::format("{}: {}", printable(entry.name), zip_strerror(zip_.get())));
    std::string out, part(std::min<std::uint64_t>(most, 1 << 20), '\0');
    out.reserve(std::min(entry.bytes, most));
    while (out.size() < most) {
      const zip_int64_t read =
          zip_fread(file.get(), part.data(), std::min<std::uint64_t>(part.size(), most - out.size()));
      if (read < 0)
        throw damaged(fmt::format("{}: {}", printable(entry.name), zip_file_strerror(file.get())));
      if (read == 0) break;
      out.append(part, 0, read);
    }
    return out;
  }

  PictureContent picture(const ZipEntry& entry, const Reading& reading) const {
    const std::filesystem::path name = path_ / printable(entry.name);
    require_memory(entry.bytes, reading.memory, "'" + name.string() + "'");
    std::string bytes = read(entry, entry.bytes + 1);  // the end of the file is where libzip checks it
    if (bytes.size() != entry.bytes)
      throw damaged(fmt::format("{} does not have the {} bytes that the archive says", printable(entry.name),
                                entry.bytes));
    return checked_picture(name, std::move(bytes), reading);
  }

  Error damaged(const std::string& why) const {
    return Error("unreadable-volume",
                 fmt::format("cannot read the zip archive '{}': {}", path_.string(), why),
                 "check that the file is complete, or extract it")
        .parameter("path");
  }

 private:
  std::filesystem::path path_;
  std::unique_ptr<zip_t, void (*)(zip_t*)> zip_{nullptr, zip_discard};
};

// A name whose runs of digits are apart: text, digits, text, … text.
std::vector<std::string> parts_of(const std::string& name) {
  std::vector<std::string> out(1);
  const std::size_t folder = name.rfind('/') + 1;  // 0 without one
  for (std::size_t i = 0; i < name.size(); ++i) {
    const bool digit = i >= folder && name[i] >= '0' && name[i] <= '9';
    if (digit != (out.size() % 2 == 0)) out.emplace_back();
    out.back() += name[i];
  }
  if (out.size() % 2 == 0) out.emplace_back();
  return out;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string out;
  for (const std::string& p : parts) out += p;
  return out;
}

// The pictures of each volume, by the name or glob that selects them. Names that are equal but for their
// numbers are the slices of one volume if one of the numbers differs in each; else of one for each value of
// the numbers that take fewer values.
std::map<std::string, std::vector<ZipEntry>> volumes_of(const std::vector<ZipEntry>& pictures) {
  std::map<std::string, std::vector<const ZipEntry*>> alike;
  for (const ZipEntry& e : pictures) {
    auto parts = parts_of(e.name);
    for (std::size_t k = 1; k < parts.size(); k += 2) parts[k] = "*";
    alike[joined(parts)].push_back(&e);
  }
  std::map<std::string, std::vector<ZipEntry>> out;
  for (const auto& [shape, entries] : alike) {
    std::vector<std::set<std::string>> numbers(parts_of(entries[0]->name).size());
    for (const ZipEntry* e : entries) {
      const auto parts = parts_of(e->name);
      for (std::size_t k = 1; k < parts.size(); k += 2) numbers[k].insert(parts[k]);
    }
    std::size_t slice = 0;  // the last of those that take most values
    for (std::size_t k = 1; k < numbers.size(); k += 2)
      if (numbers[k].size() >= numbers[slice].size()) slice = k;
    const bool one = numbers[slice].size() == entries.size();
    for (const ZipEntry* e : entries) {
      auto parts = parts_of(e->name);
      for (std::size_t k = 1; k < parts.size(); k += 2)
        if (numbers[k].size() > 1 && (one || k == slice)) parts[k] = "*";
      out[joined(parts)].push_back(*e);
    }
  }
  return out;
}

Error several(const std::filesystem::path& path, const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 8;
  std::string list;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i)
    list += (i > 0 ? ", " : "") + printable(names[i]);
  if (names.size() > kShown) list += ", …";
  return Error("several-files",
               fmt::format("'{}' contains {} volumes: {}", path.string(), names.size(), list),
               "set entry to one of them")
      .parameter("entry");
}

std::vector<ZipEntry> pictures_in(const ZipArchive& zip, const std::filesystem::path& path,
                                  const std::string& entry) {
  constexpr std::uint64_t kBeginning = 64;  // bytes that show the format
  std::vector<ZipEntry> out;
  const auto all = zip.entries();
  for (const ZipEntry& e : all)
    if (entry.empty() ? !picture_format(zip.read(e, kBeginning)).empty()
                      : fnmatch(entry.c_str(), e.name.c_str(), 0) == 0)
      out.push_back(e);
  std::sort(out.begin(), out.end(),
            [](const auto& a, const auto& b) { return natural_less(a.name, b.name); });
  if (!out.empty()) return out;
  const std::string first = all.empty() ? "" : fmt::format(", but {}", printable(all[0].name));
  throw Error("unreadable-volume",
              entry.empty() ? fmt::format("the zip archive '{}' contains no pictures{}", path.string(), first)
                            : fmt::format("no name in '{}' matches '{}'; the first is {}", path.string(),
                                          entry, all.empty() ? "missing" : printable(all[0].name)),
              "extract the archive, and name the file of the volume")
      .parameter(entry.empty() ? "path" : "entry");
}

}  // namespace

bool is_zip(const std::filesystem::path& path) {
  const std::string head = read_beginning(path, 4);
  return head == "PK\3\4" || head == "PK\5\6";  // the second one is empty
}

LoadedScan read_zip(const std::filesystem::path& path, const std::string& entry, const SliceOptions& options,
                    const Work& work, const Reading& reading) {
  const ZipArchive zip(path);
  const auto pictures = pictures_in(zip, path, entry);
  std::vector<std::string> names;
  if (const auto volumes = volumes_of(pictures); entry.empty() && volumes.size() > 1) {
    for (const auto& [name, slices] : volumes) names.push_back(name);
    throw several(path, names);
  }
  for (const ZipEntry& e : pictures) names.push_back(e.name);
  return read_slices(
      pictures.size(),
      [&](std::size_t i) {
        PictureContent content = zip.picture(pictures[i], reading);
        if (entry.empty() && pictures.size() > 1 && content.pages.pages.size() > 1)
          throw several(path, names);
        return content;
      },
      options, work, reading);
}

}  // namespace terrazzo::load_volume
