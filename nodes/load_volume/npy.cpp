// NumPy's .npy format, versions 1.0 to 3.0 (numpy.lib.format).
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <fstream>

#include "graph/diagnostic.h"
#include "nodes/load_volume/scan.h"

namespace terrazzo::load_volume {
namespace {

Error bad_npy(const std::filesystem::path& path, const std::string& why) {
  return Error("unreadable-volume", "'" + path.string() + "' cannot be read as a NumPy array: " + why,
               "write it with numpy.save");
}

template <class T>
void to_floats(std::string_view bytes, std::vector<float>& out) {
  for (std::size_t i = 0; i < out.size(); ++i) {
    T v;
    std::memcpy(&v, bytes.data() + i * sizeof v, sizeof v);
    out[i] = static_cast<float>(v);
  }
}
struct NpyType {
  const char* name;
  std::size_t bytes;
  void (*convert)(std::string_view, std::vector<float>&);
};
constexpr NpyType kNpyTypes[] = {{"b1", 1, to_floats<std::uint8_t>},  {"i1", 1, to_floats<std::int8_t>},
                                 {"u1", 1, to_floats<std::uint8_t>},  {"i2", 2, to_floats<std::int16_t>},
                                 {"u2", 2, to_floats<std::uint16_t>}, {"i4", 4, to_floats<std::int32_t>},
                                 {"u4", 4, to_floats<std::uint32_t>}, {"i8", 8, to_floats<std::int64_t>},
                                 {"u8", 8, to_floats<std::uint64_t>}, {"f4", 4, to_floats<float>},
                                 {"f8", 8, to_floats<double>}};

// The text after 'key': up to the next comma or brace, or inside parentheses. Keys have no quotes in them.
std::string value_of(const std::string& header, const std::string& key) {
  auto at = header.find("'" + key + "'");
  if (at == std::string::npos) return {};
  at = header.find(':', at);
  if (at == std::string::npos) return {};
  at = header.find_first_not_of(" ", at + 1);
  if (at == std::string::npos) return {};
  const auto end = header[at] == '(' ? header.find(')', at) : header.find_first_of(",}", at);
  return end == std::string::npos ? std::string() : header.substr(at, end - at);
}

}  // namespace

bool is_npy(const std::filesystem::path& path) {
  char head[6] = {};
  std::ifstream(path, std::ios::binary).read(head, sizeof head);
  return std::memcmp(head, "\x93NUMPY", 6) == 0;
}

LoadedScan read_npy(const std::filesystem::path& path, const Work& work, const Reading& reading) {
  const std::string content = read_whole(path, reading);
  const std::string_view all = content;
  std::uint32_t length = 0;
  const std::size_t size_at = 8, size_bytes = all.size() > 6 && all[6] == 1 ? 2 : 4;
  if (all.size() < size_at + size_bytes) throw bad_npy(path, "it has no header");
  std::memcpy(&length, all.data() + size_at, size_bytes);
  const std::size_t data_at = size_at + size_bytes + length;
  if (data_at > all.size()) throw bad_npy(path, "its header is truncated");
  const std::string header(all.substr(size_at + size_bytes, length));

  std::string type = value_of(header, "descr");
  std::erase(type, '\'');
  const bool swapped = type.starts_with('>');
  if (!type.empty() && std::string_view("<>|=").find(type[0]) != std::string_view::npos) type.erase(0, 1);
  const NpyType* known = nullptr;
  for (const NpyType& t : kNpyTypes)
    if (type == t.name) known = &t;
  if (!known || (swapped && known->bytes > 1))
    throw bad_npy(path, "its type is '" + printable(value_of(header, "descr")) +
                            "'; supported are little-endian whole numbers, floats and booleans");
  std::string text = value_of(header, "shape");
  std::vector<double> shape;
  for (const char* at = text.c_str(); *at;) {
    if (*at < '0' || *at > '9') {
      ++at;
      continue;
    }
    char* end = nullptr;
    shape.push_back(std::strtod(at, &end));
    at = end;
  }
  if (shape.size() != 3)
    throw Error(
        "not-a-volume",
        fmt::format("'{}' has {} dimensions; a volume has three: [x, y, z]", path.string(), shape.size()),
        "select one component or one volume");
  LoadedScan s;
  for (int k = 0; k < 3; ++k) {
    if (!(shape[k] <= (1 << 24))) throw bad_npy(path, fmt::format("axis {} has {} voxels", k, shape[k]));
    s.size[k] = static_cast<int>(shape[k]);
  }
  const double bytes = s.size.cast<double>().prod() * double(known->bytes);
  if (bytes > double(all.size() - data_at))
    throw bad_npy(path,
                  fmt::format("it has {} bytes of voxels instead of {:.0f}", all.size() - data_at, bytes));
  allocate(s, path.string(), reading, bytes);
  work.check();
  known->convert(all.substr(data_at), s.values);
  if (value_of(header, "fortran_order") == "True") return s;
  // C order: the last index, z, is the fastest.
  std::vector<float> turned(s.values.size());
  std::size_t i = 0;
  for (int x = 0; x < s.size.x(); ++x) {
    work.check();
    for (int y = 0; y < s.size.y(); ++y)
      for (int z = 0; z < s.size.z(); ++z)
        turned[(static_cast<std::size_t>(z) * s.size.y() + y) * s.size.x() + x] = s.values[i++];
  }
  s.values = std::move(turned);
  return s;
}

}  // namespace terrazzo::load_volume
