// Reader for untrusted image files: nothing is decoded until the file is checked and its memory needs fit the
// budget.
#pragma once

#include <OpenImageIO/imageio.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/common/io/reading.h"

namespace terrazzo {

class PictureInput {
 public:
  // Opens a JPEG, PNG, TIFF, OpenEXR, Radiance HDR, BMP or PNM file, detected by content, and checks its
  // structure. A truncated file is an error; other complaints of the decoder are warnings. Throws Error
  // "unreadable-image" or "too-large".
  PictureInput(std::filesystem::path, Reading, const OIIO::ImageSpec& hints);

  const OIIO::ImageSpec& spec() const { return in_->spec(); }
  bool seek(int page) { return in_->seek_subimage(page, 0); }

  // All samples of the page, converted to T as OpenImageIO does. `more` is the number of additional bytes per
  // pixel that the caller will need. Throws Error "unreadable-image" if the page cannot be decoded, or if the
  // file is too small for its header; "too-large" if the page and `more` exceed the memory budget.
  template <class T>
  std::vector<T> samples(OIIO::TypeDesc type, double more) {
    require(sizeof(T), more);
    std::vector<T> out(static_cast<std::size_t>(spec().width) * spec().height * spec().nchannels);
    decode(type, out.data());
    return out;
  }

  Error unreadable(const std::string& why) const;

 private:
  void require(double bytes_per_sample, double more) const;
  void decode(OIIO::TypeDesc, void* to);

  std::filesystem::path path_;
  Reading reading_;
  std::uint64_t size_ = 0;
  std::string format_;
  std::unique_ptr<OIIO::ImageInput> in_;
};

// A text attribute of the file, such as "ImageDescription"; "" if there is none or the file is not an image.
// Decodes no pixels.
std::string picture_text(const std::filesystem::path&, const std::string& name, const Reading& = {});

}  // namespace terrazzo
