#include "nodes/volumes/load_volume/vti_layout.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <pugixml.hpp>

#include "graph/diagnostic.h"
#include "nodes/volumes/load_volume/stored_numbers.h"
#include "runtime/files/base64.h"

namespace terrazzo::load_volume {
namespace {

Error bad_vti(const std::string& what) {
  return Error("unreadable-volume", what, "check that the file is complete");
}

// Removes the first word from `rest` and returns it; "" at the end.
std::string_view next_word(std::string_view& rest) {
  constexpr std::string_view kBlanks = " \t\r\n";
  rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
  const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
  rest.remove_prefix(word.size());
  return word;
}

template <std::size_t N>
std::array<double, N> numbers_of(const pugi::xml_node& node, const char* attribute,
                                 std::array<double, N> otherwise) {
  const pugi::xml_attribute a = node.attribute(attribute);
  if (!a) return otherwise;
  std::string_view rest = a.value();
  for (double& v : otherwise) {
    const auto number = number_in(next_word(rest));
    if (!number || !std::isfinite(*number))
      throw bad_vti(fmt::format("{} is '{}'", attribute, printable(a.value())));
    v = *number;
  }
  return otherwise;
}

// The bytes of an encoded or raw piece of data that starts with its lengths.
class VtiPiece {
 public:
  VtiPiece(std::string_view data, bool base64) : data_(data), base64_(base64) {}
  // The next `count` bytes of one encoded sequence; `all`: everything that is left.
  std::string take(std::size_t count) {
    if (!base64_) {
      if (count > data_.size()) throw bad_vti("its data is truncated");
      std::string out(data_.substr(0, count));
      data_.remove_prefix(count);
      return out;
    }
    const std::size_t digits = (count + 2) / 3 * 4;
    std::string out;
    if (count > data_.size() || digits > data_.size()) throw bad_vti("its data is truncated");
    if (!decode_base64(data_.substr(0, digits), out) || out.size() < count)
      throw bad_vti("its data is not valid base64");
    data_.remove_prefix(digits);
    out.resize(count);
    return out;
  }
  // Like take, but leaves the position, to look at a header of unknown length.
  std::string look(std::size_t count) const { return VtiPiece(*this).take(count); }
  // A header of `header` bytes and what follows it. Some programs encode both together, others each by
  // itself, which padding after the header shows. (Without padding both come to the same.)
  std::string take_after(std::size_t header, std::size_t count) {
    const std::size_t digits = (header + 2) / 3 * 4;
    if (base64_ && digits <= data_.size() && data_[digits - 1] == '=') {
      take(header);
      return take(count);
    }
    return take(header + count).substr(header);
  }

 private:
  std::string_view data_;
  bool base64_;
};

std::uint64_t length_at(const std::string& bytes, std::size_t index, const VtiLayout& layout) {
  const std::size_t word = layout.word();
  std::uint64_t v = 0;
  for (std::size_t k = 0; k < word; ++k)
    v = v << 8 | static_cast<unsigned char>(bytes[index * word + (layout.big_endian ? k : word - 1 - k)]);
  return v;
}

std::string inflate_blocks(VtiPiece piece, const VtiLayout& layout, std::size_t expected) {
  const std::size_t word = layout.word();
  const std::string first = piece.look(3 * word);
  const std::uint64_t blocks = length_at(first, 0, layout), size = length_at(first, 1, layout),
                      rest = length_at(first, 2, layout);
  if (blocks == 0) return {};
  // A single block may be smaller than the nominal size. Every block has at least one byte.
  constexpr std::uint64_t kLargest = std::uint64_t{1} << 40;
  const std::uint64_t last = rest ? rest : size;
  if (blocks > expected || size > kLargest || last > expected || (blocks > 1 && size > expected) ||
      (blocks - 1) * size + last != expected)
    throw bad_vti("the sizes of its compressed blocks do not fit the array");
  const std::size_t header_bytes = (3 + static_cast<std::size_t>(blocks)) * word;
  const std::string header = piece.look(header_bytes);
  std::uint64_t packed_bytes = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::uint64_t p = length_at(header, 3 + b, layout);
    if (p > (std::uint64_t{1} << 40)) throw bad_vti("a compressed block is too large");
    packed_bytes += p;
  }
  const std::string packed = piece.take_after(header_bytes, packed_bytes);
  std::string out(expected, '\0');
  std::size_t from = 0, to = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t p = length_at(header, 3 + b, layout);
    const std::size_t u = b + 1 == blocks && rest ? rest : size;
    uLongf written = u;
    if (uncompress(reinterpret_cast<Bytef*>(out.data() + to), &written,
                   reinterpret_cast<const Bytef*>(packed.data() + from), p) != Z_OK ||
        written != u)
      throw bad_vti("its compressed data is damaged");
    from += p;
    to += u;
  }
  return out;
}

