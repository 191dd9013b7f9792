#include "nodes/export/formats/solid_texture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/common/texture/color.h"
#include "nodes/export/formats/picture_file.h"
#include "runtime/codec.h"
#include "runtime/memory.h"

namespace terrazzo::exporting {
namespace {

constexpr int kLargestEdge = 2048, kLargestPicture = 16384;  // of what graphics cards show

// How the kinds are stored: their names in DXGI and Vulkan, and what the data format descriptor says.
struct Layout {
  int channels, bytes;  // bytes per channel
  std::uint32_t dxgi, vulkan;
  std::uint8_t transfer;       // KHR_DF_TRANSFER_LINEAR or _SRGB
  std::uint8_t qualifiers;     // of each channel
  std::uint32_t lower, upper;  // what means −1 or 0, and 1
};
Layout layout_of(TexelKind kind) {
  constexpr std::uint8_t kLinear = 1, kSrgb = 2, kSigned = 0x40, kFloat = 0x80;
  constexpr std::uint32_t kMinusOne = 0xbf800000, kOne = 0x3f800000;  // floats
  switch (kind) {
    case TexelKind::Color:
      return {4, 1, 29, 43, kSrgb, 0, 0, 255};
    case TexelKind::Byte:
      return {1, 1, 61, 9, kLinear, 0, 0, 255};
    case TexelKind::Half:
      return {1, 2, 54, 76, kLinear, kSigned | kFloat, kMinusOne, kOne};
    case TexelKind::Halves:
      return {4, 2, 10, 97, kLinear, kSigned | kFloat, kMinusOne, kOne};
    case TexelKind::Whole:
      break;
  }
  return {1, 4, 43, 99, kLinear, kSigned, 0xffffffff, 1};
}

std::size_t texel_bytes(const Layout& layout) { return std::size_t(layout.channels) * layout.bytes; }

TexelKind kind_of(const VoxelSource& grid, bool picture) {
  const auto refuse = [&](const std::string& what) {
    throw Error(
        "format-does-not-fit",
        fmt::format("a .png file holds the grid Cd or single numbers from 0 to 1; {} {}", grid.name(), what),
        "use .ktx2 or .dds, or choose another grid with grids")
        .parameter("path");
  };
  if (grid.whole() && grid.components() > 1)
    throw Error("unsupported-grid",
                "the grid '" + grid.name() + "' contains vectors of whole numbers, which no texture holds",
                "choose another grid with grids")
        .parameter("grids");
  if (grid.whole()) {
    if (picture) refuse("contains whole numbers");
    return TexelKind::Whole;
  }
  if (grid.components() == 1) return picture ? TexelKind::Byte : TexelKind::Half;
  if (grid.name() == "Cd") return TexelKind::Color;
  if (picture) refuse("contains vectors");
  return TexelKind::Halves;
}

[[noreturn]] void fail_range(const std::string& grid, float value, const std::string& range) {
  throw Error("bad-values",
              fmt::format("the grid '{}' contains {:.4g}, but the texture holds {}", grid, value, range),
              "choose another grid with grids, or .ktx2 or .dds")
      .parameter("grids");
}

std::uint8_t byte_of(float v) { return static_cast<std::uint8_t>(std::lround(255 * v)); }

void put_half(float v, const std::string& grid, std::uint8_t* to) {
  if (!(std::abs(v) <= 65504)) fail_range(grid, v, "numbers up to 65504");
  const std::uint16_t bits = Eigen::half(v).x;
  std::memcpy(to, &bits, sizeof bits);
}

std::uint8_t unit_byte(float v, const std::string& grid) {
  if (!(v >= 0 && v <= 1)) fail_range(grid, v, "numbers from 0 to 1");
  return byte_of(v);
}

// Encodes one plane. `alpha` is null if alpha is 1.
void encode(TexelKind kind, const VoxelSource& grid, const VoxelSource* alpha, int z, std::size_t count,
            std::uint8_t* to) {
  if (kind == TexelKind::Whole) return grid.read(z, z + 1, to);
  std::vector<float> values(count * grid.components()), opacity;
  grid.read(z, z + 1, values.data());
  if (alpha) {
    opacity.resize(count);
    alpha->read(z, z + 1, opacity.data());
  }
  for (std::size_t i = 0; i < count; ++i) {
    const float* v = &values[i * grid.components()];
    const float a = alpha ? opacity[i] : 1;
    if (kind == TexelKind::Byte) to[i] = unit_byte(*v, grid.name());
    if (kind == TexelKind::Half) put_half(*v, grid.name(), to + 2 * i);
    if (kind == TexelKind::Halves) {
      for (int k = 0; k < 3; ++k) put_half(v[k], grid.name(), to + 8 * i + 2 * k);
      put_half(a, alpha ? alpha->name() : "", to + 8 * i + 6);
    }
    if (kind == TexelKind::Color) {
      for (int k = 0; k < 3; ++k)
        if (!std::isfinite(v[k])) fail_range(grid.name(), v[k], "finite colors");
      const Vec3f c = linear_to_srgb(Vec3f(v[0], v[1], v[2]).cwiseMax(0.0f).cwiseMin(1.0f));
      for (int k = 0; k < 3; ++k) to[4 * i + k] = byte_of(c[k]);
      to[4 * i + 3] = alpha ? unit_byte(a, alpha->name()) : 255;
    }
  }
}

void write_texture(const std::filesystem::path& path, const BufferWriter& head, const SolidTexels& texels) {
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(head.buffer.data()), head.buffer.size());
    out.write(reinterpret_cast<const char*>(texels.bytes.data()), texels.bytes.size());
  });
}

