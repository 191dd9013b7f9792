// A volume as slices in a picture and as a 3D texture, read back bit by bit, and sampled in three.js.
#include "nodes/export/formats/solid_texture.h"

#include <gtest/gtest.h>

#include <fstream>

#include "nodes/common/io/pictures/picture_codec.h"
#include "nodes/common/io/provenance.h"
#include "nodes/common/texture/color.h"
#include "runtime/random.h"
#include "tests/nodes/export/voxel_files.h"
#include "tests/support/code_of.h"
#include "tests/support/readers.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

const Vec3i kSize(7, 6, 11);  // 4 columns and 3 rows of slices, one of which is empty

std::size_t voxel(int x, int y, int z) { return (std::size_t(z) * kSize.y() + y) * kSize.x() + x; }

// Random colors and densities, whose values at each voxel are known.
struct Known {
  Volume volume;
  std::vector<Vec3f> color;
  std::vector<float> density;
};
Known known() {
  initialize_openvdb();
  Known out;
  out.volume.resolution = kSize;
  auto color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  auto density = openvdb::FloatGrid::create(0);
  auto id = openvdb::Int32Grid::create(-1);
  auto surface = openvdb::FloatGrid::create(3);
  auto source = openvdb::Vec3IGrid::create(openvdb::Vec3i(0));
  auto residual = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  for (int z = 0; z < kSize.z(); ++z)
    for (int y = 0; y < kSize.y(); ++y)
      for (int x = 0; x < kSize.x(); ++x) {
        Random r(1, 2, voxel(x, y, z));
        out.color.push_back(Vec3f(float(r.uniform()), float(r.uniform()), float(r.uniform(-0.1, 1.2))));
        out.density.push_back(float(r.uniform()));
        const openvdb::Coord at(x, y, z);
        color->tree().setValue(at, openvdb::Vec3s(out.color.back().data()));
        density->tree().setValue(at, out.density.back());
        surface->tree().setValue(at, 6 * out.density.back() - 3);
        residual->tree().setValue(at, openvdb::Vec3s(out.color.back().data()) - openvdb::Vec3s(0.5f));
        id->tree().setValue(at, x - y + 100000 * z - 1);
      }
  const auto add = [&](const openvdb::GridBase::Ptr& grid, const char* name) {
    grid->setName(name);
    grid->setTransform(voxel_transform(0.5));
    out.volume.grids.push_back(grid);
  };
  add(color, "Cd");
  add(density, "density");
  add(id, "id");
  add(surface, "surface");
  add(source, "source");
  add(residual, "residual");
  return out;
}

int byte_of(float v) { return static_cast<int>(std::lround(255 * v)); }
std::array<int, 3> bytes_of(const Vec3f& linear) {
  const Vec3f c = linear_to_srgb(linear.cwiseMax(0.0f).cwiseMin(1.0f));
  return {byte_of(c[0]), byte_of(c[1]), byte_of(c[2])};
}

template <class T>
T at_byte(const std::string& bytes, std::size_t at) {
  T v{};
  EXPECT_LE(at + sizeof v, bytes.size());
  std::memcpy(&v, bytes.data() + at, sizeof v);
  return v;
}

TEST(SolidTexture, SlicesOfAPictureAreTheVoxels) {
  const Known k = known();
  const fs::path out = test::temporary_folder();
  const auto run = test::run_node("Export", {{"volume", Value::of(k.volume)}},
                                  {{"path", "a.png"}, {"grids", "[Cd, density]"}}, out);
  EXPECT_EQ(run.metrics.at("columns"), 4);
  EXPECT_EQ(run.metrics.at("rows"), 3);
  const auto in = picture_codec().open(out / "a.png", "", {{"oiio:UnassociatedAlpha", 1}});
  ASSERT_EQ(in->header().width, 4 * 7);
  ASSERT_EQ(in->header().height, 3 * 6);
  ASSERT_EQ(in->header().count(), 4);
  std::vector<std::uint8_t> pixels(std::size_t{28 * 18 * 4});
  ASSERT_TRUE(in->read(Sample::UInt8, pixels.data()));
  for (int z = 0; z < 12; ++z)
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 7; ++x) {
        const std::uint8_t* p = &pixels[std::size_t((z / 4 * 6 + y) * 28 + z % 4 * 7 + x) * 4];
        if (z == 11) {
          EXPECT_EQ(p[0] + p[1] + p[2] + p[3], 0);
          continue;
        }
        const auto color = bytes_of(k.color[voxel(x, y, z)]);
        for (int c = 0; c < 3; ++c) ASSERT_EQ(p[c], color[c]) << x << " " << y << " " << z;
        ASSERT_EQ(p[3], byte_of(k.density[voxel(x, y, z)]));
      }
  EXPECT_FALSE(read_provenance(out / "a.png").empty());
}

