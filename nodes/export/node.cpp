#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "graph/node_type.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/export/csv.h"
#include "nodes/export/gltf.h"
#include "nodes/export/mesh_file.h"
#include "nodes/export/picture_file.h"
#include "nodes/export/vdb_file.h"
#include "runtime/context.h"
#include "runtime/json_text.h"

namespace terrazzo {
namespace {
using namespace exporting;

// The inputs, named after their types.
struct Input {
  const char *name, *type, *doc;
};
constexpr std::array<Input, 9> inputs = {{
    {"image", "Image", "Image or stack of images"},
    {"labels", "Labels", "Profile id of each pixel"},
    {"profiles", "Profiles", "Profiles of plane sections"},
    {"shapes", "Shapes", "Shapes of the particles"},
    {"kmatrix", "KMatrix", "K matrix, the probabilities of profile sizes"},
    {"distribution", "SizeDistribution", "Number of particles per volume by size"},
    {"particles", "Particles", "Packing. A .glb file also needs shapes"},
    {"volume", "Volume", "Volume of named grids"},
    {"table", "Table", "Table of named columns"},
}};

// Extensions and the types that each can hold, used for dispatch and for error messages.
struct Format {
  const char* extension;
  std::vector<std::string> types;
};
const std::vector<Format>& formats() {
  static const std::vector<Format> all = {
      {".glb", {"Particles", "Shapes"}},
      {".vdb", {"Volume"}},
      {".png", {"Image", "Labels"}},
      {".tif", {"Image", "Labels"}},
      {".exr", {"Image", "Labels"}},
      {".jpg", {"Image"}},
      {".hdr", {"Image"}},
      {".csv", {"Table", "Profiles", "Particles", "SizeDistribution", "KMatrix", "Shapes"}},
      {".json", {}},  // anything
      {".obj", {"Shapes"}},
      {".ply", {"Shapes"}},
      {".stl", {"Shapes"}},
  };
  return all;
}

std::string joined(const std::vector<std::string>& words, const char* last) {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i)
    out += (i == 0 ? "" : i + 1 == words.size() ? std::string(" ") + last + " " : ", ") + words[i];
  return out;
}

// The connected values, by type name.
std::map<std::string, Value> connected(const Context& c) {
  std::map<std::string, Value> values;
  for (const Input& in : inputs)
    if (c.has(in.name)) values[in.type] = c.value(in.name);
  if (c.has("value")) {
    const Value& v = c.value("value");
    if (!values.emplace(v.type().name, v).second)
      throw Error("two-inputs", "both 'value' and another input have type " + v.type().name,
                  "connect only one of them");
  }
  if (values.empty()) throw Error("no-input", "nothing is connected", "connect the value to write");
  return values;
}

const Format& format_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (const Format& f : formats())
    if (extension == f.extension) return f;
  std::vector<std::string> known;
  for (const Format& f : formats()) known.push_back(f.extension);
  throw Error("unknown-format",
              extension.empty() ? "the file name has no extension"
                                : "the file extension '" + extension + "' is unknown",
              "use " + joined(known, "or"))
      .parameter("path");
}

void check_fit(const Format& format, const std::map<std::string, Value>& values) {
  if (format.types.empty()) return;
  std::vector<std::string> strangers;
  for (const auto& [type, value] : values)
    if (std::find(format.types.begin(), format.types.end(), type) == format.types.end())
      strangers.push_back(type);
  const std::string extension = format.extension;
  const std::string holds = "a " + extension + " file holds " + joined(format.types, "or");
  if (!strangers.empty())
    throw Error("format-does-not-fit", holds + ", not " + joined(strangers, "and"),
                "change the extension or the input")
        .parameter("path");
  if (values.size() > 1 && extension != ".glb")
    throw Error("format-does-not-fit", holds + ", but only one of them", "use one Export node for each")
        .parameter("path");
  if (extension == ".glb" && !values.count("Shapes"))
    throw Error("no-shapes",
                "particles are written as instances of their shapes, but 'shapes' is not connected",
                "connect the shapes used in the packing");
}

