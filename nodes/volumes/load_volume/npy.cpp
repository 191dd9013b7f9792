// NumPy's .npy format, versions 1.0 to 3.0 (numpy.lib.format).
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "nodes/data/indices.h"
#include "nodes/volumes/load_volume/stored_numbers.h"

namespace terrazzo::load_volume {
namespace {

Error bad_npy(const std::filesystem::path& path, const std::string& why) {
  return Error("unreadable-volume", "'" + path.string() + "' cannot be read as a NumPy array: " + why,
               "write it with numpy.save");
}

std::optional<NumberType> npy_type(std::string_view descr) {
  NumberType type;
  type.big_endian = descr.starts_with('>');
  if (!descr.empty() && std::string_view("<>|=").find(descr[0]) != std::string_view::npos)
    descr.remove_prefix(1);
  if (descr.size() != 2) return {};
  type.bytes = descr[1] - '0';
  const bool one_of_eight = type.bytes == 1 || type.bytes == 2 || type.bytes == 4 || type.bytes == 8;
  type.kind = descr[0] == 'i'   ? NumberType::Kind::Signed
              : descr[0] == 'f' ? NumberType::Kind::Float
                                : NumberType::Kind::Unsigned;
  const bool known = descr == "b1" || ((descr[0] == 'i' || descr[0] == 'u') && one_of_eight) ||
                     (descr[0] == 'f' && one_of_eight && type.bytes > 1);
  return known ? std::optional(type) : std::nullopt;
}

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

// The whole numbers of a tuple such as "(3, 4, 5)".
std::vector<std::int64_t> npy_shape(std::string_view tuple, const std::filesystem::path& path) {
  const auto bad = [&] {
    return bad_npy(path, "its shape is '" + printable(tuple) + "', which is no list of whole numbers from 0");
  };
  if (!tuple.starts_with('(')) throw bad();
  std::vector<std::int64_t> shape;
  for (std::string_view rest = tuple.substr(1); rest.find_first_not_of(' ') != std::string_view::npos;) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    std::string_view word = rest.substr(0, comma);
    if (word.ends_with('L')) word.remove_suffix(1);  // Python 2
    const auto n = whole_number_in(word);
    if (!n || *n < 0) throw bad();
    shape.push_back(*n);
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return shape;
}

// Puts an array whose last index is the fastest in the order of a scan.
template <class T>
void turn_from_c_order(std::vector<T>& values, const Vec3i& size, const Work& work) {
  if (values.empty()) return;
  std::vector<T> turned(values.size());
  std::size_t i = 0;
  for (int x = 0; x < size.x(); ++x) {
    work.check();
    for (int y = 0; y < size.y(); ++y)
      for (int z = 0; z < size.z(); ++z) turned[voxel_at(x, y, z, size)] = values[i++];
  }
  values = std::move(turned);
}

}  // namespace

bool is_npy(const std::filesystem::path& path) { return read_beginning(path, 6) == "\x93NUMPY"; }

LoadedScan read_npy(const std::filesystem::path& path, const Work& work, const Reading& reading) {
  const std::string content = read_whole(path, reading);
  const std::string_view all = content;
  std::uint32_t length = 0;
  const std::size_t size_at = 8, size_bytes = all.size() > 6 && all[6] == 1 ? 2 : 4;
  if (all.size() < size_at + size_bytes) throw bad_npy(path, "it has no header");
  std::memcpy(&length, all.data() + size_at, size_bytes);
  const std::size_t data_at = size_at + size_bytes + length;
  if (data_at > all.size()) throw bad_npy(path, "its header is truncated");
  std::string header(all.substr(size_at + size_bytes, length));
  std::replace(header.begin(), header.end(), '"', '\'');

  std::string descr = value_of(header, "descr");
  std::erase(descr, '\'');
  StoredArray array;
  if (const auto type = npy_type(descr))
    array.type = *type;
  else
    throw bad_npy(path, "its type is '" + printable(descr) +
                            "'; supported are whole numbers, floats of 2, 4 and 8 bytes, and booleans");
  const std::vector<std::int64_t> shape = npy_shape(value_of(header, "shape"), path);
  if (shape.size() != 3)
    throw Error(
        "not-a-volume",
        fmt::format("'{}' has {} dimensions; a volume has three: [x, y, z]", path.string(), shape.size()),
        "select one component or one volume");
  LoadedScan s;
  for (int k = 0; k < 3; ++k) {
    const std::int64_t n = shape[k];
    if (n > (1 << 24)) throw bad_npy(path, fmt::format("axis {} has {} voxels", k, n));
    s.size[k] = n;
  }
  array.data = all.substr(data_at);
  array.content = content.size();
  take_voxels(s, array, path, work, reading);
  const std::string order = value_of(header, "fortran_order");
  if (order != "True" && order != "False")
    throw bad_npy(path, "fortran_order is '" + printable(order) + "' instead of True or False");
  if (order == "False") {  // C order: the last index, z, is the fastest
    turn_from_c_order(s.values, s.size, work);
    turn_from_c_order(s.whole, s.size, work);
  }
  return s;
}

}  // namespace terrazzo::load_volume
