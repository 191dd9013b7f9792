// Reader for untrusted image files: nothing is decoded until the file is checked and its memory needs fit the
// budget.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/common/io/pictures/picture_codec.h"
#include "nodes/common/io/pictures/picture_content.h"
#include "nodes/common/io/reading.h"
#include "nodes/data/indices.h"

namespace terrazzo {

class PictureInput {
 public:
  // Opens a file that checked_picture() accepts. A truncated file is an error; other messages of the decoder
  // become warnings. Throws Error "unreadable-image" or "too-large".
  PictureInput(const std::filesystem::path&, Reading, const PictureAttributes& options);
  // Opens a checked file of `size` bytes; its content is not needed any more.
  PictureInput(PictureContent, std::uint64_t size, Reading, const PictureAttributes& options);

  const PictureHeader& header() const { return in_->header(); }
  const PictureDecoder& attributes() const { return *in_; }
  bool seek(int page) { return page == in_->page() || in_->seek(page); }

  // All samples of the page, converted to T, which is `type`, as OpenImageIO does. `more` is the number of
  // additional bytes per pixel that the caller will need. Throws Error "unreadable-image" if the page cannot
  // be decoded, or if the file is too small for its header; "too-large" if the page and `more` exceed the
  // memory budget.
  template <class T>
  std::vector<T> samples(Sample type, double more) {
    require(sizeof(T), more);
    std::vector<T> out(pixels_in(header().width, header().height) * header().count());
    decode(type, out.data());
    return out;
  }

  Error unreadable(const std::string& why) const;

 private:
  void require(double bytes_per_sample, double more) const;
  void decode(Sample, void* to);

  std::filesystem::path path_;
  Reading reading_;
  std::uint64_t size_ = 0;
  std::string format_;
  std::unique_ptr<PictureDecoder> in_;
};

// A text attribute of the file, such as "ImageDescription"; "" if there is none or the file is not an image.
// Decodes no pixels.
std::string picture_text(const std::filesystem::path&, const std::string& name, const Reading& = {});

}  // namespace terrazzo
