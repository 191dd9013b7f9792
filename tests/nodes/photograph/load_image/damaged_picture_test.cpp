// Images that are truncated, damaged, or whose headers claim more than they contain.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <fstream>

#include "nodes/common/io/image_file.h"
#include "nodes/common/io/provenance.h"
#include "runtime/files.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

class DamagedPicture : public ::testing::Test {
 protected:
  // An image whose pixels are hardly compressible.
  std::string written(const std::string& name, int width = 60, int height = 40) {
    Image image(width, height, 1, 1);
    for (std::size_t p = 0; p < image.pixels.size(); ++p) {
      Random r(1, 1, p);
      image.pixels[p] = Vec3f(float(r.uniform()), float(r.uniform()), float(r.uniform()));
    }
    write_image(folder / name, image);
    return *read_file(folder / name);
  }
  fs::path write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return folder / name;
  }
  struct Outcome {
    std::string code, message;
    std::vector<std::string> warnings;
  };
  Outcome read(const fs::path& path, std::uint64_t memory = 2'000'000'000) {
    Outcome o;
    try {
      read_image(path, "auto", 1, {memory, [&](const std::string& w) { o.warnings.push_back(w); }});
    } catch (const Error& e) {
      o.code = e.diagnostic().code;
      o.message = e.diagnostic().message;
    }
    return o;
  }
  fs::path folder = test::temporary_folder();
};

std::string big32(std::uint32_t v) {
  return {static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
          static_cast<char>(v)};
}
std::string little32(std::uint32_t v) {
  const std::string b = big32(v);
  return {b.rbegin(), b.rend()};
}
std::string chunk(const std::string& name, const std::string& data) {
  const std::string body = name + data;
  return big32(static_cast<std::uint32_t>(data.size())) + body +
         big32(static_cast<std::uint32_t>(
             crc32(0, reinterpret_cast<const Bytef*>(body.data()), uInt(body.size()))));
}

// Every supported format, truncated anywhere: always an error.
TEST_F(DamagedPicture, ACutFileIsAnError) {
  for (const std::string name : {"a.jpg", "a.png", "a.tif", "a.exr", "a.hdr", "a.bmp", "a.ppm"}) {
    const std::string whole = written(name);
    const auto good = read(folder / name);
    ASSERT_EQ(good.code, "") << name << good.message;
    EXPECT_TRUE(good.warnings.empty()) << name;
    // The last bytes of some formats are insignificant: JPEG's end marker has two bytes.
    for (const double share : {0.0, 0.01, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99}) {
      const auto size = static_cast<std::size_t>(share * static_cast<double>(whole.size()));
      EXPECT_EQ(read(write("cut" + name, whole.substr(0, size))).code, "unreadable-image")
          << name << ", " << share;
    }
    for (const std::size_t less : {1, 2, 5, 30})
      EXPECT_EQ(read(write("cut" + name, whole.substr(0, whole.size() - less))).code, "unreadable-image")
          << name << " without " << less << " bytes";
  }
}

// The first directory precedes the pixels, as cameras write it.
TEST_F(DamagedPicture, ATiffWhosePixelsComeLastIsCutToo) {
  const auto entry = [](std::uint16_t tag, std::uint16_t type, std::uint32_t value) {
    return std::string{static_cast<char>(tag), static_cast<char>(tag >> 8), static_cast<char>(type), 0} +
           little32(1) + little32(value);
  };
  std::string file = std::string("II*\0", 4) + little32(8) + std::string("\x08\0", 2);
  const auto header = static_cast<std::uint32_t>(file.size() + 8 * 12 + 4);
  file += entry(256, 4, 50) + entry(257, 4, 40) + entry(258, 3, 8) + entry(259, 3, 1) + entry(262, 3, 1) +
          entry(273, 4, header) + entry(278, 4, 40) + entry(279, 4, 2000) + little32(0);
  file += std::string(2000, '\x60');
  ASSERT_EQ(read(write("a.tif", file)).code, "");
  for (const std::size_t size : {file.size() - 1, file.size() - 1000, file.size() - 1999})
    EXPECT_EQ(read(write("a.tif", file.substr(0, size))).code, "unreadable-image") << size;
}