TEST(SolidTexture, PictureOfNumbersHasOneChannel) {
  const Known k = known();
  const fs::path file = test::exported("a.png", {{"volume", Value::of(k.volume)}}, {{"grids", "density"}});
  const auto in = picture_codec().open(file, "", {});
  ASSERT_EQ(in->header().count(), 1);
  std::vector<std::uint8_t> pixels(std::size_t{28 * 18});
  ASSERT_TRUE(in->read(Sample::UInt8, pixels.data()));
  EXPECT_EQ(pixels[28 * 8 + 9], byte_of(k.density[voxel(2, 2, 5)]));
}

// Of the DirectX documentation.
TEST(SolidTexture, DdsHasTheVoxelsAfterItsHeaders) {
  const Known k = known();
  const std::string bytes = test::content_of(
      test::exported("a.dds", {{"volume", Value::of(k.volume)}}, {{"grids", "[Cd, density]"}}));
  ASSERT_EQ(bytes.size(), 148u + 7 * 6 * 11 * 4);
  EXPECT_EQ(bytes.substr(0, 4), "DDS ");
  const auto word = [&](std::size_t at) { return at_byte<std::uint32_t>(bytes, at); };
  EXPECT_EQ(word(4), 124u);
  EXPECT_EQ(word(8) & 0x800000u, 0x800000u);  // has a depth
  EXPECT_EQ(word(12), 6u);
  EXPECT_EQ(word(16), 7u);
  EXPECT_EQ(word(20), 28u);  // bytes of a row
  EXPECT_EQ(word(24), 11u);
  EXPECT_EQ(word(76), 32u);
  EXPECT_EQ(bytes.substr(84, 4), "DX10");
  EXPECT_EQ(word(112), 0x200000u);  // a volume
  EXPECT_EQ(word(128), 29u);        // DXGI_FORMAT_R8G8B8A8_UNORM_SRGB
  EXPECT_EQ(word(132), 4u);         // D3D10_RESOURCE_DIMENSION_TEXTURE3D
  EXPECT_EQ(word(140), 1u);
  for (std::size_t i = 0; i < k.color.size(); ++i) {
    const auto color = bytes_of(k.color[i]);
    for (int c = 0; c < 3; ++c) ASSERT_EQ(std::uint8_t(bytes[148 + 4 * i + c]), color[c]) << i;
    ASSERT_EQ(std::uint8_t(bytes[148 + 4 * i + 3]), byte_of(k.density[i]));
  }
}

