#include "nodes/common/io/pictures/picture_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <stdexcept>

#include "nodes/common/io/pictures/picture_check.h"

namespace terrazzo {
namespace {

std::string reason(const std::string& message) {
  const std::string words = printable(message);
  return words.empty() ? "the decoder gave no reason" : words;
}

}  // namespace

PictureInput::PictureInput(const std::filesystem::path& path, Reading reading,
                           const PictureAttributes& options)
    : PictureInput(checked_picture(path, reading), 0, reading, options) {}

PictureInput::PictureInput(PictureContent content, std::uint64_t size, Reading reading,
                           const PictureAttributes& options)
    : path_(content.path),
      reading_(std::move(reading)),
      size_(std::max<std::uint64_t>(size, content.bytes.size())),
      format_(content.format) {
  // Select the reader of this format. Given only the file name, OpenImageIO would try one reader after
  // another.
  const PictureCodec& codec = picture_codec();
  try {
    in_ = codec.open(path_, format_, options);
  } catch (const std::runtime_error& e) {
    throw unreadable(reason(e.what()));
  }
}

Error PictureInput::unreadable(const std::string& why) const {
  if (format_ != "raw") return unreadable_picture(path_, why);
  return Error("unreadable-image",
               fmt::format("'{}' is the raw file of a camera, which LibRaw cannot decode: {}", path_.string(),
                           why),
               "convert it to TIFF or JPEG with the camera's program or another raw converter")
      .parameter("path");
}

void PictureInput::require(double bytes_per_sample, double more) const {
  const PictureHeader& s = header();
  if (s.width < 1 || s.height < 1 || s.count() < 1 || s.depth > 1)
    throw unreadable("it is empty or three-dimensional");
  const double pixels = double(s.width) * s.height, samples = pixels * s.count();
  const std::string compression = in_->text("compression");
  const double native = samples * s.sample_bytes;
  if (native > largest_ratio(format_, compression) * size_ + 1e6)
    throw unreadable(fmt::format("{} bytes cannot hold {} × {} pixels of {} channels", size_, s.width,
                                 s.height, s.count()));
  // LibRaw keeps the sensor's data and works on a copy with four colors.
  if (format_ == "raw") more += 24;
  const double tile = double(s.tile_width) * s.tile_height * s.count() * s.sample_bytes;
  try {
    require_memory(native + samples * bytes_per_sample + tile + pixels * more, reading_.memory,
                   fmt::format("the image '{}' of {} × {} pixels", path_.string(), s.width, s.height));
  } catch (Error& e) {
    throw e.parameter("path");
  }
}

void PictureInput::decode(Sample type, void* to) {
  bool good = false;
  std::string thrown;
  try {
    good = in_->read(type, to);
  } catch (const std::bad_alloc&) {
    throw;  // not the file's fault
  } catch (const std::exception& e) {
    thrown = printable(e.what());
  }
  if (!good) throw unreadable(thrown.empty() ? reason(in_->error()) : thrown);
  if (in_->has_error()) reading_.warn(path_.filename().string() + ": " + reason(in_->error()));
}

std::string picture_text(const std::filesystem::path& path, const std::string& name, const Reading& reading) {
  try {
    return PictureInput(path, reading, {}).attributes().text(name);
  } catch (const Error&) {
    return "";
  }
}

}  // namespace terrazzo
