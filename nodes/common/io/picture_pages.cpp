#include "nodes/common/io/picture_pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "graph/diagnostic.h"
#include "graph/node_parameters.h"
#include "nodes/common/io/pictures/picture_check.h"
#include "nodes/common/io/pictures/tiff_directory.h"
#include "nodes/common/io/reading.h"

namespace terrazzo {
namespace {

constexpr std::uint64_t kColorFilterArray = 32803, kLinearRaw = 34892;

// Not a page of its own: a thumbnail, a reduced resolution or a mask of another page.
bool is_part(const TiffReader& in, const TiffDirectory& d) {
  constexpr std::uint64_t kPageOfSeveral = 2, kReduced = 2;
  return (in.value(d, tiff::kNewSubfileType, 0) & ~kPageOfSeveral) != 0 ||
         in.value(d, tiff::kSubfileType, 0) == kReduced;
}

bool is_raw(const TiffReader& in, const TiffDirectory& d) {
  const auto kind = in.value(d, tiff::kPhotometric, 0);
  return kind == kColorFilterArray || kind == kLinearRaw || d.entries.contains(tiff::kDngVersion);
}

PicturePage tiff_page(const TiffReader& in, const TiffDirectory& d, int number) {
  PicturePage page;
  page.number = number;
  page.directory = d.at;
  page.width = std::min<std::uint64_t>(in.value(d, tiff::kWidth, 0), 1u << 30);
  page.height = std::min<std::uint64_t>(in.value(d, tiff::kHeight, 0), 1u << 30);
  return page;
}

void find_tiff_pages(std::string_view content, PicturePages& out) {
  const TiffReader in(content);
  const auto directories = main_directories(in);
  std::vector<PicturePage> parts, hidden;
  std::set<std::uint64_t> seen;
  out.raw = content.size() > 10 && content.substr(8, 2) == "CR";  // Canon's CR2
  for (std::size_t i = 0; i < directories.size(); ++i) {
    const TiffDirectory& d = directories[i];
    (is_part(in, d) ? parts : out.pages).push_back(tiff_page(in, d, i));
    out.raw = out.raw || is_raw(in, d);
    for (const auto& sub : sub_directories(in, d, seen)) {
      out.raw = out.raw || is_raw(in, sub);
      if (!is_part(in, sub)) hidden.push_back(tiff_page(in, sub, -1));
    }
  }
  // A thumbnail may come first, and refer to the picture.
  if (out.pages.empty()) out.pages = hidden.empty() ? parts : hidden;
}

// The names of the pages' counts: "2 channels × 5 slices × 3 frames".
std::string counts_of_pages(const PicturePages& p) {
  if (p.source.empty()) {
    const PicturePage& first = p.pages.front();
    const bool same = std::all_of(p.pages.begin(), p.pages.end(), [&](const PicturePage& q) {
      return q.width == first.width && q.height == first.height;
    });
    std::string text = fmt::format("{} pages", p.pages.size());
    if (first.width == 0) return text;
    if (same) return fmt::format("{} of {} × {} pixels", text, first.width, first.height);
    constexpr std::size_t kMost = 6;
    text += " of ";
    for (std::size_t i = 0; i < std::min(kMost, p.pages.size()); ++i)
      text += fmt::format("{}{} × {}", i == 0 ? "" : ", ", p.pages[i].width, p.pages[i].height);
    return text + (p.pages.size() > kMost ? ", … pixels" : " pixels");
  }
  std::string text;
  const auto add = [&](int n, const char* what) {
    if (n > 1) text += fmt::format("{}{} {}", text.empty() ? "" : " × ", n, what);
  };
  add(p.channels, "channels");
  add(p.slices, "slices");
  add(p.frames, "frames");
  return text + " (" + p.source + ")";
}

Error several_in(const char* code, const PicturePages& p, const std::filesystem::path& path,
                 const std::string& hint) {
  return Error(code, fmt::format("'{}' contains {}", path.string(), counts_of_pages(p)), hint)
      .parameter(std::string(code) == "several-channels" ? "channel" : "page");
}

void require_within(const std::optional<int>& chosen, std::size_t count, const char* name,
                    const std::filesystem::path& path) {
  if (!chosen || (*chosen >= 1 && static_cast<std::size_t>(*chosen) <= count)) return;
  throw Error("bad-value",
              fmt::format("{} is {}, but '{}' has {} {}{}", name, *chosen, path.string(), count, name,
                          count == 1 ? "" : "s"),
              fmt::format("{}s are counted from 1", name))
      .parameter(name);
}

Error misdescribed(const PicturePages& p, const std::filesystem::path& path, const std::string& hint) {
  return Error("several-pages", fmt::format("'{}': {}", path.string(), p.problem), hint).parameter("path");
}

}  // namespace

PicturePages pages_of(std::string_view content, const std::string& format, const std::string& file_name) {
  PicturePages out;
  const int parts = format == "openexr" ? exr_parts(content) : format == "gif" ? gif_frames(content) : 1;
  out.raw = format == "raw";
  if (format == "tiff")
    find_tiff_pages(content, out);
  else
    for (int i = 0; i < parts; ++i) out.pages.push_back({i});
  if (out.raw) out.pages.assign(1, {});  // a decoder of raw files finds the picture
  if (out.pages.empty()) damaged_picture("it has no pages");
  out.slices = out.pages.size();
  out.planes.resize(out.pages.size());
  std::iota(out.planes.begin(), out.planes.end(), std::size_t{0});
  if (format == "tiff" && !out.raw) apply_description(out, content, file_name);
  return out;
}

PageOptions page_choice(const NodeParameters& parameters) {
  const auto whole = [&](const char* name) {
    const auto v = parameters.optional_integer(name);
    return v ? std::optional(static_cast<int>(*v)) : std::nullopt;
  };
  return {whole("page"), whole("channel")};
}

ChosenPage choose_page(const PicturePages& p, const PageOptions& choice, const std::filesystem::path& path) {
  if (!p.problem.empty()) {
    if (!choice.page)
      throw misdescribed(
          p, path, fmt::format("set page to read a page as it is stored, from 1 to {}", p.pages.size()));
    require_within(choice.page, p.pages.size(), "page", path);
    return {p.pages[*choice.page - 1], choice.channel ? std::optional(*choice.channel - 1) : std::nullopt};
  }
  const int pages = p.slices * p.frames;
  require_within(choice.page, pages, "page", path);
  if (p.channels > 1) require_within(choice.channel, p.channels, "channel", path);
  const bool open_page = pages > 1 && !choice.page, open_channel = p.channels > 1 && !choice.channel;
  if (open_page || open_channel) {
    std::string hint;
    if (open_channel) hint = fmt::format("set channel, from 1 to {}", p.channels);
    if (open_page)
      hint += fmt::format("{}page to the one to read, from 1 to {}", open_channel ? ", and " : "set ", pages);
    if (open_page && p.slices > 1 && p.frames > 1) hint += " (slices of the first frame come first)";
    throw several_in(open_page ? "several-pages" : "several-channels", p, path, hint);
  }
  const int plane = (choice.page.value_or(1) - 1) * p.channels;
  if (p.channels > 1) return {p.pages[p.planes[plane + *choice.channel - 1]], {}};
  return {p.pages[p.planes[plane]], choice.channel ? std::optional(*choice.channel - 1) : std::nullopt};
}

std::vector<ChosenPage> choose_slices(const PicturePages& p, const PageOptions& choice, bool stored,
                                      const std::filesystem::path& path) {
  std::vector<ChosenPage> out;
  const std::optional<int> sample = choice.channel ? std::optional(*choice.channel - 1) : std::nullopt;
  if (stored) {
    for (const auto& page : p.pages) out.push_back({page, sample});
    return out;
  }
  if (!p.problem.empty())
    throw misdescribed(p, path, "set order: stored to take all pages as slices, in the order of the file");
  const std::string otherwise =
      p.slices == 1 ? ", or order: stored if they are the slices, in the order of the file" : "";
  if (p.channels > 1) {
    if (!choice.channel)
      throw several_in("several-channels", p, path,
                       fmt::format("set channel, from 1 to {}{}", p.channels, otherwise));
    require_within(choice.channel, p.channels, "channel", path);
  }
  if (p.frames > 1 && !choice.page)
    throw several_in("several-pages", p, path,
                     fmt::format("set page to the frame to read, from 1 to {}{}", p.frames, otherwise));
  require_within(choice.page, p.frames, "page", path);
  const int frame = choice.page.value_or(1) - 1, channel = p.channels > 1 ? *choice.channel - 1 : 0;
  for (int z = 0; z < p.slices; ++z)
    out.push_back({p.pages[p.planes[(frame * p.slices + z) * p.channels + channel]],
                   p.channels > 1 ? std::nullopt : sample});
  return out;
}

}  // namespace terrazzo