TEST(SolidTexture, Ktx2HasTheVoxelsOfEveryKind) {
  const Known k = known();
  const fs::path out = test::temporary_folder();
  const auto texels = [&](const char* grids, std::uint32_t format, std::size_t size) {
    test::run_node("Export", {{"volume", Value::of(k.volume)}}, {{"path", "a.ktx2"}, {"grids", grids}}, out);
    const std::string bytes = test::content_of(out / "a.ktx2");
    EXPECT_EQ(bytes.substr(0, 12), "\xabKTX 20\xbb\r\n\x1a\n");
    const auto word = [&](std::size_t at) { return at_byte<std::uint32_t>(bytes, at); };
    EXPECT_EQ(word(12), format) << grids;
    EXPECT_EQ(Vec3i(word(20), word(24), word(28)), kSize);
    EXPECT_EQ(word(36), 1u);
    EXPECT_EQ(word(40), 1u);
    const std::size_t at = at_byte<std::uint64_t>(bytes, 80);
    EXPECT_EQ(at % std::max<std::size_t>(size, 4), 0u);
    EXPECT_EQ(at_byte<std::uint64_t>(bytes, 88), k.color.size() * size);
    EXPECT_EQ(bytes.size(), at + k.color.size() * size);
    return bytes.substr(at);
  };
  const std::string color = texels("Cd", 43, 4), half = texels("surface", 76, 2), whole = texels("id", 99, 4),
                    halves = texels("[residual, density]", 97, 8);
  for (std::size_t i = 0; i < k.color.size(); ++i) {
    ASSERT_EQ(std::uint8_t(color[4 * i]), bytes_of(k.color[i])[0]);
    ASSERT_EQ(std::uint8_t(color[4 * i + 3]), 255);
    ASSERT_EQ(at_byte<std::uint16_t>(half, 2 * i), Eigen::half(6 * k.density[i] - 3).x);
    ASSERT_EQ(at_byte<std::uint16_t>(halves, 8 * i + 4), Eigen::half(k.color[i].z() - 0.5f).x);
    ASSERT_EQ(at_byte<std::uint16_t>(halves, 8 * i + 6), Eigen::half(k.density[i]).x);
  }
  EXPECT_EQ(at_byte<std::int32_t>(whole, 4 * voxel(3, 2, 10)), 1000000);
  const auto provenance = json::parse(read_provenance(out / "a.ktx2"), nullptr, false);
  EXPECT_TRUE(provenance.is_object());
}

TEST(SolidTexture, RefusesWhatDoesNotFit) {
  const Known k = known();
  const fs::path out = test::temporary_folder();
  const auto code = [&](const char* path, const char* grids, Volume volume) {
    return test::code_of([&] {
      test::run_node("Export", {{"volume", Value::of(std::move(volume))}}, {{"path", path}, {"grids", grids}},
                     out);
    });
  };
  EXPECT_EQ(code("a.png", "surface", k.volume), "bad-values");
  EXPECT_EQ(code("a.png", "id", k.volume), "format-does-not-fit");
  EXPECT_EQ(code("a.png", "residual", k.volume), "format-does-not-fit");
  EXPECT_EQ(code("a.dds", "source", k.volume), "unsupported-grid");
  EXPECT_EQ(code("a.dds", "[Cd, id]", k.volume), "several-grids");
  EXPECT_EQ(code("a.dds", "[density, Cd]", k.volume), "several-grids");
  EXPECT_EQ(code("a.ktx2", "[Cd, surface]", k.volume), "bad-values");
  EXPECT_EQ(code("a.ktx2", "none", k.volume), "no-such-grid");
  EXPECT_EQ(code("a.ktx2", "auto", Volume{}), "no-grids");
  Volume two = k.volume;
  two.grids.erase(two.grids.begin());
  EXPECT_EQ(code("a.ktx2", "auto", two), "several-grids");
  Volume long_one = k.volume;
  long_one.resolution = Vec3i(2049, 1, 1);
  EXPECT_EQ(code("a.ktx2", "Cd", long_one), "too-large");
  Volume wide = k.volume;
  wide.resolution = Vec3i(2048, 1, 200);  // 15 columns
  EXPECT_EQ(code("a.png", "Cd", wide), "too-large");
  const auto nan = openvdb::Vec3SGrid::create(openvdb::Vec3s(std::nanf("")));
  nan->setName("Cd");
  nan->setTransform(voxel_transform(0.5));
  Volume broken;
  broken.resolution = kSize;
  broken.grids.push_back(nan);
  for (const char* path : {"a.png", "a.dds", "a.ktx2"})
    EXPECT_EQ(code(path, "Cd", broken), "bad-values") << path;
  EXPECT_TRUE(fs::is_empty(out));
}

