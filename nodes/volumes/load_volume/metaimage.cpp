// MetaImage of ITK, .mha and .mhd (itk.org/Wiki/ITK/MetaIO/Documentation).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "nodes/volumes/load_volume/stored_numbers.h"

namespace terrazzo::load_volume {
namespace {

Error bad_meta(const std::filesystem::path& path, const std::string& why,
               const std::string& hint = "check that the file is complete") {
  return Error("unreadable-volume", "'" + path.string() + "' cannot be read as MetaImage: " + why, hint);
}

struct MetaHeader {
  std::map<std::string, std::string> fields;
  std::size_t end = 0;  // after the line ElementDataFile, which is the last one
  std::string field(const std::string& name) const {
    const auto it = fields.find(name);
    return it == fields.end() ? std::string() : it->second;
  }
  bool yes(const std::string& name) const {
    const std::string v = field(name);
    return !v.empty() && (v[0] == 'T' || v[0] == 't' || v[0] == '1');
  }
};

std::string bare(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t\r") + 1 - first));
}

MetaHeader meta_header(std::string_view content) {
  MetaHeader out;
  const std::string_view head = content.substr(0, std::size_t{1} << 20);
  for (std::size_t at = 0; at < head.size();) {
    const std::size_t end = std::min(head.find('\n', at), head.size());
    const std::string_view line = head.substr(at, end - at);
    at = std::min(end + 1, head.size());
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) {
      if (bare(line).empty()) continue;
      break;  // no longer the header
    }
    const std::string name = bare(line.substr(0, equals));
    out.fields[name] = bare(line.substr(equals + 1));
    out.end = at;
    if (name == "ElementDataFile") break;
  }
  return out;
}

std::vector<double> numbers_in(const MetaHeader& header, std::initializer_list<const char*> names,
                               std::size_t count, const std::filesystem::path& path) {
  for (const char* name : names) {
    std::string_view rest;
    const std::string text = header.field(name);
    if (text.empty()) continue;
    std::vector<double> out;
    for (rest = text; !rest.empty();) {
      const std::size_t end = std::min(rest.find_first_of(" \t"), rest.size());
      if (end > 0) {
        const auto v = number_in(rest.substr(0, end));
        if (!v || !std::isfinite(*v)) throw bad_meta(path, fmt::format("{} is '{}'", name, printable(text)));
        out.push_back(*v);
      }
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    if (out.size() != count)
      throw bad_meta(path, fmt::format("{} has {} numbers instead of {}", name, out.size(), count));
    return out;
  }
  return {};
}

NumberType meta_type(const MetaHeader& header, const std::filesystem::path& path) {
  using Kind = NumberType::Kind;
  static const std::map<std::string, NumberType> kTypes = {
      {"MET_CHAR", {Kind::Signed, 1}},      {"MET_UCHAR", {Kind::Unsigned, 1}},
      {"MET_SHORT", {Kind::Signed, 2}},     {"MET_USHORT", {Kind::Unsigned, 2}},
      {"MET_INT", {Kind::Signed, 4}},       {"MET_UINT", {Kind::Unsigned, 4}},
      {"MET_LONG", {Kind::Signed, 4}},      {"MET_ULONG", {Kind::Unsigned, 4}},
      {"MET_LONG_LONG", {Kind::Signed, 8}}, {"MET_ULONG_LONG", {Kind::Unsigned, 8}},
      {"MET_FLOAT", {Kind::Float, 4}},      {"MET_DOUBLE", {Kind::Float, 8}}};
  const std::string name = header.field("ElementType");
  const auto found = kTypes.find(name);
  if (found == kTypes.end())
    throw bad_meta(path, "its ElementType is '" + printable(name) + "'",
                   "write it with whole numbers or floats");
  NumberType type = found->second;
  type.big_endian = header.yes("BinaryDataByteOrderMSB") || header.yes("ElementByteOrderMSB");
  return type;
}

std::filesystem::path meta_data_file(const MetaHeader& header, const std::filesystem::path& path) {
  const std::string name = header.field("ElementDataFile");
  if (name.empty()) throw bad_meta(path, "it does not say where its voxels are (ElementDataFile)");
  if (name == "LOCAL" || name == "Local" || name == "local") return path;
  if (name.starts_with("LIST") || name.find('%') != std::string::npos)
    throw bad_meta(path, "its voxels are divided into several files", "write one data file");
  return file_beside(path, name);
}

double meta_unit(const MetaHeader& header, const std::filesystem::path& path) {
  const std::string unit = header.field("DistanceUnits");
  if (unit.empty() || unit == "?" || unit == "mm") return 1;
  if (unit == "um") return 0.001;
  if (unit == "cm") return 10;
  throw bad_meta(path, "its DistanceUnits are '" + printable(unit) + "'", "use um, mm or cm");
}

void place_meta_axes(LoadedScan& s, const MetaHeader& header, std::size_t axes,
                     const std::filesystem::path& path) {
  const std::vector<double> spacing = numbers_in(header, {"ElementSpacing", "ElementSize"}, axes, path);
  for (std::size_t k = 0; k < std::min<std::size_t>(3, spacing.size()); ++k)
    s.spacing[k] = std::abs(spacing[k]) * meta_unit(header, path);
  const std::vector<double> turned =
      numbers_in(header, {"TransformMatrix", "Rotation", "Orientation"}, axes * axes, path);
  Mat3 matrix = Mat3::Identity();
  for (std::size_t k = 0; k < 3 && axes >= 3 && !turned.empty(); ++k)
    for (std::size_t i = 0; i < 3; ++i) matrix(i, k) = turned[k * axes + i];
  // A file that names an anatomical orientation has its matrix in the patient's space, whose x points to the
  // left and whose y to the back.
  const std::string anatomy = header.field("AnatomicalOrientation");
  if (!anatomy.empty() && anatomy[0] != '?') matrix = Vec3(-1, -1, 1).asDiagonal() * matrix;
  if (!matrix.allFinite() || std::abs(matrix.determinant()) < 1e-6)
    throw bad_meta(path, "its TransformMatrix is singular");
  align_axes(s, matrix);
}

// The voxels within the data file.
std::string_view meta_voxels(const MetaHeader& header, std::string_view data, bool local, double bytes,
                             const std::filesystem::path& path) {
  if (local) return data.substr(header.end);
  const std::string text = header.field("HeaderSize");
  const auto skipped = whole_number_in(text.empty() ? "0" : text);
  if (!skipped || *skipped < -1) throw bad_meta(path, "its HeaderSize is '" + printable(text) + "'");
  if (*skipped == -1)  // the voxels are at the end
    return bytes > data.size() ? data : data.substr(data.size() - static_cast<std::size_t>(bytes));
  if (static_cast<std::uint64_t>(*skipped) > data.size())
    throw bad_meta(path, "its data file ends before its voxels");
  return data.substr(*skipped);
}

}  // namespace

bool is_metaimage(const std::filesystem::path& path) {
  const std::string head = read_beginning(path, 4096);
  const MetaHeader header = meta_header(head);
  return header.fields.count("NDims") > 0 && header.fields.count("DimSize") > 0;
}

std::vector<std::filesystem::path> metaimage_companions(const std::filesystem::path& path) {
  const std::string head = read_beginning(path, std::size_t{1} << 16);
  try {
    const std::filesystem::path data = meta_data_file(meta_header(head), path);
    if (data != path) return {data};
  } catch (const Error&) {  // read_metaimage reports it
  }
  return {};
}

LoadedScan read_metaimage(const std::filesystem::path& path, const Work& work, const Reading& reading) {
  const std::string content = read_whole(path, reading);
  const MetaHeader header = meta_header(content);
  const std::filesystem::path data_path = meta_data_file(header, path);
  const auto axes = whole_number_in(header.field("NDims"));
  if (!axes || *axes < 2 || *axes > 10)
    throw bad_meta(path, "NDims is '" + printable(header.field("NDims")) + "'");
  const std::size_t dimensions = *axes;
  const std::vector<double> size = numbers_in(header, {"DimSize"}, dimensions, path);
  if (size.empty()) throw bad_meta(path, "it has no DimSize");
  LoadedScan s;
  s.size = Vec3i::Ones();
  for (std::size_t k = 0; k < dimensions; ++k) {
    if (!(size[k] >= 1) || size[k] > (1 << 24) || size[k] != std::floor(size[k]))
      throw bad_meta(path, fmt::format("axis {} has {} voxels", k, size[k]));
    if (k < 3) s.size[k] = static_cast<int>(size[k]);
    if (k >= 3 && size[k] > 1)
      throw Error(
          "not-a-volume",
          fmt::format("'{}' has {} axes, the last with {} entries", path.string(), dimensions, size[k]),
          "extract one volume");
  }
  const std::string channels = header.field("ElementNumberOfChannels");
  if (!channels.empty() && channels != "1")
    throw Error("not-a-volume",
                fmt::format("'{}' has {} numbers per voxel", path.string(), printable(channels)),
                "extract one component");
  StoredArray array;
  array.type = meta_type(header, path);
  const std::string binary = header.field("BinaryData");
  if (!binary.empty() && !header.yes("BinaryData")) array.encoding = StoredArray::Encoding::Text;
  if (header.yes("CompressedData")) array.encoding = StoredArray::Encoding::Deflated;
  const bool local = data_path == path;
  const std::string other = local ? std::string() : read_whole(data_path, reading);
  const double bytes = s.size.cast<double>().prod() * array.type.bytes;
  array.data =
      meta_voxels(header, local ? std::string_view(content) : std::string_view(other), local, bytes, path);
  array.content = content.size() + other.size();
  take_voxels(s, array, data_path, work, reading);
  place_meta_axes(s, header, dimensions, path);
  return s;
}

}  // namespace terrazzo::load_volume
