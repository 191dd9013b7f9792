#include "nodes/load_volume/vti_layout.h"

#include <fmt/format.h>
#include <zlib.h>

#include <array>

#include <cmath>
#include <cstring>
#include <pugixml.hpp>

#include "graph/diagnostic.h"
#include "runtime/base64.h"

namespace terrazzo::load_volume {
namespace {

Error bad_vti(const std::string& what) {
  return Error("unreadable-volume", what, "check that the file is complete");
}

template <std::size_t N>
std::array<double, N> numbers_of(const pugi::xml_node& node, const char* attribute,
                                 std::array<double, N> otherwise) {
  const pugi::xml_attribute a = node.attribute(attribute);
  if (!a) return otherwise;
  const char* at = a.value();
  for (double& v : otherwise) {
    char* end = nullptr;
    v = std::strtod(at, &end);
    if (end == at || !std::isfinite(v))
      throw bad_vti(fmt::format("{} is '{}'", attribute, printable(a.value())));
    at = end;
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

 private:
  std::string_view data_;
  bool base64_;
};

std::uint64_t length_at(const std::string& bytes, std::size_t index, bool wide) {
  std::uint64_t v = 0;
  std::memcpy(&v, bytes.data() + index * (wide ? 8 : 4), wide ? 8 : 4);
  return v;
}

std::string inflate_blocks(VtiPiece piece, bool wide, std::size_t expected) {
  const std::size_t word = wide ? 8 : 4;
  const std::string first = piece.look(3 * word);
  const std::uint64_t blocks = length_at(first, 0, wide), size = length_at(first, 1, wide),
                      rest = length_at(first, 2, wide);
  if (blocks == 0) return {};
  // A single block may be smaller than the nominal size. Every block has at least one byte.
  constexpr std::uint64_t kLargest = std::uint64_t{1} << 40;
  const std::uint64_t last = rest ? rest : size;
  if (blocks > expected || size > kLargest || last > expected || (blocks > 1 && size > expected) ||
      (blocks - 1) * size + last != expected)
    throw bad_vti("the sizes of its compressed blocks do not fit the array");
  const std::string header = piece.take((3 + static_cast<std::size_t>(blocks)) * word);
  std::uint64_t packed_bytes = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::uint64_t p = length_at(header, 3 + b, wide);
    if (p > (std::uint64_t{1} << 48)) throw bad_vti("a compressed block is too large");
    packed_bytes += p;
  }
  const std::string packed = piece.take(static_cast<std::size_t>(packed_bytes));
  std::string out(expected, '\0');
  std::size_t from = 0, to = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto p = static_cast<std::size_t>(length_at(header, 3 + b, wide));
    const auto u = static_cast<std::size_t>(b + 1 == blocks && rest ? rest : size);
    uLongf written = u;
    if (uncompress(reinterpret_cast<Bytef*>(out.data() + to), &written,
                   reinterpret_cast<const Bytef*>(packed.data() + from), p) != Z_OK ||
        written != u)
      throw bad_vti("its compressed data is damaged");
    from += p, to += u;
  }
  return out;
}

std::string ascii_bytes(const VtiArrayText& array, std::size_t bytes, std::size_t count) {
  std::string out;
  const char* at = array.text.c_str();
  for (std::size_t i = 0; i < count; ++i) {
    char* end = nullptr;
    const double v = std::strtod(at, &end);
    if (end == at)
      throw bad_vti(fmt::format("array '{}' has {} numbers instead of {}", printable(array.name), i, count));
    at = end;
    const auto put = [&](auto typed) { out.append(reinterpret_cast<const char*>(&typed), sizeof typed); };
    const bool floats = array.type.starts_with("Float"), is_signed = array.type.starts_with("Int");
    if (!floats && !(std::abs(v) < 9e15)) throw bad_vti("a whole number is too large");
    if (floats)
      bytes == 4 ? put(static_cast<float>(v)) : put(v);
    else if (is_signed)
      bytes == 1   ? put(static_cast<std::int8_t>(v))
      : bytes == 2 ? put(static_cast<std::int16_t>(v))
      : bytes == 4 ? put(static_cast<std::int32_t>(v))
                   : put(static_cast<std::int64_t>(v));
    else
      bytes == 1   ? put(static_cast<std::uint8_t>(v))
      : bytes == 2 ? put(static_cast<std::uint16_t>(v))
      : bytes == 4 ? put(static_cast<std::uint32_t>(v))
                   : put(static_cast<std::uint64_t>(v));
  }
  return out;
}

VtiArrayText array_text(const pugi::xml_node& node) {
  VtiArrayText a;
  a.name = node.attribute("Name").value(), a.type = node.attribute("type").value();
  a.format = node.attribute("format").as_string("ascii");
  a.components = node.attribute("NumberOfComponents").as_int(1);
  a.offset = node.attribute("offset").as_ullong(0);
  a.text = node.child_value();
  return a;
}

}  // namespace

VtiLayout vti_layout(const std::string& content, const Reading& reading) {
  VtiLayout out;
  // Raw appended data is not XML, so the text ends where it begins.
  const auto appended = content.find("<AppendedData");
  std::string xml = content.substr(0, appended);
  if (appended != std::string::npos) {
    const auto begin = content.find(
        '_', content.find('>', appended) == std::string::npos ? content.size() : content.find('>', appended));
    if (begin == std::string::npos) throw bad_vti("its appended data is truncated");
    out.appended_at = begin + 1;
    out.raw =
        content.substr(appended, content.find('>', appended) - appended).find("raw") != std::string::npos;
    xml += "</VTKFile>";
  }
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
  if (std::string(file.attribute("byte_order").as_string("LittleEndian")) != "LittleEndian")
    throw bad_vti("its bytes are in big-endian order");
  const std::string compressor = file.attribute("compressor").value();
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
    throw Error("unreadable-volume", "it is compressed by '" + printable(compressor) + "'",
                "write it with zlib or without compression");
  out.compressed = !compressor.empty();
  out.wide = std::string(file.attribute("header_type").value()) == "UInt64";
  const auto image = file.child("ImageData");
  const auto extent = numbers_of<6>(image, "WholeExtent", {});
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
    out.start[k] = static_cast<int>(a), out.size[k] = static_cast<int>(b - a);
    out.origin[k] = origin[k], out.spacing[k] = spacing[k];
    voxels *= b - a;
  }
  if (voxels > 2147483648.0)
    throw Error("too-large", fmt::format("it has {:.4g} voxels, more than 2^31", voxels),
                "crop or downsample it first");
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
    data = content.substr(layout.appended_at + static_cast<std::size_t>(array.offset));
    base64 = !layout.raw;
  } else if (array.format != "binary") {
    throw bad_vti("array '" + printable(array.name) + "' has the format '" + printable(array.format) + "'");
  }
  const auto blank = [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; };
  if (array.format == "binary")
    while (!data.empty() && blank(data.front())) data.remove_prefix(1);
  VtiPiece piece(data, base64);
  std::string out;
  if (layout.compressed) {
    out = inflate_blocks(piece, layout.wide, expected);
  } else {
    const std::size_t word = layout.wide ? 8 : 4;
    if (length_at(piece.look(word), 0, layout.wide) != expected)
      throw bad_vti(fmt::format("array '{}' has {} bytes instead of {}", printable(array.name),
                                length_at(piece.look(word), 0, layout.wide), expected));
    out = piece.take(word + expected).substr(word);  // encoded together
  }
  if (out.size() != expected)
    throw bad_vti(
        fmt::format("array '{}' has {} bytes instead of {}", printable(array.name), out.size(), expected));
  return out;
}

}  // namespace terrazzo::load_volume
