#include "nodes/common/io/text_input.h"

#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using namespace std::string_literals;

struct Decoded {
  std::string text;
  std::vector<std::string> warnings;
};

Decoded decoded(const std::string& bytes) {
  Decoded out;
  Reading reading;
  reading.warn = [&](const std::string& w) { out.warnings.push_back(w); };
  out.text = as_utf8(bytes, "folder/t.csv", reading);
  return out;
}

std::string utf16(const std::u16string& text, bool big_endian) {
  std::string out;
  for (const char16_t c : text) {
    const char high = static_cast<char>(c >> 8), low = static_cast<char>(c & 0xff);
    out += big_endian ? high : low;
    out += big_endian ? low : high;
  }
  return out;
}

TEST(TextInput, EveryEncodingGivesTheSameText) {
  const std::string text = "Area (µm²),é €\n1,𝄞\n";
  const std::u16string units = u"Area (µm²),é €\n1,𝄞\n";
  for (const std::string& bytes :
       {text, "\xef\xbb\xbf" + text, "\xff\xfe" + utf16(units, false), "\xfe\xff" + utf16(units, true),
        utf16(units, false), utf16(units, true)}) {
    const Decoded d = decoded(bytes);
    EXPECT_EQ(d.text, text);
    EXPECT_TRUE(d.warnings.empty());
  }
  EXPECT_EQ(decoded("").text, "");
  EXPECT_EQ(decoded("a").text, "a");
}

TEST(TextInput, Windows1252IsReadWithAWarning) {
  const Decoded d = decoded("Area (\xb5m\xb2),\x80\xfc\n");
  EXPECT_EQ(d.text, "Area (µm²),€ü\n");
  EXPECT_EQ(d.warnings,
            std::vector<std::string>{"'t.csv' is not UTF-8: it is read as Windows-1252 (Latin-1)"});
  // Damaged UTF-8 stays UTF-8.
  const Decoded damaged = decoded("µ\xb5\n");
  EXPECT_EQ(damaged.text, "µ\uFFFD\n");
  EXPECT_EQ(damaged.warnings,
            std::vector<std::string>{"'t.csv' is not UTF-8: invalid bytes are read as U+FFFD"});
}

TEST(TextInput, SingleSurrogatesAreReplaced) {
  EXPECT_EQ(decoded("\xff\xfe\x01\xd8"
                    "a\0"s)
                .text,
            "\uFFFDa");
  EXPECT_EQ(decoded("\xff\xfe\x01\xdc"s).text, "\uFFFD");
  EXPECT_EQ(decoded("\xff\xfe\x01\xd8"s).text, "\uFFFD");
}

TEST(TextInput, BinaryFilesAreNamed) {
  const auto message = [](const std::string& bytes) {
    try {
      decoded(bytes);
    } catch (const Error& e) {
      EXPECT_EQ(e.diagnostic().code, "unreadable-file");
      EXPECT_FALSE(e.diagnostic().hint.empty());
      return e.diagnostic().message;
    }
    return std::string();
  };
  EXPECT_NE(message("PK\x03\x04 etc").find("Excel"), std::string::npos);
  EXPECT_NE(message("\xd0\xcf\x11\xe0 etc").find("Office"), std::string::npos);
  EXPECT_NE(message("\x89HDF\r\n\x1a\n").find("HDF5"), std::string::npos);
  EXPECT_NE(message("\x1f\x8b\x08").find("gzip"), std::string::npos);
  EXPECT_NE(message("%PDF-1.4").find("PDF"), std::string::npos);
  EXPECT_NE(message("area\n1\0 2\n"s).find("zero byte at position 6"), std::string::npos);
  EXPECT_NE(message("\xff\xfe\0\0a\0\0\0"s).find("UTF-32"), std::string::npos);
  EXPECT_NE(message("a\0\0\0b\0\0\0"s).find("UTF-32"), std::string::npos);
  EXPECT_NE(message("\xff\xfe"
                    "a"s)
                .find("within a character"),
            std::string::npos);
}

TEST(TextInput, FilesAreReadAsText) {
  const auto file = test::temporary_folder() / "a.csv";
  std::ofstream(file, std::ios::binary) << "\xff\xfe" + utf16(u"x\n1", false);
  EXPECT_EQ(read_text(file, {}), "x\n1");
  EXPECT_EQ(test::code_of([&] { read_text(test::temporary_folder(), {}); }), "unreadable-file");
  Reading small;
  small.memory = 10;
  EXPECT_EQ(test::code_of([&] { read_text(file, small); }), "too-large");  // 8 bytes, and more as UTF-8
}

TEST(TextInput, LinesEndInThreeWays) {
  const std::string text = "a\nb\r\nc\rd\r\r\n\ne";
  std::vector<std::string> lines;
  std::string_view line;
  for (std::size_t at = 0; next_line(text, at, line);) lines.emplace_back(line);
  EXPECT_EQ(lines, (std::vector<std::string>{"a", "b", "c", "d", "", "", "e"}));
  EXPECT_EQ(count_lines(text), 7u);
  EXPECT_EQ(count_lines("a\r"), 2u);
}

}  // namespace
}  // namespace terrazzo
