#include "runtime/cache/cache_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <string_view>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "graph/text/read_number.h"
#include "runtime/files.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

constexpr const char* version_file = "terrazzo-cache";
constexpr const char* version_text = "1\n";
constexpr const char* tag_text =
    "Signature: 8a477f597d28d172789f06886806bc55\n"
    "# This folder is a cache created by terrazzo. Its content can be recomputed.\n"
    "# For information about cache directory tags see https://bford.info/cachedir/\n";

bool is_table(const std::string& name) {
  for (const char* table : kCacheTables)
    if (name == table) return true;
  return false;
}

bool is_part(const std::string& name) {
  return name.size() == 2 && name.find_first_not_of("0123456789abcdef") == std::string::npos;
}

// The hash in the name of an entry's file, or zero.
Hash entry_of(const std::string& name) {
  return name.find_first_not_of("0123456789abcdef") == std::string::npos ? Hash::parse(name) : Hash{};
}

// Whether this is the temporary name of a file in a table: ".ab0123….host.pid.bits.tmp" or
// ".incoming.host.pid.bits.tmp". Versions before 0.2 used ".incoming-PID-N.PID.N.tmp", "incoming-PID-N" and
// ".ab0123….PID.N.tmp".
bool is_leftover(const std::string& name) {
  if (is_temporary_name(name, "incoming")) return true;
  if (name.size() > 33 && name[0] == '.' && entry_of(name.substr(1, 32)) &&
      is_temporary_name(name, name.substr(1, 32)))
    return true;
  const auto digits_and = [](const std::string& text, const char* others) {
    return text.find_first_not_of(std::string("0123456789") + others) == std::string::npos;
  };
  if (name.starts_with("incoming-")) return digits_and(name.substr(9), "-");
  if (!name.ends_with(".tmp")) return false;
  const std::string stem = name.substr(0, name.size() - 4);
  if (stem.starts_with(".incoming-")) return digits_and(stem.substr(10), "-.");
  return stem.size() > 33 && stem[0] == '.' && entry_of(stem.substr(1, 32)) && stem[33] == '.' &&
         digits_and(stem.substr(33), ".");
}

// Whether this is the name of one of the files next to the tables, or of its temporary file.
bool is_upkeep(const std::string& name) {
  const std::string tag = "CACHEDIR.TAG";
  return name == "lock" || name == "usage" || name == version_file || name == tag ||
         is_temporary_name(name, version_file) ||
         (name.ends_with(".TAG") && is_temporary_name(name.substr(0, name.size() - 4), "CACHEDIR"));
}

// Whether an unmarked folder contains nothing but cache files. `stranger`: the first other name. `error`: why
// the folder cannot be listed.
bool holds_only_entries(const fs::path& folder, std::string& stranger, std::error_code& error) {
  for (auto it = fs::recursive_directory_iterator(folder, error);
       !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    const std::string name = it->path().filename().string();
    const bool is_folder = it->is_directory(error) && !it->is_symlink(error);
    const bool ours = it.depth() == 0 ? (is_folder ? is_table(name) : is_upkeep(name))
                      : is_folder     ? it.depth() == 1 && is_part(name)
                                      : bool(entry_of(name)) || is_leftover(name);
    if (!ours) {
      stranger = it->path().lexically_relative(folder).string();
      return false;
    }
  }
  return true;
}

struct Clock {
  double now;
  Clock() {
    struct timespec t;
    ::clock_gettime(CLOCK_REALTIME, &t);
    now = t.tv_sec;
  }
  double age(const struct stat& s) const { return std::max(0.0, now - s.st_mtim.tv_sec); }
};

void each_file_in(const fs::path& folder, const std::string& part, const Clock& clock,
                  const std::function<void(const CacheFile&)>& use) {
  std::error_code error;
  for (auto it = fs::directory_iterator(folder, error); !error && it != fs::directory_iterator();
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    const Hash entry = entry_of(name);
    if (entry ? !part.empty() && !name.starts_with(part) : !is_leftover(name)) continue;
    struct stat s;
    if (::lstat(it->path().c_str(), &s) != 0 || !S_ISREG(s.st_mode)) continue;
    use({it->path(), entry, bytes_on_disk(s.st_size), clock.age(s)});
  }
}

}  // namespace

namespace {

// The content of the mark. `none`: there is no such file.
struct Mark {
  bool none = false;
  std::string trouble;  // "" if this is a cache of this version
};

Mark mark_of(const fs::path& folder) {
  constexpr std::uint64_t kLongest = 4096;
  const fs::path path = folder / version_file;
  std::error_code error;
  const fs::file_status there = fs::status(path, error);
  if (there.type() == fs::file_type::not_found) return {true, "it is not marked as a cache"};
  const FileText mark = read_input_file(path, kLongest);
  if (!mark) return {false, fmt::format("cannot read '{}': {}", path.string(), mark.trouble)};
  if (mark.text == version_text) return {};
  const std::string_view number(mark.text.data(), mark.text.empty() ? 0 : mark.text.size() - 1);
  if (mark.text.ends_with('\n') && number_in_text<unsigned>(number))
    return {false, fmt::format("its mark '{}' says version {} of the cache, and this program has version 1",
                               version_file, number)};
  return {false, fmt::format("its mark '{}' is damaged", version_file)};
}

}  // namespace

bool is_cache_folder(const fs::path& folder) { return mark_of(folder).trouble.empty(); }

