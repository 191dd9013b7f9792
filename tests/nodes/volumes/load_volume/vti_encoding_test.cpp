// Ways in which programs write the arrays of .vti files.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <fstream>

#include "nodes/data/volume.h"
#include "runtime/files/base64.h"
#include "tests/nodes/volumes/load_volume/load.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

template <class T>
std::string bytes_of(T v, bool big_endian) {
  std::string out(sizeof v, '\0');
  std::memcpy(out.data(), &v, sizeof v);
  if (big_endian) std::reverse(out.begin(), out.end());
  return out;
}

std::string numbers(bool big_endian) {  // 3 × 2 × 2, x + 10 y + 100 z
  std::string out;
  for (int i = 0; i < 12; ++i)
    out += bytes_of(static_cast<float>(i % 3 + 10 * (i / 3 % 2) + 100 * (i / 6)), big_endian);
  return out;
}

struct Encoding {
  bool wide = false, big_endian = false, compressed = false, apart = false, base64 = true;
};

std::string length(std::uint64_t n, const Encoding& e) {
  return e.wide ? bytes_of(n, e.big_endian) : bytes_of(static_cast<std::uint32_t>(n), e.big_endian);
}

std::string encoded(const Encoding& e) {
  const std::string plain = numbers(e.big_endian);
  std::string header = length(plain.size(), e), data = plain;
  if (e.compressed) {  // two blocks
    header = length(2, e) + length(32, e) + length(16, e);
    data.clear();
    for (const auto& part : {plain.substr(0, 32), plain.substr(32)}) {
      std::string packed(200, '\0');
      uLongf size = packed.size();
      compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(part.data()),
               part.size());
      header += length(size, e);
      data += packed.substr(0, size);
    }
  }
  if (!e.base64) return header + data;
  return e.apart ? encode_base64(header) + encode_base64(data) : encode_base64(header + data);
}

std::string file_text(const Encoding& e, const std::string& array, const std::string& appended) {
  return fmt::format(
      "<VTKFile type=\"ImageData\" byte_order=\"{}\" header_type=\"{}\"{}><ImageData WholeExtent=\"0 3 0 2 0 "
      "2\" "
      "Spacing=\"0.001 0.001 0.001\"><Piece Extent=\"0 3 0 2 0 2\"><CellData><DataArray type=\"Float32\" "
      "Name=\"a\" {}"
      "</DataArray></CellData></Piece></ImageData>{}</VTKFile>",
      e.big_endian ? "BigEndian" : "LittleEndian", e.wide ? "UInt64" : "UInt32",
      e.compressed ? " compressor=\"vtkZLibDataCompressor\"" : "", array, appended);
}

void expect_counting(const std::string& text, const std::string& what) {
  const auto folder = test::temporary_folder();
  std::ofstream(folder / "a.vti", std::ios::binary) << text;
  const auto run = test::load_volume(folder / "a.vti");
  const auto g = run.output<Volume>("volume").find<openvdb::FloatGrid>("a");
  for (int i = 0; i < 12; ++i) {
    const openvdb::Coord at(i % 3, i / 3 % 2, i / 6);
    ASSERT_EQ(g->tree().getValue(at), at.x() + 10 * at.y() + 100 * at.z()) << what;
  }
}

TEST(VtiEncodings, AllAreRead) {
  for (int bits = 0; bits < 16; ++bits) {
    Encoding e{.wide = (bits & 1) != 0,
               .big_endian = (bits & 2) != 0,
               .compressed = (bits & 4) != 0,
               .apart = (bits & 8) != 0};
    const std::string what =
        fmt::format("wide {} big {} compressed {} apart {}", e.wide, e.big_endian, e.compressed, e.apart);
    std::string text = encoded(e);
    expect_counting(file_text(e, "format=\"binary\">\n  " + text, ""), what);
    expect_counting(file_text(e, "format=\"appended\" offset=\"0\">",
                              "<AppendedData encoding=\"base64\">_" + text + "</AppendedData>"),
                    what + ", appended");
    for (std::size_t at = 60; at < text.size(); at += 61) text.insert(at, "\n");
    expect_counting(file_text(e, "format=\"binary\">" + text, ""), what + ", in lines");
    e.base64 = false;
    expect_counting(file_text(e, "format=\"appended\" offset=\"0\">",
                              "<AppendedData encoding=\"raw\">_" + encoded(e) + "</AppendedData>"),
                    what + ", raw");
  }
}

TEST(VtiEncodings, WholeNumbersInTextKeepTheirDigits) {
  const auto folder = test::temporary_folder();
  const auto load = [&](const char* type, const char* values) {
    std::ofstream(folder / "a.vti") << fmt::format(
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 2 0 1 0 1\"><Piece><CellData><DataArray "
        "type=\"{}\" "
        "Name=\"a\" format=\"ascii\">{}</DataArray></CellData></Piece></ImageData></VTKFile>",
        type, values);
    return test::load_volume(folder / "a.vti")
        .output<Volume>("volume")
        .find<openvdb::Int32Grid>("a")
        ->tree()
        .getValue(openvdb::Coord(1, 0, 0));
  };
  EXPECT_EQ(load("Int32", "1 2147483647"), 2147483647);
  EXPECT_EQ(load("Int8", "1 -128"), -128);
  EXPECT_EQ(load("UInt8", "1\t255\n"), 255);
  for (const auto& [type, values] :
       {std::pair("UInt8", "1 256"), std::pair("Int8", "1 128"), std::pair("Int16", "1 2.5"),
        std::pair("Int32", "1"), std::pair("UInt16", "1 -1"), std::pair("Int32", "1 1,5")})
    EXPECT_EQ(test::code_of([&] { load(type, values); }), "unreadable-volume") << type << values;
}

TEST(VtiEncodings, TheSharedFile) {
  const fs::path path = test::shared_data() / "reports/separate_header.vti";
  if (!fs::exists(path)) GTEST_SKIP() << "no shared data";
  const auto run = test::load_volume(path);
  const auto g = run.output<Volume>("volume").find<openvdb::FloatGrid>("a");
  ASSERT_TRUE(g);
  EXPECT_EQ(g->tree().getValue(openvdb::Coord(3, 2, 1)), 123);
}

}  // namespace
}  // namespace terrazzo
