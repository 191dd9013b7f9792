// Nearly raw raster data, versions 1 to 5 (teem.sourceforge.net/nrrd/format.html).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "nodes/volumes/load_volume/stored_numbers.h"

namespace terrazzo::load_volume {
namespace {

constexpr std::size_t kLongestHeader = std::size_t{1} << 20;

Error bad_nrrd(const std::filesystem::path& path, const std::string& why,
               const std::string& hint = "check that the file is complete") {
  return Error("unreadable-volume", "'" + path.string() + "' cannot be read as NRRD: " + why, hint);
}

struct NrrdHeader {
  std::map<std::string, std::string> fields;  // in lower case, "datafile" as "data file" and so on
  std::size_t end = 0;                        // after the empty line
  bool complete = false;                      // whether there is an empty line
  std::string field(const std::string& name) const {
    const auto it = fields.find(name);
    return it == fields.end() ? std::string() : it->second;
  }
};

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = c - 'A' + 'a';
  return text;
}

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t\r") + 1 - first));
}

NrrdHeader nrrd_header(std::string_view content) {
  static const std::map<std::string, std::string> kOtherNames = {
      {"datafile", "data file"}, {"byteskip", "byte skip"}, {"lineskip", "line skip"}};
  NrrdHeader out;
  const std::string_view head = content.substr(0, kLongestHeader);
  for (std::size_t at = 0; at < head.size();) {
    const std::size_t end = std::min(head.find('\n', at), head.size());
    const std::string line = trimmed(head.substr(at, end - at));
    at = std::min(end + 1, head.size());
    out.end = at;
    if (line.empty()) {
      out.complete = true;
      return out;
    }
    const std::size_t colon = line.find(':');
    // Comments, and keys with values of the writer's own (name:=value), say nothing about the voxels.
    if (line[0] == '#' || colon == std::string::npos || line.substr(colon).starts_with(":=")) continue;
    std::string name = lower(line.substr(0, colon));
    if (const auto other = kOtherNames.find(name); other != kOtherNames.end()) name = other->second;
    out.fields[name] = trimmed(line.substr(colon + 1));
  }
  return out;
}

// Words separated by blanks; text in quotes or parentheses is one word, without its quotes.
std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> out;
  for (std::size_t at = text.find_first_not_of(" \t"); at != std::string::npos;
       at = text.find_first_not_of(" \t", at)) {
    const char close = text[at] == '"' ? '"' : text[at] == '(' ? ')' : ' ';
    const bool quoted = close == '"';
    std::size_t end = close == ' ' ? text.find_first_of(" \t", at) : text.find(close, at + 1);
    if (end == std::string::npos) end = text.size();
    if (close == ')') end = std::min(end + 1, text.size());
    out.push_back(text.substr(at + quoted, end - at - quoted));
    at = std::min(end + quoted, text.size());
  }
  return out;
}