TEST_F(DamagedPicture, WhatTheJpegDecoderComplainsAboutIsAWarning) {
  const std::string whole = written("a.jpg", 200, 200);
  int errors = 0, warnings = 0, silent = 0;
  for (std::uint64_t k = 0; k < 100; ++k) {
    Random r(2, 2, k);
    std::string bytes = whole;
    for (int flip = 0; flip < 5; ++flip)
      bytes[700 + r.below(bytes.size() - 710)] = static_cast<char>(r.below(256));
    const auto o = read(write("b.jpg", bytes));
    ++(o.code != "" ? errors : o.warnings.empty() ? silent : warnings);
    for (const auto& w : o.warnings) EXPECT_LT(w.size(), 400u);
  }
  EXPECT_GT(warnings + errors, 60) << errors << " errors, " << warnings << " warnings, " << silent
                                   << " silent";
}

TEST_F(DamagedPicture, AWarningReachesTheUserOfTheNode) {
  std::string bytes = written("a.jpg", 200, 200);
  bytes.insert(bytes.size() - 2, "superfluous");  // before the end marker
  write("a.jpg", bytes);
  const auto run = test::run_node("LoadImage", {}, {{"path", (folder / "a.jpg").string()}});
  ASSERT_EQ(run.warnings.size(), 1u);
  EXPECT_NE(run.warnings[0].find("a.jpg: the JPEG decoder warned"), std::string::npos) << run.warnings[0];
}

TEST_F(DamagedPicture, AFlippedBitInAPngIsFound) {
  const std::string whole = written("a.png");
  for (std::uint64_t k = 0; k < 100; ++k) {
    std::string bytes = whole;
    const std::size_t at = 8 + Random(3, 3, k).below(bytes.size() - 8);
    bytes[at] = static_cast<char>(bytes[at] ^ 4);
    const auto o = read(write("b.png", bytes));
    EXPECT_TRUE(o.code == "unreadable-image" || o.warnings.size() == 1) << at;
  }
}

TEST_F(DamagedPicture, BmpColorsThatAreNotThere) {
  const auto bmp = [](int bits, int compression, std::uint32_t colors, const std::string& pixels) {
    std::string out = "BM" + little32(0) + little32(0) + little32(54 + 4 * colors) + little32(40) +
                      little32(4) + little32(1);
    out += std::string{1, 0, static_cast<char>(bits), 0} + little32(static_cast<std::uint32_t>(compression));
    out += std::string(12, '\0') + little32(colors) + little32(0);
    for (std::uint32_t c = 0; c < colors; ++c) out += little32(0x010203 * c);
    return out + pixels;
  };
  EXPECT_EQ(read(write("a.bmp", bmp(8, 0, 4, {0, 1, 2, 3}))).code, "");
  EXPECT_EQ(read(write("a.bmp", bmp(8, 0, 4, {0, 1, 2, 4}))).code, "unreadable-image");
  EXPECT_EQ(read(write("a.bmp", bmp(4, 0, 4, {0x01, 0x23, 0, 0}))).code, "");
  EXPECT_EQ(read(write("a.bmp", bmp(4, 0, 4, {0x01, 0x53, 0, 0}))).code, "unreadable-image");
  EXPECT_EQ(read(write("a.bmp", bmp(8, 1, 4, {4, 1, 0, 1}))).code, "unreadable-image");  // run-length encoded
  EXPECT_EQ(read(write("a.bmp", bmp(24, 1, 0, std::string(12, '\1')))).code, "unreadable-image");
}

