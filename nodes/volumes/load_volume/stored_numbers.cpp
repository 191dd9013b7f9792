#include "nodes/volumes/load_volume/stored_numbers.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "graph/diagnostic.h"
#include "graph/text/read_number.h"

namespace terrazzo::load_volume {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

std::uint64_t bits_at(std::string_view bytes, std::size_t at, const NumberType& type) {
  std::uint64_t v = 0;
  if (!type.big_endian) {
    std::memcpy(&v, bytes.data() + at, type.bytes);  // this program runs on little-endian machines
    return v;
  }
  for (std::size_t k = 0; k < type.bytes; ++k) v = v << 8 | static_cast<unsigned char>(bytes[at + k]);
  return v;
}

// IEEE 754 binary16.
double half_number(std::uint64_t bits) {
  const int exponent = bits >> 10 & 31;
  const double fraction = static_cast<double>(bits & 1023), sign = bits >> 15 & 1 ? -1 : 1;
  if (exponent == 31) return fraction != 0 ? std::numeric_limits<double>::quiet_NaN() : sign * HUGE_VAL;
  return exponent == 0 ? sign * std::ldexp(fraction, -24) : sign * std::ldexp(fraction + 1024, exponent - 25);
}

double real_number(std::uint64_t bits, std::size_t bytes) {
  if (bytes == 2) return half_number(bits);
  return bytes == 4 ? double{std::bit_cast<float>(static_cast<std::uint32_t>(bits))}
                    : std::bit_cast<double>(bits);
}

[[noreturn]] void beyond(const LoadedScan& s, const std::string& file, const std::string& value) {
  const std::size_t i = s.whole.size(), nx = static_cast<std::size_t>(s.size.x()),
                    ny = static_cast<std::size_t>(s.size.y());
  throw Error("bad-values",
              fmt::format("'{}' has the value {} at voxel ({}, {}, {}) of the stored array, but voxels hold "
                          "whole numbers from −2^31 to 2^31 − 1",
                          file, value, i % nx, i / nx % ny, i / nx / ny),
              "renumber the labels, or store the numbers as floats");
}

void append_whole(LoadedScan& s, std::int64_t v, const std::string& file) {
  if (v != static_cast<std::int32_t>(v)) beyond(s, file, fmt::format("{}", v));
  s.whole.push_back(static_cast<std::int32_t>(v));
}

// Doubles are kept as whole numbers until the first one that is none. `exact`: whether they may be.
void append_real(LoadedScan& s, double v, bool exact) {
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  if (exact && s.values.empty()) {
    if (v == std::nearbyint(v) && std::abs(v) <= kMost) {
      s.whole.push_back(static_cast<std::int32_t>(v));
      return;
    }
    s.values.reserve(s.whole.capacity());
    s.values.assign(s.whole.begin(), s.whole.end());
    s.whole = {};
  }
  s.values.push_back(static_cast<float>(v));
}

void reserve(LoadedScan& s, const NumberType& type) {
  const std::size_t voxels = s.size.cast<double>().prod();
  if (type.kind == NumberType::Kind::Float && (type.bytes != 8 || !s.values.empty()))
    s.values.reserve(voxels);
  else
    s.whole.reserve(voxels);
}

template <class T>
std::optional<T> parsed(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  text = text.substr(0, text.find_last_not_of(kBlanks) + 1);
  if (text.starts_with('+')) text.remove_prefix(1);
  return number_in_text<T>(text);
}

}  // namespace

void append_numbers(LoadedScan& s, const NumberType& type, std::string_view bytes, const std::string& file) {
  reserve(s, type);
  for (std::size_t at = 0; at + type.bytes <= bytes.size(); at += type.bytes) {
    const std::uint64_t bits = bits_at(bytes, at, type);
    if (type.kind == NumberType::Kind::Float) {
      append_real(s, real_number(bits, type.bytes), type.bytes == 8);
    } else if (type.kind == NumberType::Kind::Unsigned) {
      if (bits > std::numeric_limits<std::int32_t>::max()) beyond(s, file, fmt::format("{}", bits));
      s.whole.push_back(static_cast<std::int32_t>(bits));
    } else {
      const int shift = 64 - 8 * type.bytes;
      append_whole(s, static_cast<std::int64_t>(bits << shift) >> shift, file);
    }
  }
}

void append_text_numbers(LoadedScan& s, const NumberType& type, std::string_view text, std::size_t count,
                         const std::string& file) {
  reserve(s, type);
  constexpr std::string_view kBetween = " \t\r\n\v\f,";
  for (std::size_t i = 0; i < count; ++i) {
    text.remove_prefix(std::min(text.find_first_not_of(kBetween), text.size()));
    const std::string_view word = text.substr(0, text.find_first_of(kBetween));
    text.remove_prefix(word.size());
    const auto bad = [&] {
      return Error("unreadable-volume",
                   word.empty()
                       ? fmt::format("'{}' has {} numbers instead of {}", file, i, count)
                       : fmt::format("'{}' has '{}' where number {} should be", file, printable(word), i + 1),
                   "check that the file is complete");
    };
    if (type.kind == NumberType::Kind::Float) {
      const auto v = number_in(word);
      if (!v) throw bad();
      append_real(s, *v, true);
    } else {
      const auto v = whole_number_in(word);
      if (!v) throw bad();
      append_whole(s, *v, file);
    }
  }
}