std::string csv_of_value(const Value& v) {
  if (v.is<Table>()) return csv_of(v.as<Table>());
  if (v.is<Profiles>()) return csv_of(v.as<Profiles>());
  if (v.is<Particles>()) return csv_of(v.as<Particles>());
  if (v.is<SizeDistribution>()) return csv_of(v.as<SizeDistribution>());
  if (v.is<KMatrix>()) return csv_of(v.as<KMatrix>());
  return csv_of(v.as<Shapes>());
}

std::string json_of(const std::map<std::string, Value>& values) {
  const auto describe = [](const Value& v) { return v.type().describe(v.data()); };
  if (values.size() == 1) return json_text(describe(values.begin()->second), 2) + "\n";
  nlohmann::json all = nlohmann::json::object();
  for (const auto& [type, v] : values) {
    std::string key = type;
    for (const Input& in : inputs)
      if (type == in.type) key = in.name;
    all[key] = describe(v);
  }
  return json_text(all, 2) + "\n";
}

// Writers know only the temporary name. Errors of the disk are reported with the path that the user gave.
void write_named(Context& c, const std::string& path,
                 const std::function<void(const std::filesystem::path&)>& write) {
  c.write_file(path, [&](const std::filesystem::path& file) {
    try {
      write(file);
    } catch (const Error& e) {
      const Diagnostic& d = e.diagnostic();
      if (d.code != "write-failed" && d.code != "unwritable-image") throw;
      std::string why = d.message;
      if (const auto at = why.find("': "); at != std::string::npos) why = why.substr(at + 3);
      throw Error("write-failed", "cannot write '" + path + "': " + why, d.hint).parameter("path");
    }
  });
}

// Writes one file per section.
template <class Picture, class Write>
void write_sections(Context& c, const std::string& path, const Picture& picture, Write&& write) {
  const std::string made_by = c.provenance();
  if (picture.sections < 1) throw Error("empty-image", "the image has no sections");
  for (int s = 0; s < picture.sections; ++s) {
    c.work().check();
    c.work().progress(double(s) / picture.sections);
    write_named(c, picture.sections == 1 ? path : section_name(path, s, picture.sections),
                [&](const std::filesystem::path& file) { write(file, picture, s, made_by); });
  }
}

void compute(Context& c) {
  const std::string path = c.text("path");
  const Format& format = format_of(path);
  const auto values = connected(c);
  check_fit(format, values);
  const std::string extension = format.extension;
  const Value& first = values.begin()->second;
  if (first.is<Image>() && extension != ".json")
    return write_sections(c, path, first.as<Image>(), write_picture);
  if (first.is<Labels>() && extension != ".json")
    return write_sections(c, path, first.as<Labels>(), write_labels);
  write_named(c, path, [&](const std::filesystem::path& file) {
    if (extension == ".glb") {
      const Shapes& shapes = values.at("Shapes").as<Shapes>();
      if (values.count("Particles"))
        write_glb(file, values.at("Particles").as<Particles>(), shapes, c.provenance(), c.work());
      else
        write_glb(file, shapes, c.provenance(), c.work());
    } else if (extension == ".vdb") {
      write_vdb(file, first.as<Volume>(), c.provenance());
    } else if (extension == ".csv") {
      write_bytes(file, csv_of_value(first));
    } else if (extension == ".json") {
      write_bytes(file, json_of(values));
    } else {
      write_mesh(file, first.as<Shapes>());
    }
  });
}

}  // namespace

NodeType export_node() {
  NodeType type("Export", 2);
  type.doc_(
          "Writes the connected values to a file below the output folder. The extension selects the format.")
      .source_("glTF 2.0 with EXT_mesh_gpu_instancing; OpenVDB; OpenImageIO; RFC 4180");
  for (const Input& in : inputs) type.optional_input(in.name, {in.type}, in.doc);
  return type.optional_input("value", {}, "Value of any of these types, instead of the input of that type")
      .parameter(Parameter::output_path("path").doc_("File to write: .glb (particles with shapes, or "
                                                     "shapes), .vdb (volume), .png, .jpg, .tif, .exr, .hdr "
                                                     "(images; a stack becomes name_000, name_001, …), .png, "
                                                     ".tif, .exr (labels, as exact ids), .csv (tables, "
                                                     "profiles, particles, distributions, K matrices, "
                                                     "shapes), .json (any type), .obj, .ply, .stl (shapes)."))
      .writes_files_()
      .compute_(compute);
}

}  // namespace terrazzo