// Khronos Data Format Specification 1.3, 5: a basic descriptor block.
std::string data_format_descriptor(const Layout& layout) {
  BufferWriter out;
  const std::uint32_t block = 24 + 16 * layout.channels;
  out.pod<std::uint32_t>(4 + block);
  out.pod<std::uint32_t>(0);  // vendor and type: Khronos, basic
  out.pod<std::uint32_t>(2 | block << 16);
  out.pod<std::uint8_t>(1);  // model: RGBSDA
  out.pod<std::uint8_t>(1);  // primaries: BT.709
  out.pod(layout.transfer);
  out.pod<std::uint8_t>(0);   // alpha is straight
  out.pod<std::uint32_t>(0);  // blocks of one texel
  out.pod<std::uint64_t>(texel_bytes(layout));
  for (int k = 0; k < layout.channels; ++k) {
    constexpr std::uint8_t kAlpha = 15, kLinearSample = 0x10;
    const bool linear_alpha = k == 3 && layout.transfer == 2;
    out.pod(static_cast<std::uint16_t>(8 * layout.bytes * k));
    out.pod(static_cast<std::uint8_t>(8 * layout.bytes - 1));
    out.pod(static_cast<std::uint8_t>((k == 3 ? kAlpha : k) | layout.qualifiers |
                                      (linear_alpha ? kLinearSample : 0)));
    out.pod<std::uint32_t>(0);  // position
    out.pod(layout.lower);
    out.pod(layout.upper);
  }
  return {out.buffer.begin(), out.buffer.end()};
}

std::string key_values(const SolidTexels& texels, const std::string& provenance) {
  BufferWriter out;
  const auto add = [&](std::string_view key, const std::string& value) {
    const std::size_t bytes = key.size() + value.size() + 2;
    out.pod(static_cast<std::uint32_t>(bytes));
    out.bytes(key.data(), key.size());
    out.pod('\0');
    out.bytes(value.data(), value.size());
    for (std::size_t i = bytes - 1; i == bytes - 1 || i % 4 != 0; ++i) out.pod('\0');
  };
  add("KTXorientation", "ruo");  // to the right, up, and toward the viewer
  add("KTXwriter", "Terrazzo");
  add("terrazzo.edges", fmt::format("{} {} {}", texels.edges.x(), texels.edges.y(), texels.edges.z()));
  if (!provenance.empty()) add("terrazzo.provenance", provenance);
  return {out.buffer.begin(), out.buffer.end()};
}

}  // namespace

SolidTexels solid_texels(const Volume& volume, const std::vector<std::string>& grids, bool picture,
                         std::uint64_t memory, const Work& work) {
  const VoxelBox box = voxel_box(volume);
  const VoxelSource grid(volume, grids.at(0), box);
  SolidTexels out;
  out.kind = kind_of(grid, picture);
  out.size = box.size;
  out.edges = box.size.cast<double>().cwiseProduct(box.spacing);
  if (box.size.maxCoeff() > kLargestEdge)
    throw Error("too-large",
                fmt::format("the volume has {} × {} × {} voxels; a 3D texture has at most {} along an edge",
                            box.size.x(), box.size.y(), box.size.z(), kLargestEdge),
                "lower resolution of Voxelize");
  std::optional<VoxelSource> alpha;
  if (grids.size() > 1) {
    alpha.emplace(volume, grids[1], box);
    if (grids.size() > 2 || grid.components() == 1 || alpha->components() > 1 || alpha->whole())
      throw Error("several-grids",
                  "a texture holds one grid, or a grid of vectors and one of single real numbers as alpha",
                  "name such grids, as in grids: [Cd, density]")
          .parameter("grids");
    out.alpha = true;
  }
  const std::size_t plane = box.plane() * texel_bytes(layout_of(out.kind));
  // A picture is also arranged, encoded and read back.
  require_memory((picture ? 4.0 : 1.0) * plane * box.size.z(), memory, "the texture");
  out.bytes.resize(plane * box.size.z());
  work.parallel(box.size.z(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t z = begin; z < end; ++z)
      encode(out.kind, grid, alpha ? &*alpha : nullptr, static_cast<int>(z), box.plane(),
             &out.bytes[plane * z]);
  });
  return out;
}

int atlas_columns(int slices) {
  int columns = std::max(1, static_cast<int>(std::sqrt(slices)));
  while (columns * columns < slices) ++columns;
  return columns;
}

