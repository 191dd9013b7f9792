#include <fmt/format.h>
#include <nifti2_io.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"
#include "nodes/volumes/load_volume/stored_numbers.h"

namespace terrazzo::load_volume {
namespace {

Error unreadable(const std::filesystem::path& path, const std::string& why) {
  return Error("unreadable-volume", "'" + path.string() + "' cannot be read as NIfTI: " + why,
               "check that the file is complete");
}

// Null for types that are not a single number.
std::optional<NumberType> nifti_number(int type) {
  using Kind = NumberType::Kind;
  switch (type) {
    case NIFTI_TYPE_UINT8:
      return NumberType{Kind::Unsigned, 1};
    case NIFTI_TYPE_INT8:
      return NumberType{Kind::Signed, 1};
    case NIFTI_TYPE_UINT16:
      return NumberType{Kind::Unsigned, 2};
    case NIFTI_TYPE_INT16:
      return NumberType{Kind::Signed, 2};
    case NIFTI_TYPE_UINT32:
      return NumberType{Kind::Unsigned, 4};
    case NIFTI_TYPE_INT32:
      return NumberType{Kind::Signed, 4};
    case NIFTI_TYPE_INT64:
      return NumberType{Kind::Signed, 8};
    case NIFTI_TYPE_UINT64:
      return NumberType{Kind::Unsigned, 8};
    case NIFTI_TYPE_FLOAT32:
      return NumberType{Kind::Float, 4};
    case NIFTI_TYPE_FLOAT64:
      return NumberType{Kind::Float, 8};
    default:
      return {};
  }
}

struct Header {
  explicit Header(const std::filesystem::path& path)
      : bytes(nifti_read_header(path.c_str(), &version, 0), free) {
    // Without its checks, the library leaves the header in the byte order of the file.
    if (!bytes || (version != 1 && version != 2)) return;
    std::int32_t size = 0;
    std::memcpy(&size, bytes.get(), sizeof size);
    if (size != (version == 2 ? 540 : 348)) swap_nifti_header(bytes.get(), version);
  }
  int version = 0;
  std::unique_ptr<void, void (*)(void*)> bytes;
};

// The library allocates whatever the extensions claim, up to the offset of the voxels, so that offset must be
// within the file.
void check_header(const std::filesystem::path& path) {
  constexpr double kDeflate = 1032;  // the most bytes that one compressed byte can expand to
  const Header header(path);
  if (!header.bytes) throw unreadable(path, "it has no valid header");
  if (header.version != 1 && header.version != 2) return;
  const double begin =
      header.version == 2
          ? static_cast<double>(static_cast<const nifti_2_header*>(header.bytes.get())->vox_offset)
          : static_cast<double>(static_cast<const nifti_1_header*>(header.bytes.get())->vox_offset);
  // Check the type here, since the library reports a bad one on the terminal at any debug level.
  const int type = header.version == 2 ? static_cast<const nifti_2_header*>(header.bytes.get())->datatype
                                       : static_cast<const nifti_1_header*>(header.bytes.get())->datatype;
  if (!nifti_is_valid_datatype(type) || type == DT_UNKNOWN || type == DT_BINARY)
    throw unreadable(path, fmt::format("its data type {} is unknown", type));
  double size = 0;
  bool packed = false;
  auto files = nifti_companions(path);
  files.push_back(path);
  for (const auto& file : files) {
    size += static_cast<double>(std::filesystem::file_size(file));
    packed = packed || nifti_is_gzfile(file.c_str());
  }
  if (!(begin >= 0 && begin <= size * (packed ? kDeflate : 1)))
    throw unreadable(path, fmt::format("its voxels begin at byte {:.0f} of {:.0f}", begin, size));
}

// The library returns 1 if the header has no spacing, so read the header itself.
bool has_spacing(const std::filesystem::path& path) {
  const Header found(path);
  const int version = found.version;
  const auto& header = found.bytes;
  if (!header) return false;
  for (int k = 1; k <= 3; ++k) {
    const double step = version == 2 ? static_cast<const nifti_2_header*>(header.get())->pixdim[k]
                                     : static_cast<const nifti_1_header*>(header.get())->pixdim[k];
    if (!std::isfinite(step) || step == 0) return false;
  }
  return true;
}

Mat3 axes_of(const nifti_image& n) {
  Mat3 m = Mat3::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      m(i, j) = n.sform_code > 0   ? n.sto_xyz.m[i][j]
                : n.qform_code > 0 ? n.qto_xyz.m[i][j]
                                   : (i == j ? 1.0 : 0.0);
  // The axes point right, to the front (anterior) and to the head, as in NIfTI.
  return m;
}

}  // namespace

namespace {

// Whether the name is that of one half of a pair.
bool is_nifti_half(const std::filesystem::path& path) {
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const char* end : {".hdr", ".img", ".hdr.gz", ".img.gz"})
    if (name.ends_with(end)) return true;
  return false;
}

bool is_nifti_header(const std::filesystem::path& path) {
  nifti_set_debug_level(0);
  const Header header(path);
  return header.bytes && (header.version == 1 || header.version == 2);
}

}  // namespace

bool is_nifti(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  const auto ends = [&](const char* lower, const char* upper) {
    return name.ends_with(lower) || name.ends_with(upper);
  };
  if (ends(".nii", ".NII") || ends(".nii.gz", ".NII.GZ") || ends(".hdr.gz", ".HDR.GZ") ||
      ends(".img.gz", ".IMG.GZ"))
    return true;
  // A Radiance image may also be named .hdr, and any file .img.
  if (!ends(".hdr", ".HDR") && !ends(".img", ".IMG")) return false;
  return ends(".hdr", ".HDR") ? is_nifti_header(path) : !nifti_companions(path).empty();
}