void require_cache_folder(const fs::path& folder) {
  if (const Mark mark = mark_of(folder); !mark.trouble.empty())
    throw Error("usage", fmt::format("cannot use '{}' as a cache folder: {}", folder.string(), mark.trouble),
                "a run with --cache FOLDER creates one");
}

void open_cache_folder(const fs::path& folder) {
  const auto fail = [&](const char* code, const std::string& why, const std::string& hint) {
    throw Error(code, fmt::format("cannot use '{}' as a cache folder: {}", folder.string(), why), hint);
  };
  std::error_code error;
  if (!fs::exists(folder, error)) {
    if (folder.has_parent_path()) fs::create_directories(folder.parent_path(), error);
    if (!error && ::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST)
      error = std::error_code(errno, std::generic_category());
  }
  if (error) fail("cache-unusable", error.message(), "choose another folder with --cache, or --no-cache");
  struct stat s;
  if (::stat(folder.c_str(), &s) != 0 || !S_ISDIR(s.st_mode))
    fail("cache-unusable", "it is not a folder", "choose another folder with --cache, or --no-cache");
  if (s.st_mode & S_IWOTH)
    fail("unsafe-folder", "everybody may write to it and could change results",
         fmt::format("run chmod o-w '{}' or choose another folder", folder.string()));
  const Mark mark = mark_of(folder);
  if (mark.trouble.empty()) return;
  if (!mark.none)
    fail("cache-unusable", mark.trouble,
         "choose another folder with --cache, or remove that file if no other version of terrazzo uses it");
  std::string stranger;
  if (!holds_only_entries(folder, stranger, error))
    fail("not-a-cache", fmt::format("it contains '{}', which is not part of a cache", stranger),
         "choose a new or empty folder; cache folders contain a file named 'terrazzo-cache'");
  if (error)
    fail("cache-unusable", "cannot list it: " + error.message(),
         "choose another folder with --cache, or --no-cache");
  const bool fresh = fs::is_empty(folder, error);
  try {
    if (fresh) CacheUsage(folder).set(0);
    write_text_atomically(folder / "CACHEDIR.TAG", tag_text);
    write_text_atomically(folder / version_file, version_text);
  } catch (const Error& e) {
    fail("cache-unusable", e.diagnostic().message, "choose another folder with --cache, or --no-cache");
  }
}

fs::path cache_entry(const fs::path& folder, const char* table, const Hash& h) {
  const std::string name = h.text();
  return folder / table / name.substr(0, 2) / name;
}

std::int64_t write_cache_entry(const fs::path& folder, const char* table, const Hash& h,
                               const std::string& text) {
  const fs::path path = cache_entry(folder, table, h);
  std::error_code error;
  const auto before = fs::file_size(path, error);
  write_text_atomically(path, text);
  return static_cast<std::int64_t>(bytes_on_disk(text.size())) -
         static_cast<std::int64_t>(error ? 0 : bytes_on_disk(before));
}

void each_cache_file(const fs::path& folder, const char* table, int part,
                     const std::function<void(const CacheFile&)>& use) {
  const Clock clock;
  const fs::path base = folder / table;
  each_file_in(base, "", clock, use);  // files being written, and entries from versions before 0.2
  for (int k = part < 0 ? 0 : part; k <= (part < 0 ? 255 : part); ++k) {
    const std::string name = fmt::format("{:02x}", k);
    each_file_in(base / name, name, clock, use);
  }
}

template <class Change>
auto CacheUsage::change(Change change) const {
  struct State {
    std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();
    int part = 0;
  } state;
  const int file = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0) return change(state);
  while (::flock(file, LOCK_EX) != 0 && errno == EINTR) {
  }
  char text[64];
  const ssize_t length = ::pread(file, text, sizeof text, 0);
  std::string_view words(text, length > 0 ? static_cast<std::size_t>(length) : 0);
  const auto bytes = take_number<std::uint64_t>(words);
  const auto part = take_number<int>(words);
  if (bytes && part) state = {*bytes, *part & 255};
  const auto result = change(state);
  const std::string line = fmt::format("{:020d} {:03d}\n", state.bytes, state.part);
  // If this fails, the sum is too small until the next collection corrects it.
  [[maybe_unused]] const auto done = ::pwrite(file, line.data(), line.size(), 0);
  ::close(file);
  return result;
}

std::uint64_t CacheUsage::add(std::int64_t bytes) const {
  return change([&](auto& s) {
    if (s.bytes == std::numeric_limits<std::uint64_t>::max()) return s.bytes;
    // Clamped at 0, because writers that were killed never added the bytes that are removed now.
    const auto gone = bytes < 0 ? static_cast<std::uint64_t>(-bytes) : 0;
    return s.bytes =
               gone > 0 ? s.bytes - std::min(s.bytes, gone) : s.bytes + static_cast<std::uint64_t>(bytes);
  });
}

void CacheUsage::set(std::uint64_t bytes) const {
  change([&](auto& s) { return s.bytes = bytes; });
}

int CacheUsage::next_part() const {
  return change([&](auto& s) {
    const int part = s.part;
    s.part = (part + 1) & 255;
    return part;
  });
}

CacheLock::CacheLock(const fs::path& folder)
    : file_(::open((folder / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)),
      held_(file_ >= 0 && ::flock(file_, LOCK_EX | LOCK_NB) == 0) {}

CacheLock::~CacheLock() {
  if (file_ >= 0) ::close(file_);
}

}  // namespace terrazzo