int atlas_rows(int slices) {
  const int columns = atlas_columns(slices);
  return (slices + columns - 1) / columns;
}

void write_slice_atlas(const std::filesystem::path& path, const SolidTexels& texels,
                       const std::string& provenance) {
  const Layout layout = layout_of(texels.kind);
  const Vec3i& size = texels.size;
  const int columns = atlas_columns(size.z()), rows = atlas_rows(size.z());
  PictureEncoding encoding;
  encoding.width = columns * size.x();
  encoding.height = rows * size.y();
  encoding.channels = texels.kind == TexelKind::Byte ? 1 : texels.alpha ? 4 : 3;
  encoding.alpha = encoding.channels == 4 ? 3 : -1;
  if (std::max(encoding.width, encoding.height) > kLargestPicture)
    throw Error("too-large",
                fmt::format("{} slices of {} × {} texels make a picture of {} × {}; the limit is {}",
                            size.z(), size.x(), size.y(), encoding.width, encoding.height, kLargestPicture),
                "use .ktx2 or .dds, or lower resolution of Voxelize");
  encoding.attributes = {{"oiio:ColorSpace", texels.kind == TexelKind::Color ? "sRGB" : "Raw"}};
  // Colors are stored as they are, whatever their alpha.
  if (encoding.channels == 4) encoding.attributes.emplace_back("oiio:UnassociatedAlpha", 1);
  if (!provenance.empty()) encoding.attributes.emplace_back("ImageDescription", provenance);
  std::vector<std::uint8_t> pixels(pixels_in(encoding.width, encoding.height) * encoding.channels);
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) {
        const std::size_t column = std::size_t(z % columns) * size.x() + x,
                          row = std::size_t(z / columns) * size.y() + y;
        const std::uint8_t* from =
            &texels.bytes[((std::size_t(z) * size.y() + y) * size.x() + x) * layout.channels];
        std::copy_n(from, encoding.channels, &pixels[(row * encoding.width + column) * encoding.channels]);
      }
  write_samples(path, encoding, pixels.data());
}

void write_dds(const std::filesystem::path& path, const SolidTexels& texels) {
  const Layout layout = layout_of(texels.kind);
  constexpr std::uint32_t kCaps = 0x1, kHeight = 0x2, kWidth = 0x4, kPitch = 0x8, kFormat = 0x1000,
                          kDepth = 0x800000, kTexture = 0x1000, kComplex = 0x8, kVolume = 0x200000,
                          kFourCc = 0x4, kTexture3d = 4, kStraight = 1, kOpaque = 3;
  BufferWriter out;
  const auto words = [&](const std::vector<std::uint32_t>& values) {
    for (const std::uint32_t v : values) out.pod(v);
  };
  out.bytes("DDS ", 4);
  words({124, kCaps | kHeight | kWidth | kPitch | kFormat | kDepth, std::uint32_t(texels.size.y()),
         std::uint32_t(texels.size.x()), std::uint32_t(texels.size.x() * texel_bytes(layout)),
         std::uint32_t(texels.size.z()), 1});
  words(std::vector<std::uint32_t>(11));
  words({32, kFourCc});
  out.bytes("DX10", 4);
  words({0, 0, 0, 0, 0, kTexture | kComplex, kVolume, 0, 0, 0});
  words({layout.dxgi, kTexture3d, 0, 1, layout.channels < 4 ? 0 : texels.alpha ? kStraight : kOpaque});
  write_texture(path, out, texels);
}

// Khronos Texture 2.0, 3.
void write_ktx2(const std::filesystem::path& path, const SolidTexels& texels, const std::string& provenance) {
  const Layout layout = layout_of(texels.kind);
  const std::string format = data_format_descriptor(layout), pairs = key_values(texels, provenance);
  constexpr std::uint32_t kHead = 104;  // header, index and the only level
  const std::uint32_t pairs_at = kHead + format.size();
  const std::size_t step = std::lcm(texel_bytes(layout), std::size_t{4});
  const std::uint64_t data_at = (pairs_at + pairs.size() + step - 1) / step * step;
  BufferWriter out;
  out.bytes("\xabKTX 20\xbb\r\n\x1a\n", 12);
  for (const std::uint32_t v :
       {layout.vulkan, std::uint32_t(layout.bytes), std::uint32_t(texels.size.x()),
        std::uint32_t(texels.size.y()), std::uint32_t(texels.size.z()), 0u, 1u, 1u, 0u,  // one level, plain
        kHead, std::uint32_t(format.size()), pairs_at, std::uint32_t(pairs.size())})
    out.pod(v);
  for (const std::uint64_t v : {std::uint64_t{0}, std::uint64_t{0}, data_at,
                                std::uint64_t(texels.bytes.size()), std::uint64_t(texels.bytes.size())})
    out.pod(v);
  out.bytes(format.data(), format.size());
  out.bytes(pairs.data(), pairs.size());
  while (out.buffer.size() < data_at) out.pod('\0');
  write_texture(path, out, texels);
}

}  // namespace terrazzo::exporting
