// The pictures that one file contains, and what its metadata say about them: channels, slices and frames.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo {

class NodeParameters;

struct PicturePage {
  int number = 0;               // OpenImageIO's number; −1 if OpenImageIO cannot reach the page
  std::uint64_t directory = 0;  // where a TIFF file describes the page
  // The pixels begin so many bytes after the place that the directory names. ImageJ and tifffile write stacks
  // with one directory, whose pages follow each other.
  std::uint64_t skip = 0;
  int width = 0, height = 0;  // 0 if unknown
};

struct PicturePages {
  std::vector<PicturePage> pages;  // in the order of the file, without thumbnails and masks
  // The stack that the pages form according to `source`; without one, each page is a slice.
  int channels = 1, slices = 1, frames = 1;
  std::vector<std::size_t>
      planes;           // planes[(frame · slices + slice) · channels + channel] is an index of pages
  std::string source;   // "ImageJ", "OME" or "tifffile"; "" if the file says nothing
  std::string problem;  // why the pages do not form the stack that `source` describes
  std::optional<Vec3> spacing;  // mm, if the file states it
  bool raw = false;             // the sensor's data of a camera
};

// Pages of a file whose structure has been checked; `format` is that of picture_format().
PicturePages pages_of(std::string_view content, const std::string& format, const std::string& file_name);
// Makes `pages` a stack of what ImageJ, OME or tifffile wrote as the description of the first directory.
void apply_description(PicturePages&, std::string_view content, const std::string& file_name);

// What the parameters page and channel choose, counted from 1; none: auto.
struct PageOptions {
  std::optional<int> page, channel;
};
// Of a node with these two parameters.
PageOptions page_choice(const NodeParameters&);

struct ChosenPage {
  PicturePage page;
  std::optional<int> channel;  // to take from each pixel, from 0
};

// The one page to read. Throws Error "several-pages" or "several-channels" with the counts if the choice is
// open, "bad-value" if there is no such page.
ChosenPage choose_page(const PicturePages&, const PageOptions&, const std::filesystem::path&);

// The pages that are the slices of a volume, from the first one up. If `stored`, all pages in the order of
// the file. Throws like choose_page.
std::vector<ChosenPage> choose_slices(const PicturePages&, const PageOptions&, bool stored,
                                      const std::filesystem::path&);

}  // namespace terrazzo