std::string ascii_bytes(const VtiArrayText& array, std::size_t bytes, std::size_t count) {
  std::string out;
  std::string_view rest = array.text;
  const bool floats = array.type.starts_with("Float"), is_signed = array.type.starts_with("Int");
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view word = next_word(rest);
    if (word.empty())
      throw bad_vti(fmt::format("array '{}' has {} numbers instead of {}", printable(array.name), i, count));
    const auto real = number_in(word);
    const auto whole = whole_number_in(word);
    if (!real || (!floats && !whole))
      throw bad_vti(fmt::format("array '{}' of {} has '{}' as number {}", printable(array.name),
                                printable(array.type), printable(word), i + 1));
    if (floats) {
      const float single = *real;
      out.append(bytes == 4 ? reinterpret_cast<const char*>(&single) : reinterpret_cast<const char*>(&*real),
                 bytes);
      continue;
    }
    // The lowest bytes of the number are the number of the smaller type, if they can hold it.
    const int bits = 8 * bytes;
    const std::int64_t least = is_signed ? (bits == 64 ? *whole : -(std::int64_t{1} << (bits - 1))) : 0,
                       most = bits == 64 ? *whole : (std::int64_t{1} << (is_signed ? bits - 1 : bits)) - 1;
    if (*whole < least || *whole > most)
      throw bad_vti(fmt::format("{} is beyond {}, the type of array '{}'", *whole, printable(array.type),
                                printable(array.name)));
    out.append(reinterpret_cast<const char*>(&*whole), bytes);
  }
  return out;
}

VtiArrayText array_text(const pugi::xml_node& node) {
  VtiArrayText a;
  a.name = node.attribute("Name").value();
  a.type = node.attribute("type").value();
  a.format = node.attribute("format").as_string("ascii");
  a.components = node.attribute("NumberOfComponents").as_int(1);
  a.offset = node.attribute("offset").as_ullong(0);
  a.text = node.child_value();
  return a;
}

// The text of the file. Finds its appended data, which need not be XML, so the text ends where it begins.
std::string vti_text(const std::string& content, VtiLayout& out) {
  const auto appended = content.find("<AppendedData");
  std::string xml = content.substr(0, appended);
  if (appended == std::string::npos) return xml;
  const auto close = content.find('>', appended);
  const auto begin = content.find('_', close == std::string::npos ? content.size() : close);
  if (begin == std::string::npos) throw bad_vti("its appended data is truncated");
  out.appended_at = begin + 1;
  out.raw = content.substr(appended, close - appended).find("raw") != std::string::npos;
  return xml + "</VTKFile>";
}

void read_encoding(const pugi::xml_node& file, VtiLayout& out) {
  const std::string byte_order = file.attribute("byte_order").as_string("LittleEndian");
  out.big_endian = byte_order == "BigEndian";
  if (!out.big_endian && byte_order != "LittleEndian")
    throw bad_vti("its byte order is '" + printable(byte_order) + "'");
  const std::string compressor = file.attribute("compressor").value();
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
    throw Error("unreadable-volume", "it is compressed by '" + printable(compressor) + "'",
                "write it with zlib or without compression");
  out.compressed = !compressor.empty();
  out.wide = std::string(file.attribute("header_type").value()) == "UInt64";
}

void read_lattice(const pugi::xml_node& image, const std::array<double, 6>& extent, VtiLayout& out) {
  const auto direction = numbers_of<9>(image, "Direction", {1, 0, 0, 0, 1, 0, 0, 0, 1});
  if (direction != std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1})
    throw Error("not-a-volume", "its axes are rotated", "resample it along x, y and z");
  const auto origin = numbers_of<3>(image, "Origin", {0, 0, 0}),
             spacing = numbers_of<3>(image, "Spacing", {1, 1, 1});
  double voxels = 1;
  for (int k = 0; k < 3; ++k) {
    const double a = extent[2 * k], b = extent[2 * k + 1];
    if (!(std::abs(a) < (1 << 20)) || !(b > a) || !(b - a <= (1 << 24)))
      throw bad_vti(fmt::format("its extent along axis {} is {} to {}", k, a, b));
    out.start[k] = static_cast<int>(a);
    out.size[k] = static_cast<int>(b - a);
    out.origin[k] = origin[k];
    out.spacing[k] = spacing[k];
    voxels *= b - a;
  }
  if (voxels > 2147483648.0)
    throw Error("too-large", fmt::format("it has {:.4g} voxels, more than 2^31", voxels),
                "crop or downsample it first");
}

}  // namespace