NumberType nrrd_type(const NrrdHeader& header, const std::filesystem::path& path) {
  using Kind = NumberType::Kind;
  static const std::map<std::string, NumberType> kTypes = [] {
    std::map<std::string, NumberType> types;
    const auto add = [&](NumberType type, std::initializer_list<const char*> names) {
      for (const char* name : names) types[name] = type;
    };
    add({Kind::Signed, 1}, {"signed char", "int8", "int8_t"});
    add({Kind::Unsigned, 1}, {"uchar", "unsigned char", "uint8", "uint8_t"});
    add({Kind::Signed, 2}, {"short", "short int", "signed short", "signed short int", "int16", "int16_t"});
    add({Kind::Unsigned, 2}, {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"});
    add({Kind::Signed, 4}, {"int", "signed int", "int32", "int32_t"});
    add({Kind::Unsigned, 4}, {"uint", "unsigned int", "uint32", "uint32_t"});
    add({Kind::Signed, 8}, {"longlong", "long long", "long long int", "signed long long",
                            "signed long long int", "int64", "int64_t"});
    add({Kind::Unsigned, 8},
        {"ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"});
    add({Kind::Float, 4}, {"float"});
    add({Kind::Float, 8}, {"double"});
    return types;
  }();
  const std::string name = lower(header.field("type"));
  const auto found = kTypes.find(name);
  if (found == kTypes.end())
    throw bad_nrrd(path, name.empty() ? "it does not name its type" : "its type is '" + printable(name) + "'",
                   "write it with whole numbers or floats");
  NumberType type = found->second;
  const std::string endian = lower(header.field("endian")), encoding = lower(header.field("encoding"));
  const bool text = encoding == "txt" || encoding == "text" || encoding == "ascii";
  if (type.bytes > 1 && !text && endian != "little" && endian != "big")
    throw bad_nrrd(path, endian.empty() ? "it does not name its byte order"
                                        : "its byte order is '" + printable(endian) + "'");
  type.big_endian = endian == "big";
  return type;
}

struct NrrdAxis {
  std::int64_t size = 0;
  double spacing = 0;  // in the file's unit; 0 if unknown
  std::optional<Vec3> direction;
  std::string unit;
};

std::optional<Vec3> vector_in(const std::string& word) {
  if (!word.starts_with('(') || !word.ends_with(')')) return {};
  Vec3 out = Vec3::Zero();
  std::string_view rest(word);
  rest = rest.substr(1, rest.size() - 2);
  for (int k = 0; k < 3; ++k) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const auto v = number_in(rest.substr(0, comma));
    if (!v || (k < 2) != (comma < rest.size())) return {};
    out[k] = *v;
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return out.allFinite() && out.norm() > 0 ? std::optional(out) : std::nullopt;
}

std::vector<NrrdAxis> nrrd_axes(const NrrdHeader& header, const std::filesystem::path& path) {
  const auto dimension = whole_number_in(header.field("dimension"));
  const auto sizes = words_of(header.field("sizes"));
  if (!dimension || *dimension < 1 || *dimension > 16 || sizes.size() != static_cast<std::size_t>(*dimension))
    throw bad_nrrd(path, fmt::format("its dimension is '{}' and its sizes '{}'",
                                     printable(header.field("dimension")), printable(header.field("sizes"))));
  const auto spacings = words_of(header.field("spacings")),
             directions = words_of(header.field("space directions")), units = words_of(header.field("units")),
             space_units = words_of(header.field("space units"));
  std::vector<NrrdAxis> out;
  std::size_t in_space = 0;
  for (std::size_t a = 0; a < sizes.size(); ++a) {
    NrrdAxis axis;
    const auto size = whole_number_in(sizes[a]);
    if (!size || *size < 1) throw bad_nrrd(path, "an axis has the size '" + printable(sizes[a]) + "'");
    axis.size = *size;
    if (a < directions.size() && lower(directions[a]) != "none") {
      axis.direction = vector_in(directions[a]);
      if (!axis.direction)
        throw bad_nrrd(path,
                       "a space direction is '" + printable(directions[a]) + "' instead of three numbers");
      axis.spacing = axis.direction->norm();
      // Units of space belong to the axes of space, which may be turned; all of them are equal in practice.
      if (in_space < space_units.size()) axis.unit = space_units[in_space];
      ++in_space;
    } else if (a < spacings.size()) {
      const auto v = number_in(spacings[a]);
      axis.spacing = v && std::isfinite(*v) ? std::abs(*v) : 0;
      if (a < units.size()) axis.unit = units[a];
    }
    out.push_back(axis);
  }
  return out;
}

// The three axes of the volume: others must have the size 1. Two axes are a volume of one slice.
void leave_three(std::vector<NrrdAxis>& axes, const std::filesystem::path& path) {
  const auto drop = [&](auto&& useless) {
    for (std::size_t a = axes.size(); a-- > 0 && axes.size() > 3;)
      if (axes[a].size == 1 && useless(axes[a])) axes.erase(axes.begin() + a);
  };
  drop([](const NrrdAxis& a) { return a.spacing == 0; });
  drop([](const NrrdAxis&) { return true; });
  if (axes.size() > 3) {
    std::string sizes;
    for (const NrrdAxis& a : axes) sizes += (sizes.empty() ? "" : " × ") + std::to_string(a.size);
    throw Error("not-a-volume",
                fmt::format("'{}' is an array of {} numbers; a volume has three axes", path.string(), sizes),
                "extract one component or one time");
  }
  while (axes.size() < 3) axes.push_back({1, 0, {}, ""});
}

double mm_per_unit(const std::string& unit, const std::filesystem::path& path) {
  static const std::map<std::string, double> kUnits = {
      {"", 1},       {"mm", 1},           {"millimeter", 1},    {"millimeters", 1},    {"cm", 10},
      {"m", 1000},   {"meter", 1000},     {"meters", 1000},     {"um", 0.001},         {"µm", 0.001},
      {"μm", 0.001}, {"micron", 0.001},   {"microns", 0.001},   {"micrometer", 0.001}, {"micrometers", 0.001},
      {"nm", 1e-6},  {"nanometer", 1e-6}, {"nanometers", 1e-6}, {"centimeter", 10},    {"centimeters", 10}};
  const auto it = kUnits.find(lower(trimmed(unit)));
  if (it == kUnits.end())
    throw bad_nrrd(path, "its lengths have the unit '" + printable(unit) + "'", "use mm, cm, m, um or nm");
  return it->second;
}

// The axes of the file's space, in one with x to the right, y to the front and z to the head.
Vec3 space_signs(const std::string& space) {
  const auto is = [&](std::string_view words, std::string_view letters) {
    return space.starts_with(words) || space == letters || space == std::string(letters) + "t";
  };
  if (is("left-posterior-superior", "lps")) return {-1, -1, 1};
  if (is("left-anterior-superior", "las")) return {-1, 1, 1};
  return {1, 1, 1};
}

void place_axes(LoadedScan& s, const std::vector<NrrdAxis>& axes, const std::string& space,
                const std::filesystem::path& path) {
  bool turned = true, united = true;
  for (int k = 0; k < 3; ++k) {
    const NrrdAxis& axis = axes[k];
    s.spacing[k] = axis.spacing * mm_per_unit(axis.unit, path);
    turned = turned && axis.direction;
    united = united && (!axis.unit.empty() || axis.spacing == 0);
  }
  if (!united && (space.empty() || space.starts_with("3d")) && s.spacing.maxCoeff() > 0)
    s.notes.push_back("the file does not name the unit of its lengths; mm is assumed");
  if (!turned) return;
  Mat3 matrix;
  const Vec3 signs = space_signs(space);
  for (int k = 0; k < 3; ++k) matrix.col(k) = signs.cwiseProduct(*axes[k].direction);
  if (std::abs(matrix.determinant()) < 1e-9 * s.spacing.prod())
    throw bad_nrrd(path, "its space directions lie in one plane");
  align_axes(s, matrix);
}

// The file that holds the voxels: the header's own or another one beside it.
std::filesystem::path nrrd_data_file(const NrrdHeader& header, const std::filesystem::path& path) {
  const std::string name = header.field("data file");
  if (name.empty()) return path;
  if (name.starts_with("LIST") || name.find('%') != std::string::npos)
    throw bad_nrrd(path, "its voxels are divided into several files",
                   "write one data file, for example with unu save");
  return file_beside(path, name);
}

// The part of the data file that begins with the first voxel, if they are not compressed.
std::string_view after_skips(std::string_view data, const NrrdHeader& header, double bytes,
                             const std::filesystem::path& path) {
  const auto skip = [&](const char* name) {
    const std::string text = header.field(name);
    const auto v = whole_number_in(text.empty() ? "0" : text);
    if (!v || *v < -1) throw bad_nrrd(path, fmt::format("its {} is '{}'", name, printable(text)));
    return *v;
  };
  for (std::int64_t lines = skip("line skip"); lines > 0; --lines) {
    const std::size_t end = data.find('\n');
    if (end == std::string_view::npos) throw bad_nrrd(path, "it has fewer lines than line skip says");
    data.remove_prefix(end + 1);
  }
  const std::int64_t skipped = skip("byte skip");
  if (skipped == -1) {  // the voxels are at the end
    if (bytes > data.size()) return data;
    return data.substr(data.size() - static_cast<std::size_t>(bytes));
  }
  if (static_cast<std::uint64_t>(skipped) > data.size()) throw bad_nrrd(path, "it ends before its voxels");
  return data.substr(skipped);
}

StoredArray::Encoding nrrd_encoding(const NrrdHeader& header, const std::filesystem::path& path) {
  const std::string name = lower(header.field("encoding"));
  if (name == "raw") return StoredArray::Encoding::Raw;
  if (name == "gz" || name == "gzip") return StoredArray::Encoding::Deflated;
  if (name == "txt" || name == "text" || name == "ascii") return StoredArray::Encoding::Text;
  throw bad_nrrd(path, "its encoding is '" + printable(name) + "'",
                 "write it with the encoding raw, gzip or ascii");
}

}  // namespace

bool is_nrrd(const std::filesystem::path& path) { return read_beginning(path, 4) == "NRRD"; }

std::vector<std::filesystem::path> nrrd_companions(const std::filesystem::path& path) {
  const std::string head = read_beginning(path, std::size_t{1} << 16);
  try {
    const std::filesystem::path data = nrrd_data_file(nrrd_header(head), path);
    if (data != path) return {data};
  } catch (const Error&) {  // read_nrrd reports it
  }
  return {};
}

LoadedScan read_nrrd(const std::filesystem::path& path, const Work& work, const Reading& reading) {
  const std::string content = read_whole(path, reading);
  const NrrdHeader header = nrrd_header(content);
  const std::filesystem::path data_path = nrrd_data_file(header, path);
  const bool attached = data_path == path;
  if (attached && !header.complete) throw bad_nrrd(path, "its header has no end");
  std::vector<NrrdAxis> axes = nrrd_axes(header, path);
  leave_three(axes, path);
  LoadedScan s;
  for (int k = 0; k < 3; ++k) {
    const std::int64_t n = axes[k].size;
    if (n > (1 << 24)) throw bad_nrrd(path, fmt::format("axis {} has {} voxels", k, n));
    s.size[k] = n;
  }
  StoredArray array;
  array.type = nrrd_type(header, path);
  array.encoding = nrrd_encoding(header, path);
  const std::string other = attached ? std::string() : read_whole(data_path, reading);
  const double bytes = s.size.cast<double>().prod() * array.type.bytes;
  array.data = attached ? std::string_view(content).substr(header.end) : std::string_view(other);
  array.content = content.size() + other.size();
  if (array.encoding != StoredArray::Encoding::Deflated)
    array.data = after_skips(array.data, header, bytes, path);
  else if (!header.field("byte skip").empty() && header.field("byte skip") != "0")
    throw bad_nrrd(path, "it skips bytes of compressed data", "write it without byte skip");
  take_voxels(s, array, data_path, work, reading);
  place_axes(s, axes, lower(header.field("space")), path);
  return s;
}

}  // namespace terrazzo::load_volume
