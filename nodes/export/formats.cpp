#include "nodes/export/formats.h"

#include <algorithm>
#include <filesystem>

#include "graph/diagnostic.h"

namespace terrazzo::exporting {
namespace {

const std::vector<Format>& formats() {
  static const std::vector<Format> all = {
      {".glb", {"Particles", "Shapes", "Image"}, {"Shapes"}, true},
      {".usda", {"Particles", "Shapes", "Volume"}, {"Shapes"}, true},
      {".xml", {"Particles", "Shapes", "Volume"}, {"Shapes", "Particles"}, true},
      {".pbrt", {"Particles", "Shapes", "Volume"}, {"Shapes", "Particles"}, true},
      {".nvdb", {"Volume"}},
      {".vdb", {"Volume"}},
      {".vti", {"Volume", "Particles"}, {"Volume"}, true},
      {".dream3d", {"Volume", "Particles"}, {"Volume"}, true},
      {".inp", {"Volume", "Particles"}, {"Volume"}, true},
      {".npy", {"Volume", "Labels"}},
      {".nii.gz", {"Volume"}},
      {".nii", {"Volume"}},
      {".png", {"Image", "Labels"}},
      {".tif", {"Image", "Labels"}},
      {".exr", {"Image", "Labels"}},
      {".jpg", {"Image"}},
      {".hdr", {"Image"}},
      {".csv", {"Table", "Profiles", "Particles", "SizeDistribution", "KMatrix", "Shapes"}},
      {".json", {}},
      {".obj", {"Shapes"}},
      {".ply", {"Shapes"}},
      {".stl", {"Shapes", "Volume", "Particles"}, {}, true},
      {".msh", {"Volume", "Particles"}, {"Volume"}, true},
  };
  return all;
}

std::string joined(const std::vector<std::string>& words, const char* last) {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i)
    out += (i == 0 ? "" : i + 1 == words.size() ? std::string(" ") + last + " " : ", ") + words[i];
  return out;
}

}  // namespace

const Format& format_of(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  for (const Format& f : formats())
    if (name.size() > f.extension.size() && name.ends_with(f.extension)) return f;
  const std::string extension = std::filesystem::path(path).extension().string();
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
  const std::string holds =
      "a " + format.extension + " file holds " + joined(format.types, format.several ? "and" : "or");
  if (!strangers.empty())
    throw Error("format-does-not-fit", holds + ", not " + joined(strangers, "and"),
                "change the extension or the input")
        .parameter("path");
  if (values.size() > 1 && !format.several)
    throw Error("format-does-not-fit", holds + ", but only one of them", "use one Export node for each")
        .parameter("path");
  for (const std::string& type : format.required) {
    if (values.count(type)) continue;
    if (type == "Shapes")
      throw Error("no-shapes",
                  "particles are written as instances of their shapes, but 'shapes' is not connected",
                  "connect the shapes used in the packing");
    throw Error("missing-input", "a " + format.extension + " file needs a value of type " + type,
                "connect it, or change the extension");
  }
}

std::string beside(const std::string& path, const Format& format, const std::string& end) {
  return path.substr(0, path.size() - format.extension.size()) + end;
}

}  // namespace terrazzo::exporting
