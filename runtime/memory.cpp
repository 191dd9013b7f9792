#include "runtime/memory.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string_view>

#include "graph/diagnostic.h"
#include "graph/text/read_number.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

// Files of the kernel have no size, so they are not opened as InputFile.
std::optional<std::uint64_t> number_in(const fs::path& file) {
  std::ifstream in(file);
  std::string word;
  in >> word;
  return number_in_text<std::uint64_t>(word);  // not for "max", or if there is no such file
}

// Calls `use` for each line "NAME NUMBER …", such as "MemAvailable: 123 kB", until it returns false.
template <class Use>
void each_number(const fs::path& file, Use&& use) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const auto space = std::min(line.find(' '), line.size());
    std::string_view rest = std::string_view(line).substr(space);
    if (const auto number = take_number<std::uint64_t>(rest))
      if (!use(line.substr(0, space), *number)) return;
  }
}

std::uint64_t left_of(std::uint64_t limit, std::uint64_t used) { return limit > used ? limit - used : 0; }

std::uint64_t left_on_machine() {
  std::uint64_t left = kUnlimited;
  each_number("/proc/meminfo", [&](const std::string& name, std::uint64_t kilobytes) {
    if (name == "MemAvailable:") left = 1024 * kilobytes;
    return left == kUnlimited;
  });
  return left;
}

// The page cache counts toward a control group's usage, but the kernel frees it before an allocation fails.
std::uint64_t reclaimable(const fs::path& group) {
  std::uint64_t sum = 0;
  each_number(group / "memory.stat", [&](const std::string& name, std::uint64_t value) {
    if (name == "inactive_file" || name == "active_file") sum += value;
    return true;
  });
  return sum;
}

// The memory left in the group and in all its parent groups.
std::uint64_t left_in_group(const fs::path& mount, const std::string& path, const char* limit_name,
                            const char* usage_name) {
  std::uint64_t left = kUnlimited;
  fs::path group = mount / fs::path(path).relative_path();
  std::error_code error;
  // In a container, the path may refer to a folder of the host that is not mounted.
  if (!fs::exists(group / usage_name, error)) group = mount;
  while (true) {
    const auto limit = number_in(group / limit_name), used = number_in(group / usage_name);
    if (limit && used) left = std::min(left, left_of(*limit, left_of(*used, reclaimable(group))));
    if (group == mount || group == group.parent_path()) return left;
    group = group.parent_path();
  }
}

std::uint64_t left_in_groups() {
  std::uint64_t left = kUnlimited;
  std::ifstream in("/proc/self/cgroup");
  for (std::string line; std::getline(in, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const std::string path = line.substr(second + 1);
    if (controllers == ",,")
      left = std::min(left, left_in_group("/sys/fs/cgroup", path, "memory.max", "memory.current"));
    else if (controllers.find(",memory,") != std::string::npos)
      left = std::min(left, left_in_group("/sys/fs/cgroup/memory", path, "memory.limit_in_bytes",
                                          "memory.usage_in_bytes"));
  }
  return left;
}

std::string bytes_text(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.0f} MB", bytes / 1e6) : fmt::format("{:.1f} GB", bytes / 1e9);
}

}  // namespace

std::uint64_t available_address_space() {
  struct rlimit limit;
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnlimited;
  const std::uint64_t pages = number_in("/proc/self/statm").value_or(0);
  return left_of(limit.rlim_cur, pages * ::sysconf(_SC_PAGESIZE));
}

std::uint64_t available_memory() {
  return std::min({left_on_machine(), left_in_groups(), available_address_space()});
}

void require_memory(double bytes, std::uint64_t limit, const std::string& what) {
  if (bytes <= limit) return;
  throw Error("too-large",
              fmt::format("{} needs {} of memory, but only {} are available", what, bytes_text(bytes),
                          bytes_text(limit)),
              "use a smaller file, or raise --memory if the machine has more memory");
}

}  // namespace terrazzo