// A file of a few bytes that claims gigapixels is damaged, no matter how much memory there is.
TEST_F(DamagedPicture, AHeaderAloneTakesNoMemory) {
  const std::uint64_t plenty = 1'000'000'000'000;
  const std::string png = std::string("\x89PNG\r\n\x1a\n", 8) +
                          chunk("IHDR", big32(30000) + big32(30000) + std::string("\x08\x02\0\0\0", 5)) +
                          chunk("IDAT", "x") + chunk("IEND", "");
  EXPECT_EQ(read(write("bomb.png", png), plenty).code, "unreadable-image");
  const std::string bmp = "BM" + little32(1000) + little32(0) + little32(54) + little32(40) +
                          little32(60000) + little32(60000) + std::string("\x01\0\x08\0", 4) + little32(1) +
                          std::string(2000, '\0');
  EXPECT_EQ(read(write("bomb.bmp", bmp), plenty).code, "unreadable-image");
  EXPECT_EQ(read(write("bomb.ppm", "P6 60000 60000 255\n" + std::string(100, 'x')), plenty).code,
            "unreadable-image");
  EXPECT_EQ(read(write("bomb.hdr",
                       "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n" + std::string(100, '\2')),
                 plenty)
                .code,
            "unreadable-image");
  std::string exr = written("a.exr");
  const auto window = exr.find("dataWindow");
  ASSERT_NE(window, std::string::npos);
  const std::size_t value = window + std::strlen("dataWindow") + 1 + std::strlen("box2i") + 1 + 4;
  exr.replace(value + 12, 4, little32(2'000'000'000));
  EXPECT_EQ(read(write("bomb.exr", exr), plenty).code, "unreadable-image");
  std::string jpeg = written("a.jpg");
  const auto frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  jpeg.replace(frame + 5, 4, "\xff\xdc\xff\xdc");
  EXPECT_EQ(read(write("bomb.jpg", jpeg), plenty).code, "unreadable-image");
}

TEST_F(DamagedPicture, TheBudgetIsKept) {
  for (const std::string name : {"a.jpg", "a.png", "a.tif", "a.exr"}) {
    written(name, 300, 200);
    EXPECT_EQ(read(folder / name, 1'000'000).code, "too-large") << name;
    EXPECT_EQ(read(folder / name, 20'000'000).code, "") << name;
  }
}

TEST_F(DamagedPicture, OtherFormatsAreRefusedByName) {
  const auto o = read(write("a.psd", "8BPS" + std::string(100, '\0')));
  EXPECT_EQ(o.code, "unreadable-image");
  EXPECT_EQ(read(write("empty.png", "")).code, "unreadable-image");
  EXPECT_EQ(read(folder).code, "unreadable-image");
}

// OpenImageIO parses XMP recursively, which used to crash the program.
TEST_F(DamagedPicture, NotesWithinNotesAreBounded) {
  const auto png = [&](int levels, bool packed) {
    std::string xmp = "<rdf:Description rdf:about=\"\">";
    for (int i = 0; i < levels; ++i) xmp += "<a>";
    for (int i = 0; i < levels; ++i) xmp += "</a>";
    xmp += "</rdf:Description>";
    if (packed) {
      std::string out(compressBound(xmp.size()), '\0');
      uLongf size = out.size();
      compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(xmp.data()),
               xmp.size());
      xmp = out.substr(0, size);
    }
    const std::string key =
        std::string("XML:com.adobe.xmp\0", 18) + (packed ? '\1' : '\0') + std::string(3, '\0');
    const std::string whole = written("a.png");
    return whole.substr(0, 33) + chunk("iTXt", key + xmp) + whole.substr(33);
  };
  for (const bool packed : {false, true}) {
    EXPECT_EQ(read(write("b.png", png(100, packed))).code, "") << packed;
    EXPECT_EQ(read(write("b.png", png(300'000, packed))).code, "unreadable-image") << packed;
  }
}

// Reading the provenance of untrusted files returns a text or nothing, and never needs more memory than the
// file's size.
TEST_F(DamagedPicture, ProvenanceOfAnything) {
  Image image(8, 8, 1, 1);
  write_image(folder / "p.png", image, 0, "{\"document\":1}");
  EXPECT_EQ(read_provenance(folder / "p.png"), "{\"document\":1}");
  std::string deep = "{\"asset\":{\"extras\":" + std::string(200000, '[') + std::string(200000, ']') + "}}";
  while (deep.size() % 4) deep += ' ';
  const auto size = static_cast<std::uint32_t>(deep.size());
  write("deep.glb", "glTF" + little32(2) + little32(size + 20) + little32(size) + "JSON" + deep);
  EXPECT_LT(read_provenance(folder / "deep.glb").size(), 1000u);
  write("long.vdb", " BDV" + std::string(4, '\0') + little32(224) + little32(10) + little32(0) + "\1" +
                        std::string(36, '0') + little32(1) + little32(4'000'000'000u) + "provenance");
  EXPECT_EQ(read_provenance(folder / "long.vdb"), "");
  EXPECT_EQ(read_provenance(folder / "nowhere.png"), "");
}

}  // namespace
}  // namespace terrazzo