VtiLayout vti_layout(const std::string& content, const Reading& reading) {
  VtiLayout out;
  const std::string xml = vti_text(content, out);
  // Parsed text needs several times its length.
  require_memory(4.0 * double(xml.size()), reading.memory, "the text of the file");
  pugi::xml_document document;
  if (const auto result = document.load_buffer(xml.data(), xml.size()); !result)
    throw bad_vti(std::string("its XML is damaged: ") + result.description());
  const auto file = document.child("VTKFile");
  const std::string type = file.attribute("type").value();
  if (type != "ImageData")
    throw Error("not-a-volume", "it contains '" + printable(type) + "' instead of ImageData",
                "export it as image data");
  read_encoding(file, out);
  const auto image = file.child("ImageData");
  const auto extent = numbers_of<6>(image, "WholeExtent", {});
  read_lattice(image, extent, out);
  const auto piece = image.child("Piece");
  if (piece.next_sibling("Piece")) throw Error("not-a-volume", "it has several pieces", "merge them first");
  if (piece.attribute("Extent") && numbers_of<6>(piece, "Extent", {}) != extent)
    throw Error("not-a-volume", "its piece is only a part of the whole extent", "merge the pieces first");
  for (const auto& field : image.child("FieldData").children("DataArray"))
    if (std::string(field.attribute("Name").value()) == "period" &&
        std::string(field.attribute("type").value()) == "Int32") {
      const std::string bytes = vti_bytes(content, out, array_text(field), 4, 3);
      std::memcpy(out.period.data(), bytes.data(), 12);
    }
  if (piece.child("PointData").child("DataArray"))
    reading.warn("the file's point data is left out; only cell data has one value per voxel");
  for (const auto& node : piece.child("CellData").children("DataArray")) {
    VtiArrayText a = array_text(node);
    if (a.components == 1 || a.components == 3)
      out.cells.push_back(std::move(a));
    else
      reading.warn(
          fmt::format("array '{}' has {} components and is left out", printable(a.name), a.components));
  }
  if (out.cells.empty())
    throw Error("not-a-volume", "it has no cell data", "convert point data to cell data first");
  return out;
}

std::string vti_bytes(std::string_view content, const VtiLayout& layout, const VtiArrayText& array,
                      std::size_t bytes, std::size_t count) {
  const std::size_t expected = bytes * count;
  if (array.format == "ascii") return ascii_bytes(array, bytes, count);
  std::string_view data = array.text;
  bool base64 = true;
  if (array.format == "appended") {
    if (layout.appended_at == 0 || array.offset > content.size() - layout.appended_at)
      throw bad_vti("its appended data is truncated");
    data = content.substr(layout.appended_at + array.offset);
    base64 = !layout.raw;
  } else if (array.format != "binary") {
    throw bad_vti("array '" + printable(array.name) + "' has the format '" + printable(array.format) + "'");
  }
  std::string digits;  // without the line ends that some programs put between them
  if (array.format == "binary") {
    const auto blank = [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; };
    std::copy_if(data.begin(), data.end(), std::back_inserter(digits), [&](char c) { return !blank(c); });
    data = digits;
  }
  VtiPiece piece(data, base64);
  std::string out;
  if (layout.compressed) {
    out = inflate_blocks(piece, layout, expected);
  } else {
    const std::uint64_t length = length_at(piece.look(layout.word()), 0, layout);
    if (length != expected)
      throw bad_vti(
          fmt::format("array '{}' has {} bytes instead of {}", printable(array.name), length, expected));
    out = piece.take_after(layout.word(), expected);
  }
  if (out.size() != expected)
    throw bad_vti(
        fmt::format("array '{}' has {} bytes instead of {}", printable(array.name), out.size(), expected));
  if (layout.big_endian)
    for (std::size_t at = 0; at < out.size(); at += bytes)
      std::reverse(out.data() + at, out.data() + at + bytes);
  return out;
}

}  // namespace terrazzo::load_volume