std::vector<std::filesystem::path> nifti_companions(const std::filesystem::path& path) {
  nifti_set_debug_level(0);  // otherwise it prints to the terminal
  using Name = std::unique_ptr<char, void (*)(void*)>;
  if (path.extension() == ".nii" || path.extension() == ".NII" || !is_nifti_half(path)) return {};
  const Name header(nifti_findhdrname(path.c_str()), free);
  if (!header || !is_nifti_header(header.get())) return {};
  const Name voxels(nifti_findimgname(header.get(), NIFTI_FTYPE_NIFTI1_2), free);
  std::vector<std::filesystem::path> found;
  for (const auto& name : {header.get(), voxels.get()})
    if (name && path != std::filesystem::path(name)) found.push_back(name);
  return found;
}

namespace {

// Not by nifti_image_load, which silently replaces NaN by 0.
void read_voxels(const nifti_image& n, const NumberType& type, const std::filesystem::path& path,
                 LoadedScan& s, const Work& work) {
  const auto close = [](znzptr* f) {
    znzFile open = f;
    Xznzclose(&open);
  };
  std::unique_ptr<znzptr, decltype(close)> file(
      n.iname ? znzopen(n.iname, "rb", nifti_is_gzfile(n.iname)) : nullptr, close);
  if (!file || n.iname_offset < 0 ||
      znzseek(file.get(), static_cast<znz_off_t>(n.iname_offset), SEEK_SET) < 0)
    throw unreadable(path, "the file contains no voxels");
  std::vector<char> slab;
  const std::size_t plane = pixels_in(s.size.x(), s.size.y());
  for (int z = 0; z < s.size.z(); ++z) {
    work.check();
    slab.resize(plane * static_cast<std::size_t>(n.nbyper));
    if (znzread(slab.data(), 1, slab.size(), file.get()) != slab.size())
      throw unreadable(path, fmt::format("it ends at slice {} of {}", z, s.size.z()));
    append_numbers(s, type, std::string_view(slab.data(), slab.size()), path.string());
    work.done(z + 1, s.size.z());
  }
  // A compressed file ends with a checksum, which zlib verifies only once all data is read.
  slab.resize(1 << 16);
  for (int block = 0; block < 16384; ++block) {
    const auto read = znzread(slab.data(), 1, slab.size(), file.get());
    if (read > slab.size()) throw unreadable(path, "its compressed data is damaged or truncated");
    if (read == 0) break;
    work.check();
  }
  znzFile last = file.release();
  if (Xznzclose(&last) != 0) throw unreadable(path, "its compressed data is truncated");
}

}  // namespace

LoadedScan read_nifti(const std::filesystem::path& path, const Work& work, const Reading& reading) {
  nifti_set_debug_level(0);  // otherwise it prints to the terminal
  check_header(path);
  const std::unique_ptr<nifti_image, void (*)(nifti_image*)> image(nifti_image_read(path.c_str(), 0),
                                                                   nifti_image_free);
  if (!image) throw unreadable(path, "it has no valid header");
  const nifti_image& n = *image;
  for (int k = 4; k <= 7; ++k)
    if (n.dim[0] >= k && n.dim[k] > 1)
      throw Error("not-a-volume", fmt::format("'{}' contains {} volumes", path.string(), n.dim[k]),
                  "extract one of them");
  std::optional<NumberType> type = nifti_number(n.datatype);
  if (!type)
    throw Error("not-a-volume",
                fmt::format("'{}' contains {}, not one number per voxel", path.string(),
                            nifti_datatype_to_string(n.datatype)),
                "convert it to a scalar type");
  LoadedScan s;
  for (int k = 0; k < 3; ++k) {
    const auto edge = n.dim[0] > k ? n.dim[k + 1] : 1;
    if (edge < 1 || edge > (1 << 24)) throw unreadable(path, fmt::format("axis {} has {} voxels", k, edge));
    s.size[k] = static_cast<int>(edge);
  }
  if (s.size.cast<double>().prod() <= 2147483648.0)
    check_plausible(s.size.cast<double>().prod() * n.nbyper, n.iname ? n.iname : path.c_str());
  require_voxels(s, path.string(), reading, double(s.size.x()) * s.size.y() * n.nbyper);
  constexpr int kMostSignificantFirst = 2;  // MSB_FIRST, which the header defines only for the library itself
  type->big_endian = n.byteorder == kMostSignificantFirst;

  read_voxels(n, *type, path, s, work);
  if (n.scl_slope != 0) {
    s.slope = n.scl_slope;
    s.intercept = n.scl_inter;
  }
  const double unit = n.xyz_units == NIFTI_UNITS_METER ? 1000 : n.xyz_units == NIFTI_UNITS_MICRON ? 0.001 : 1;
  const Mat3 axes = axes_of(n);
  const bool placed = n.sform_code > 0;
  if (placed || has_spacing(path))
    for (int k = 0; k < 3; ++k) {
      const double step = placed ? axes.col(k).norm() : std::abs(n.pixdim[k + 1]);
      s.spacing[k] = unit * step;
    }
  if (axes.allFinite() && std::abs(axes.determinant()) > 1e-12 * std::pow(axes.norm(), 3))
    align_axes(s, axes);
  return s;
}

}  // namespace terrazzo::load_volume
