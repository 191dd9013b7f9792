#include "nodes/common/io/picture_input.h"

#include <fmt/format.h>

#include <map>
#include <new>
#include <stdexcept>

#include "nodes/common/io/picture_check.h"

namespace terrazzo {
namespace {

using Check = void (*)(std::string_view, const Reading&);
const std::map<std::string, Check> checks = {{"jpeg", check_jpeg},
                                             {"png", check_png},
                                             {"tiff", check_tiff},
                                             {"openexr", check_exr},
                                             {"bmp", check_bmp}};

std::string reason(const std::string& message) {
  const std::string words = printable(message);
  return words.empty() ? "the decoder gave no reason" : words;
}

}  // namespace

Error PictureInput::unreadable(const std::string& why) const {
  return Error("unreadable-image", "cannot read the image '" + path_.string() + "': " + why,
               "check that the file is complete; supported formats are JPEG, PNG, TIFF, OpenEXR, HDR, BMP "
               "and PNM")
      .parameter("path");
}

PictureInput::PictureInput(std::filesystem::path path, Reading reading, const PictureAttributes& options)
    : path_(std::move(path)), reading_(std::move(reading)) {
  const std::string name = path_.filename().string();
  try {
    const std::string content = read_whole(path_, reading_);
    size_ = content.size();
    format_ = picture_format(content);
    if (format_.empty()) throw unreadable("its format is not supported");
    check_notes(content);
    Reading named = reading_;
    named.warn = [&](const std::string& message) { reading_.warn(name + ": " + message); };
    if (const auto check = checks.find(format_); check != checks.end()) check->second(content, named);
  } catch (Error& e) {
    if (e.diagnostic().code == "unreadable-file" ||
        (e.diagnostic().code == "unreadable-image" && e.diagnostic().parameter.empty()))
      throw unreadable(e.diagnostic().message);
    throw e.parameter("path");
  }
  // Select the reader of this format. Given only the file name, OpenImageIO would try one reader after
  // another.
  const PictureCodec& codec = picture_codec();
  try {
    in_ = codec.open(path_, format_, options);
  } catch (const std::runtime_error& e) {
    throw unreadable(reason(e.what()));
  }
}

void PictureInput::require(double bytes_per_sample, double more) const {
  const PictureHeader& s = header();
  if (s.width < 1 || s.height < 1 || s.count() < 1 || s.depth > 1)
    throw unreadable("it is empty or three-dimensional");
  const double pixels = double(s.width) * s.height, samples = pixels * s.count();
  const std::string compression = in_->text("compression");
  const double native = samples * static_cast<double>(s.sample_bytes);
  if (native > largest_ratio(format_, compression) * static_cast<double>(size_) + 1e6)
    throw unreadable(fmt::format("{} bytes cannot hold {} × {} pixels of {} channels", size_, s.width,
                                 s.height, s.count()));
  const double tile = double(s.tile_width) * s.tile_height * s.count() * static_cast<double>(s.sample_bytes);
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
