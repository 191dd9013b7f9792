// MRC 2014 and CCP4 maps of electron microscopy (Cheng et al. 2015, J. Struct. Biol. 192, 146).
#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "nodes/volumes/load_volume/stored_numbers.h"

namespace terrazzo::load_volume {
namespace {

constexpr std::size_t kMrcHeader = 1024;
constexpr double kMmPerAngstrom = 1e-7;

Error bad_mrc(const std::filesystem::path& path, const std::string& why) {
  return Error("unreadable-volume", "'" + path.string() + "' cannot be read as MRC: " + why,
               "check that the file is complete");
}

// The words of the header, numbered from 1 as in the specification.
class MrcHeader {
 public:
  MrcHeader(std::string_view bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}
  std::int32_t whole(std::size_t word) const {
    std::uint32_t v = 0;
    for (std::size_t k = 0; k < 4; ++k)
      v = v << 8 | static_cast<unsigned char>(bytes_[4 * (word - 1) + (big_endian_ ? k : 3 - k)]);
    return std::bit_cast<std::int32_t>(v);
  }
  double real(std::size_t word) const { return std::bit_cast<float>(whole(word)); }

 private:
  std::string_view bytes_;
  bool big_endian_;
};

// The machine stamp, or where old programs left it out, the order in which the axes have numbers from 1 to 3.
bool is_big_endian(std::string_view head) {
  const unsigned char stamp = head[212];
  if (stamp == 0x44 || stamp == 0x11) return stamp == 0x11;
  const std::int32_t column = MrcHeader(head, true).whole(17);
  return column >= 1 && column <= 3;
}

NumberType mrc_type(const MrcHeader& h, bool big_endian, const std::filesystem::path& path) {
  using Kind = NumberType::Kind;
  constexpr std::int32_t kImodStamp = 1146047817;
  const std::int32_t mode = h.whole(4);
  switch (mode) {
    case 0:  // IMOD says in its flags whether bytes have a sign
      return {h.whole(39) == kImodStamp && !(h.whole(40) & 1) ? Kind::Unsigned : Kind::Signed, 1, false};
    case 1:
      return {Kind::Signed, 2, big_endian};
    case 2:
      return {Kind::Float, 4, big_endian};
    case 6:
      return {Kind::Unsigned, 2, big_endian};
    case 12:
      return {Kind::Float, 2, big_endian};
    case 3:
    case 4:
      throw Error("not-a-volume", "'" + path.string() + "' contains complex numbers",
                  "write their magnitude");
    default:
      throw Error("not-a-volume", fmt::format("'{}' has the MRC mode {}", path.string(), mode),
                  "write it with mode 0, 1, 2, 6 or 12");
  }
}

void require_one_volume(const MrcHeader& h, const Vec3i& size, const std::filesystem::path& path) {
  const std::int32_t depth = h.whole(10), group = h.whole(23);
  if (group > 400 && depth > 0 && size.z() > depth)
    throw Error(
        "not-a-volume",
        fmt::format("'{}' is a stack of {} volumes of {} slices", path.string(), size.z() / depth, depth),
        "extract one of them");
  if (group == 0 && depth == 1 && size.z() > 1)
    throw Error("not-a-volume",
                fmt::format("'{}' is a stack of {} single pictures, not a volume", path.string(), size.z()),
                "reconstruct a volume from them, or write the header of a volume (space group 1, mz = nz)");
}

// The columns, rows and sections of the file as axes of space, and the voxel's edges.
void place_mrc_axes(LoadedScan& s, const MrcHeader& h, const std::filesystem::path& path) {
  Mat3 axes = Mat3::Zero();
  const bool unset = h.whole(17) == 0 && h.whole(18) == 0 && h.whole(19) == 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::int32_t axis = unset ? static_cast<std::int32_t>(k) + 1 : h.whole(17 + k);
    if (axis < 1 || axis > 3) throw bad_mrc(path, fmt::format("axis {} of space does not exist", axis));
    const std::size_t to = axis - 1;
    axes(axis - 1, k) = 1;
    const double cell = h.real(11 + to) * kMmPerAngstrom;
    const std::int32_t intervals = h.whole(8 + to);
    s.spacing[k] = intervals > 0 && std::isfinite(cell) && cell > 0 ? cell / intervals : 0;
  }
  if (axes.determinant() == 0) throw bad_mrc(path, "two of its axes are the same");
  for (std::size_t k = 14; k < 17; ++k)
    if (const double angle = h.real(k); angle != 0 && std::abs(angle - 90) > 0.01)
      throw Error("tilted-volume",
                  fmt::format("the cell of '{}' has an angle of {:.4g} degrees", path.string(), angle),
                  "resample it to a box");
  align_axes(s, axes);
}

}  // namespace

bool is_mrc(const std::filesystem::path& path) {
  const std::string head = read_beginning(path, kMrcHeader);
  if (head.size() < kMrcHeader) return false;
  if (head.compare(208, 3, "MAP") == 0) return true;
  // Files from before 2000 have no mark.
  const std::string extension = path.extension().string();
  return extension == ".mrc" || extension == ".MRC";
}

LoadedScan read_mrc(const std::filesystem::path& path, const Work& work, const Reading& reading) {
  const std::string content = read_whole(path, reading);
  if (content.size() < kMrcHeader) throw bad_mrc(path, "its header is truncated");
  const bool big_endian = is_big_endian(content);
  const MrcHeader h(content, big_endian);
  LoadedScan s;
  for (int k = 0; k < 3; ++k) {
    s.size[k] = h.whole(static_cast<std::size_t>(k) + 1);
    if (s.size[k] < 1 || s.size[k] > (1 << 24))
      throw bad_mrc(path, fmt::format("axis {} has {} voxels", k, s.size[k]));
  }
  StoredArray array;
  array.type = mrc_type(h, big_endian, path);
  require_one_volume(h, s.size, path);
  const std::int32_t extended = h.whole(24);
  if (extended < 0 || static_cast<std::size_t>(extended) > content.size() - kMrcHeader)
    throw bad_mrc(path, fmt::format("its extended header has {} bytes", extended));
  array.data = std::string_view(content).substr(kMrcHeader + extended);
  array.content = content.size();
  take_voxels(s, array, path, work, reading);
  place_mrc_axes(s, h, path);
  return s;
}

}  // namespace terrazzo::load_volume
