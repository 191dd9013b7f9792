// Opens pictures of unknown origin: nothing is decoded before the file was checked and its needs fit the
// budget.
#pragma once

#include <OpenImageIO/imageio.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/common/reading.h"

namespace terrazzo {

class PictureInput {
 public:
  // Opens a JPEG, PNG, TIFF, OpenEXR, Radiance HDR, BMP or PNM file, told by its content. Checks what the
  // format allows to check: a file that was cut short is an error, and what its decoder complains about is a
  // warning. Throws Error "unreadable-image" or "too-large".
  PictureInput(std::filesystem::path, Reading, const OIIO::ImageSpec& hints);

  const OIIO::ImageSpec& spec() const { return in_->spec(); }
  bool seek(int page) { return in_->seek_subimage(page, 0); }

  // All samples of the page, converted to T as OpenImageIO does. `more`: bytes per pixel that the caller is
  // about to need besides. Throws Error "unreadable-image" if the page cannot be decoded, or if the file is
  // too small to hold what its header promises; "too-large" if page and `more` exceed the budget.
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

// A text that the file carries, such as "ImageDescription", or "" if it has none or is no picture. Decodes no
// pixels.
std::string picture_text(const std::filesystem::path&, const std::string& name, const Reading& = {});

}  // namespace terrazzo