TEST(SolidTexture, OneVoxelIsATexture) {
  const fs::path out = test::temporary_folder();
  Volume one = known().volume;
  one.resolution = Vec3i(1, 1, 1);
  for (const auto& [path, head] :
       {std::pair("a.dds", 148), std::pair("a.png", 0), std::pair("a.ktx2", 104)}) {
    const auto run = test::run_node("Export", {{"volume", Value::of(one)}}, {{"path", path}}, out);
    EXPECT_GE(fs::file_size(out / path), static_cast<std::uintmax_t>(head + 4)) << path;
  }
  EXPECT_EQ(fs::file_size(out / "a.dds"), 148u + 4);
}

float linear_of(int byte) { return srgb_to_linear(Vec3f::Constant(static_cast<float>(byte) / 255)).x(); }

// Linear between the eight nearest voxels of the periodic volume, as stored in 8 bits.
Vec3f expected_color(const Known& k, const Vec3& p) {
  const Vec3 at = p.cwiseProduct(kSize.cast<double>()) - Vec3::Constant(0.5);
  Vec3f sum = Vec3f::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    Vec3i v;
    for (int a = 0; a < 3; ++a) {
      const double low = std::floor(at[a]), f = at[a] - low;
      const int up = corner >> a & 1;
      weight *= up ? f : 1 - f;
      v[a] = ((static_cast<int>(low) + up) % kSize[a] + kSize[a]) % kSize[a];
    }
    const auto bytes = bytes_of(k.color[voxel(v.x(), v.y(), v.z())]);
    sum += static_cast<float>(weight) * Vec3f(linear_of(bytes[0]), linear_of(bytes[1]), linear_of(bytes[2]));
  }
  return sum;
}

TEST(SolidTexture, ShaderInThreeJsBlendsTheVoxelsAcrossSlicesAndSides) {
  const fs::path check = test::npm_check("solid_texture");
  const std::string browser = test::chromium();
  if (check.empty() || browser.empty())
    GTEST_SKIP() << "Chromium, node or npm is not installed, or cannot install three";
  const Known k = known();
  const fs::path out = test::temporary_folder();
  for (const char* name : {"solid.png", "solid.ktx2"})
    test::run_node("Export", {{"volume", Value::of(k.volume)}}, {{"path", name}, {"grids", "[Cd, density]"}},
                   out);
  constexpr int kColumns = 40, kRows = 30;
  const Vec3 origin(-0.7, -1.3, -0.4), right(2.1, 0.3, 0.9), up(-0.2, 1.9, 1.7);  // over several periods
  const auto list = [](const auto& v) { return json{v.x(), v.y(), v.z()}; };
  std::ofstream(out / "points.json") << json{{"size", list(kSize)},  {"origin", list(origin)},
                                             {"right", list(right)}, {"up", list(up)},
                                             {"columns", kColumns},  {"rows", kRows}};
  const auto run = test::run_command(
      {"timeout", "100", "node", (check / "check.mjs").string(), out.string(),
       (test::source_folder() / "nodes/export/shaders/solid_texture.glsl").string(), browser});
  const auto r = json::parse(run.out, nullptr, false);
  ASSERT_TRUE(r.is_object()) << run.out << run.err;
  EXPECT_EQ(r["errors"], json::array());
  EXPECT_EQ(r["is_3d"], true);
  EXPECT_EQ(r["depth"], 11);
  EXPECT_EQ(r["color_space"], "srgb");
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x) {
      const Vec3f want = expected_color(k, origin + (x + 0.5) / kColumns * right + (y + 0.5) / kRows * up);
      for (int c = 0; c < 3; ++c) {
        const std::size_t i = std::size_t(y * kColumns + x) * 4 + c;
        ASSERT_NEAR(r["slices"][i].get<float>(), want[c], 2e-3) << x << " " << y;
        ASSERT_NEAR(r["solid"][i].get<float>(), want[c], 1e-2) << x << " " << y;  // filters have 8 bits
      }
    }
}

}  // namespace
}  // namespace terrazzo