std::optional<double> number_in(std::string_view text) { return parsed<double>(text); }
std::optional<std::int64_t> whole_number_in(std::string_view text) { return parsed<std::int64_t>(text); }

namespace {

std::string inflate_exactly(std::string_view packed, std::size_t expected, const std::string& file) {
  const auto damaged = [&](const std::string& why) {
    return Error("unreadable-volume", "the compressed data of '" + file + "' " + why,
                 "check that the file is complete");
  };
  std::string out(expected, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 32) != Z_OK) throw damaged("cannot be read");  // zlib's header or gzip's
  std::size_t read = 0, written = 0;
  int state = Z_OK;
  constexpr std::size_t kPart = std::size_t{1} << 30;  // zlib counts with 32 bits
  while (state == Z_OK) {
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data() + read));
    stream.avail_in = static_cast<uInt>(std::min(kPart, packed.size() - read));
    char none = 0;
    const std::size_t room = std::min(kPart, expected - written);
    stream.next_out = reinterpret_cast<Bytef*>(room > 0 ? out.data() + written : &none);
    stream.avail_out = static_cast<uInt>(std::max<std::size_t>(room, 1));
    const uInt in = stream.avail_in;
    const uInt free = stream.avail_out;
    state = inflate(&stream, Z_NO_FLUSH);
    read += in - stream.avail_in;
    written += free - stream.avail_out;
    if (written > expected || (in == stream.avail_in && free == stream.avail_out)) break;
    if (state == Z_STREAM_END && written < expected && read < packed.size())
      state = inflateReset(&stream);  // gzip files may have several members
  }
  inflateEnd(&stream);
  if (state != Z_STREAM_END || written != expected)
    throw damaged(written > expected
                      ? fmt::format("has more than {} bytes", expected)
                      : fmt::format("is damaged or ends after {} of {} bytes", written, expected));
  return out;
}

}  // namespace

void take_voxels(LoadedScan& s, const StoredArray& array, const std::filesystem::path& path, const Work& work,
                 const Reading& reading) {
  const std::string file = path.string();
  const double bytes = s.size.cast<double>().prod() * static_cast<double>(array.type.bytes);
  const bool packed = array.encoding == StoredArray::Encoding::Deflated;
  require_voxels(s, file, reading, static_cast<double>(array.content) + (packed ? bytes : 0));
  const std::size_t count = s.size.cast<double>().prod();
  const auto too_short = [&](const char* unit, double needed) {
    return Error("unreadable-volume",
                 fmt::format("'{}' has {} bytes of voxels, but {} × {} × {} voxels need {:.0f} {}", file,
                             array.data.size(), s.size.x(), s.size.y(), s.size.z(), needed, unit),
                 "check that the file is complete");
  };
  work.check();
  if (array.encoding == StoredArray::Encoding::Text) {
    if (2.0 * static_cast<double>(count) - 1 > static_cast<double>(array.data.size()))
      throw too_short("or more, as text", 2.0 * static_cast<double>(count) - 1);
    append_text_numbers(s, array.type, array.data, count, file);
    return;
  }
  if (packed) check_plausible(bytes, path);
  if (!packed && bytes > static_cast<double>(array.data.size())) throw too_short("bytes", bytes);
  const std::size_t size = bytes;
  if (!packed && array.data.size() > size)
    s.notes.push_back(fmt::format("{} bytes after the voxels are ignored", array.data.size() - size));
  const std::string plain = packed ? inflate_exactly(array.data, size, file) : std::string();
  const std::string_view all = packed ? std::string_view(plain) : array.data.substr(0, size);
  constexpr std::size_t kPart = std::size_t{1} << 25;  // a multiple of every type's size
  for (std::size_t at = 0; at < all.size(); at += kPart) {
    work.check();
    append_numbers(s, array.type, all.substr(at, kPart), file);
  }
}

std::filesystem::path file_beside(const std::filesystem::path& header, const std::string& name) {
  const std::filesystem::path data(name);
  const bool below = data.is_relative() && !name.empty() &&
                     std::none_of(data.begin(), data.end(), [](const auto& part) { return part == ".."; });
  if (!below)
    throw Error("unreadable-volume",
                fmt::format("'{}' names the data file '{}', which is not in its folder", header.string(),
                            printable(name)),
                "move the data file beside the header, and name it there without a folder");
  const std::filesystem::path path = header.parent_path() / data;
  if (std::error_code error; !std::filesystem::exists(path, error) && !error)
    throw Error(
        "unreadable-file",
        fmt::format("'{}' names the data file '{}', which does not exist", header.string(), printable(name)),
        "copy the data file beside the header");
  return path;
}

}  // namespace terrazzo::load_volume
