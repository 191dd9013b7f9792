#include "nodes/export/formats/nifti_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "nodes/common/io/checked_file.h"

namespace terrazzo::exporting {
namespace {

// Passes bytes on, compressed by gzip or not.
class NiftiStream {
 public:
  NiftiStream(std::ostream& out, bool gzip) : out_(out), gzip_(gzip) {
    // 16 + 15: a gzip header without a time, so that equal volumes give equal files
    if (gzip_ && deflateInit2(&z_, 4, Z_DEFLATED, 16 + 15, 9, Z_DEFAULT_STRATEGY) != Z_OK)
      throw Error("not-enough-memory", "zlib has no memory to compress the voxels", "write a .nii file");
  }
  ~NiftiStream() {
    if (gzip_) deflateEnd(&z_);
  }
  NiftiStream(const NiftiStream&) = delete;
  NiftiStream& operator=(const NiftiStream&) = delete;

  void write(const void* data, std::size_t size, bool last = false) {
    if (!gzip_) {
      out_.write(static_cast<const char*>(data), size);
      return;
    }
    const auto* at = static_cast<const Bytef*>(data);
    do {
      const std::size_t part = std::min<std::size_t>(size, 1u << 30);  // zlib's lengths have 32 bits
      z_.next_in = const_cast<Bytef*>(at);
      z_.avail_in = part;
      at += part;
      size -= part;
      do {
        z_.next_out = buffer_.data();
        z_.avail_out = buffer_.size();
        deflate(&z_, last && size == 0 ? Z_FINISH : Z_NO_FLUSH);
        out_.write(reinterpret_cast<const char*>(buffer_.data()), buffer_.size() - z_.avail_out);
      } while (z_.avail_out == 0);
    } while (size > 0);
  }

 private:
  std::ostream& out_;
  bool gzip_;
  z_stream z_{};
  std::array<Bytef, 1 << 16> buffer_;
};

// nifti1.h: the header has 348 bytes. Fields that stay 0 are not named here.
std::string nifti_header(const VoxelBox& box, bool whole, std::size_t voxels_at) {
  std::string h(348, '\0');
  const auto put = [&](std::size_t at, auto v) { std::memcpy(h.data() + at, &v, sizeof v); };
  put(0, std::int32_t{348});  // sizeof_hdr
  const std::int16_t dim[8] = {3,
                               static_cast<std::int16_t>(box.size.x()),
                               static_cast<std::int16_t>(box.size.y()),
                               static_cast<std::int16_t>(box.size.z()),
                               1,
                               1,
                               1,
                               1};
  std::memcpy(h.data() + 40, dim, sizeof dim);
  put(70, static_cast<std::int16_t>(whole ? 8 : 16));  // datatype: DT_INT32, DT_FLOAT32
  put(72, std::int16_t{32});                           // bitpix
  put(76, 1.0f);                                       // pixdim[0]: qfac
  for (int k = 0; k < 3; ++k) put(80 + 4 * static_cast<std::size_t>(k), static_cast<float>(box.spacing[k]));
  put(108, static_cast<float>(voxels_at));             // vox_offset
  put(112, 1.0f);                                      // scl_slope
  h[123] = 2;                                          // xyzt_units: mm
  std::memcpy(h.data() + 148, "Terrazzo", 8);          // descrip
  put(252, std::int16_t{1});                           // qform_code: scanner
  put(254, std::int16_t{1});                           // sform_code: scanner
  const Vec3 center = box.corner + 0.5 * box.spacing;  // of voxel (0, 0, 0)
  for (std::size_t k = 0; k < 3; ++k) {
    put(268 + 4 * k, static_cast<float>(center[k]));                // qoffset
    put(280 + 16 * k + 4 * k, static_cast<float>(box.spacing[k]));  // srow
    put(280 + 16 * k + 12, static_cast<float>(center[k]));
  }
  std::memcpy(h.data() + 344, "n+1", 4);  // magic
  return h;
}

// Header extension 6, a comment; its size is a multiple of 16.
std::string nifti_comment(const std::string& text) {
  std::string out(8, '\0');
  out += text;
  out.resize((out.size() + 15) / 16 * 16);
  const std::int32_t head[2] = {static_cast<std::int32_t>(out.size()), 6};
  std::memcpy(out.data(), head, sizeof head);
  return out;
}

}  // namespace

void write_nifti(const std::filesystem::path& path, const VoxelSource& source, const VoxelBox& box,
                 const std::string& provenance, const Work& work) {
  if (source.components() != 1)
    throw Error("not-a-scalar", fmt::format("grid '{}' has three numbers per voxel", source.name()),
                "choose a grid of single numbers with grids, or write .npy or .vti")
        .parameter("grids");
  constexpr int kLargestEdge = 32767;  // dim has 16 bits
  if (box.size.maxCoeff() > kLargestEdge)
    throw Error("too-large",
                fmt::format("the volume is {} × {} × {} voxels; the limit of NIfTI-1 is {} along each edge",
                            box.size.x(), box.size.y(), box.size.z(), kLargestEdge),
                "use fewer voxels, or write .npy or .vti");
  const bool shift = source.whole() && source.name() == "id";
  const std::string comment = provenance.empty() ? std::string() : nifti_comment(provenance);
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    NiftiStream stream(out, path.extension() == ".gz");
    const std::string header = nifti_header(box, source.whole(), 352 + comment.size());
    stream.write(header.data(), header.size());
    const char extended[4] = {static_cast<char>(comment.empty() ? 0 : 1), 0, 0, 0};
    stream.write(extended, sizeof extended);
    stream.write(comment.data(), comment.size());
    std::vector<std::int32_t> voxels(box.plane());
    for (int z = 0; z < box.size.z(); ++z) {
      work.check();
      work.progress(double(z) / box.size.z());
      source.read(z, z + 1, voxels.data());
      if (shift)
        for (std::int32_t& v : voxels) v = v < 0 ? 0 : v + 1;
      stream.write(voxels.data(), 4 * voxels.size(), z + 1 == box.size.z());
    }
  });
}

}  // namespace terrazzo::exporting
