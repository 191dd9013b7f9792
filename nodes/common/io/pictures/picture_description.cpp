// What ImageJ, OME and tifffile write about a TIFF file's pages, as the description of the first one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <pugixml.hpp>

#include "graph/text/read_number.h"
#include "nodes/common/io/picture_pages.h"
#include "nodes/common/io/pictures/picture_check.h"
#include "nodes/common/io/pictures/pixel_scale.h"
#include "nodes/common/io/pictures/tiff_directory.h"
#include "nodes/common/io/reading.h"
#include "nodes/data/indices.h"
#include "runtime/files/json_input.h"

namespace terrazzo {
namespace {

constexpr long kMostPlanes = 10'000'000;

// The lengths of a stack, and the axes from the fastest to the slowest one.
struct Stack {
  std::map<char, long> length = {{'C', 1}, {'Z', 1}, {'T', 1}};
  std::string order = "CZT";

  long planes() const { return length.at('C') * length.at('Z') * length.at('T'); }
  bool is_valid() const {
    double product = 1;
    for (const auto& [axis, n] : length) {
      if (n < 1) return false;
      product *= n;
    }
    return product <= kMostPlanes;
  }
  // Where a plane is in the order of the file.
  long place(std::map<char, long> at) const {
    long place = 0, step = 1;
    for (const char axis : order) {
      place += step * at[axis];
      step *= length.at(axis);
    }
    return place;
  }
};

// Sets planes from `page_at`, the index of the page at each place of the file's order.
void arrange(PicturePages& out, const Stack& stack, const std::vector<long>& page_at) {
  out.channels = stack.length.at('C');
  out.slices = stack.length.at('Z');
  out.frames = stack.length.at('T');
  out.planes.clear();
  for (long t = 0; t < out.frames; ++t)
    for (long z = 0; z < out.slices; ++z)
      for (long c = 0; c < out.channels; ++c) {
        const std::size_t place = stack.place({{'C', c}, {'Z', z}, {'T', t}});
        out.planes.push_back(static_cast<std::size_t>(page_at[place]));
      }
}

void arrange(PicturePages& out, const Stack& stack) {
  std::vector<long> page_at(stack.planes());
  std::iota(page_at.begin(), page_at.end(), 0L);
  arrange(out, stack, page_at);
}

// Adds the pages that follow the only directory of a file without directories of their own. False if the file
// is too short, or compressed.
bool add_following_pages(PicturePages& out, std::string_view content, long count) {
  const TiffReader in(content);
  const TiffDirectory d = in.directory(out.pages[0].directory);
  const auto offsets = d.entries.find(tiff::kStripOffsets);
  constexpr std::uint64_t kUncompressed = 1;
  if (offsets == d.entries.end() || offsets->second.width == 0 || offsets->second.count == 0 ||
      in.value(d, tiff::kCompression, kUncompressed) != kUncompressed)
    return false;
  const double row = std::ceil(double(out.pages[0].width) * double(in.value(d, tiff::kSamples, 1)) *
                               double(in.value(d, tiff::kBits, 1)) / 8);
  const double bytes = row * out.pages[0].height;
  const std::uint64_t first = in.value(offsets->second, 0);
  if (bytes < 1 || double(first) + bytes * double(count) > double(content.size())) return false;
  for (long i = 1; i < count; ++i) {
    PicturePage page = out.pages[0];
    page.number = -1;
    page.skip = static_cast<std::uint64_t>(bytes) * i;
    out.pages.push_back(page);
  }
  return true;
}

// Gives the file as many pages as the description says, or states the problem.
bool require_pages(PicturePages& out, std::string_view content, long count) {
  const long stored = out.pages.size();
  if (stored == count || (stored == 1 && count > 1 && add_following_pages(out, content, count))) return true;
  out.problem =
      fmt::format("its {} metadata describe {} pages, but the file has {}", out.source, count, stored);
  return false;
}

// "name=value" in lines of text; none if there is no such line.
std::optional<std::string> described_value(const std::string& text, const std::string& name) {
  std::size_t at = text.find("\n" + name + "=");
  if (at == std::string::npos) return {};
  at += name.size() + 2;
  return text.substr(at, text.find_first_of("\r\n", at) - at);
}

void apply_imagej(PicturePages& out, std::string_view content, const std::string& text) {
  out.source = "ImageJ";
  const auto count = [&](const char* name) {
    return number_in_text<long>(described_value(text, name).value_or("1")).value_or(0);
  };
  Stack stack;
  stack.length = {{'C', count("channels")}, {'Z', count("slices")}, {'T', count("frames")}};
  const bool described =
      described_value(text, "channels") || described_value(text, "slices") || described_value(text, "frames");
  if (!described) stack.length['Z'] = count("images");
  if (!stack.is_valid() || (described_value(text, "images") && stack.planes() != count("images"))) {
    out.problem = fmt::format("its ImageJ metadata describe {} channels × {} slices × {} frames in {} images",
                              stack.length['C'], stack.length['Z'], stack.length['T'], count("images"));
    return;
  }
  if (!require_pages(out, content, stack.planes())) return;
  arrange(out, stack);
  const TiffReader in(content);
  const TiffDirectory d = in.directory(out.pages[0].directory);
  const double mm = mm_of_unit(described_value(text, "unit").value_or(""));
  const double x = in.ratio(d, tiff::kXResolution), y = in.ratio(d, tiff::kYResolution);
  const double between = number_in_text<double>(described_value(text, "spacing").value_or("")).value_or(0);
  if (mm > 0 && x > 0 && y > 0 && between > 0) out.spacing = Vec3(mm / x, mm / y, mm * between);
}

std::string local_name(const pugi::xml_node& n) {
  const std::string name = n.name();
  const auto colon = name.find(':');
  return colon == std::string::npos ? name : name.substr(colon + 1);
}

std::vector<pugi::xml_node> children_of(const pugi::xml_node& parent, const std::string& name) {
  std::vector<pugi::xml_node> out;
  for (const auto& n : parent.children())
    if (local_name(n) == name) out.push_back(n);
  return out;
}

// The whole number of an attribute, or `otherwise`; −1 if it is not one.
long whole_attribute(const pugi::xml_node& n, const char* name, long otherwise) {
  const auto found = n.attribute(name);
  if (!found) return otherwise;
  const auto v = number_in_text<long>(found.value());
  return v && *v >= 0 && *v <= kMostPlanes ? *v : -1;
}

// The place of the first plane of an element TiffData; −1 if there is no such plane.
long first_place(const pugi::xml_node& block, const Stack& stack) {
  std::map<char, long> at;
  for (const auto& [axis, length] : stack.length) {
    at[axis] = whole_attribute(block, (std::string("First") + axis).c_str(), 0);
    if (at[axis] < 0 || at[axis] >= length) return -1;
  }
  return stack.place(at);
}

// Which page is at each place of the order, from the elements TiffData. Empty, with a problem, if they
// contradict each other or name other files.
std::vector<long> ome_places(PicturePages& out, const pugi::xml_node& pixels, const Stack& stack,
                             const std::string& own_id, const std::string& file_name) {
  const long planes = stack.planes(), pages = out.pages.size();
  std::vector<long> page_at(planes, -1);
  const auto blocks = children_of(pixels, "TiffData");
  for (const auto& block : blocks) {
    for (const auto& id : children_of(block, "UUID"))
      if (const std::string name = id.attribute("FileName").value();
          !name.empty() && name != file_name && id.child_value() != own_id) {
        out.problem =
            fmt::format("its OME metadata say that other planes are in the file '{}'", printable(name));
        return {};
      }
    const long first = first_place(block, stack), directory = whole_attribute(block, "IFD", 0);
    const long count = whole_attribute(block, "PlaneCount", block.attribute("IFD") ? 1 : planes - first);
    if (first < 0 || directory < 0 || count < 0 || first > planes - count || directory > pages - count) {
      out.problem =
          fmt::format("its OME metadata describe {} planes from page {} on, but the file has {} pages", count,
                      directory + 1, pages);
      return {};
    }
    for (long k = 0; k < count; ++k) {
      long& page = page_at[first + k];
      if (page >= 0) {
        out.problem = "its OME metadata place a plane on two pages";
        return {};
      }
      page = directory + k;
    }
  }
  if (blocks.empty() && planes > pages) {
    out.problem =
        fmt::format("its OME metadata describe {} planes, but the file has {} pages", planes, pages);
    return {};
  }
  if (blocks.empty()) std::iota(page_at.begin(), page_at.end(), 0L);
  if (std::find(page_at.begin(), page_at.end(), -1) == page_at.end()) return page_at;
  out.problem = "its OME metadata do not say where all of its planes are";
  return {};
}

void apply_ome_size(PicturePages& out, const pugi::xml_node& pixels) {
  const auto length = [&](const char* axis) {
    const double v =
        number_in_text<double>(pixels.attribute((std::string("PhysicalSize") + axis).c_str()).value())
            .value_or(0);
    const auto unit = pixels.attribute((std::string("PhysicalSize") + axis + "Unit").c_str());
    return v * mm_of_unit(unit ? unit.value() : "µm");
  };
  const Vec3 size(length("X"), length("Y"), length("Z"));
  if (size.minCoeff() > 0) out.spacing = size;
}

void apply_ome(PicturePages& out, std::string_view content, const std::string& text,
               const std::string& file_name) {
  pugi::xml_document document;
  const bool valid = document.load_buffer(text.data(), text.size());
  const pugi::xml_node root = document.document_element();
  if (local_name(root) != "OME") return;
  out.source = "OME";
  if (!valid) {
    out.problem = "its OME metadata are not valid XML";
    return;
  }
  std::vector<pugi::xml_node> pixels;
  for (const auto& image : children_of(root, "Image"))
    for (const auto& p : children_of(image, "Pixels")) pixels.push_back(p);
  if (pixels.size() != 1) {
    out.problem = pixels.empty() ? "its OME metadata describe no picture; they may be in another file"
                                 : fmt::format("its OME metadata describe {} pictures", pixels.size());
    return;
  }
  Stack stack;
  // The colors of a pixel count as channels too.
  const auto channels = children_of(pixels[0], "Channel");
  const long samples = channels.empty() ? 1 : whole_attribute(channels[0], "SamplesPerPixel", 1);
  const long all = whole_attribute(pixels[0], "SizeC", 1);
  stack.length = {{'C', samples > 0 && all % samples == 0 ? all / samples : -1},
                  {'Z', whole_attribute(pixels[0], "SizeZ", 1)},
                  {'T', whole_attribute(pixels[0], "SizeT", 1)}};
  const std::string order = pixels[0].attribute("DimensionOrder").value();
  std::string sorted = order;
  std::sort(sorted.begin(), sorted.end());
  if (sorted != "CTXYZ" || order.substr(0, 2) != "XY" || !stack.is_valid()) {
    out.problem =
        fmt::format("its OME metadata describe {} channels × {} slices × {} frames in the order '{}'",
                    stack.length['C'], stack.length['Z'], stack.length['T'], printable(order));
    return;
  }
  stack.order = order.substr(2);
  if (out.pages.size() == 1 && stack.planes() > 1 && !require_pages(out, content, stack.planes())) return;
  const auto page_at = ome_places(out, pixels[0], stack, root.attribute("UUID").value(), file_name);
  if (!out.problem.empty()) return;
  // OME counts all pages, also thumbnails.
  if (const auto& last = out.pages.back(); last.skip == 0 && last.number + 1 != count_of(out.pages))
    out.problem = "its OME metadata describe pages among which there are thumbnails";
  if (!out.problem.empty()) return;
  arrange(out, stack, page_at);
  apply_ome_size(out, pixels[0]);
}

// tifffile's {"shape": [2, 5, 16, 20], "axes": "CZYX"}; axes is optional.
void apply_shape(PicturePages& out, std::string_view content, const std::string& text) {
  const auto json = json_or_null(text);
  if (!json.is_object() || !json.contains("shape") || !json["shape"].is_array()) return;
  std::vector<long> shape;
  for (const auto& n : json["shape"]) shape.push_back(n.is_number_integer() ? n.get<long>() : 0);
  std::string axes = json.value("axes", nlohmann::json()).is_string() ? json["axes"].get<std::string>() : "";
  if (axes.size() != shape.size()) axes = std::string(shape.size(), 'Q');
  // The axes within a page are the last ones: Y, X and perhaps the samples of a pixel.
  const TiffReader in(content);
  const TiffDirectory d = in.directory(out.pages[0].directory);
  const long samples = in.value(d, tiff::kSamples, 1);
  std::vector<long> page = {out.pages[0].height, out.pages[0].width};
  if (samples > 1) {
    constexpr std::uint64_t kSeparate = 2;
    const bool first = in.value(d, tiff::kPlanar, 1) == kSeparate;
    page.insert(first ? page.begin() : page.end(), samples);
  }
  if (shape.size() < page.size() || !std::equal(page.rbegin(), page.rend(), shape.rbegin())) return;
  Stack stack;
  stack.order = "";
  std::string listed;
  int unnamed = 0;
  for (std::size_t i = shape.size() - page.size(); i-- > 0;) {
    listed = fmt::format("{} × ", shape[i]) + listed;
    if (shape[i] == 1) continue;
    char axis = axes[i];
    if (axis == 'Q' || axis == 'I') {
      axis = 'Z';
      ++unnamed;
    }
    if (stack.order.find(axis) != std::string::npos || !stack.length.contains(axis)) {
      unnamed = 2;
      break;
    }
    stack.order += axis;
    stack.length[axis] = shape[i];
  }
  if (stack.order.empty()) return;
  out.source = "tifffile";
  if (unnamed > 1 || (unnamed == 1 && stack.order.size() > 1) || !stack.is_valid()) {
    double product = 1;
    for (std::size_t i = 0; i + page.size() < shape.size(); ++i) product *= shape[i];
    if (product >= 1 && product <= kMostPlanes) require_pages(out, content, static_cast<long>(product));
    out.problem =
        fmt::format("its tifffile metadata describe an array of {}{} × {} without the names of its axes",
                    listed, out.pages[0].height, out.pages[0].width);
    return;
  }
  for (const char axis : std::string("CZT"))
    if (stack.order.find(axis) == std::string::npos) stack.order += axis;
  if (require_pages(out, content, stack.planes())) arrange(out, stack);
}

}  // namespace

void apply_description(PicturePages& out, std::string_view content, const std::string& file_name) {
  const TiffReader in(content);
  const TiffDirectory first = in.directory(in.first());
  const std::string text = in.text(first, tiff::kDescription);
  if (const auto depth = in.value(first, tiff::kDepth, 1); depth > 1)
    damaged_picture(fmt::format("its pages have a depth of {} slices, which is not supported", depth));
  if (const auto planes = first.entries.find(tiff::kMetaMorph);
      planes != first.entries.end() && planes->second.count > 1)
    damaged_picture(fmt::format("it is a MetaMorph stack of {} planes; ImageJ can save it as TIFF",
                                planes->second.count));
  if (text.starts_with("ImageJ="))
    apply_imagej(out, content, text);
  else if (text.starts_with("<?xml") || text.starts_with("<OME"))
    apply_ome(out, content, text, file_name);
  else if (text.starts_with("{\"shape\":"))
    apply_shape(out, content, text);
}

}  // namespace terrazzo
