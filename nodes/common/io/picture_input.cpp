#include "nodes/common/io/picture_input.h"

#include <fmt/format.h>

#include <map>

#include "nodes/common/io/picture_check.h"

namespace terrazzo {
namespace {

using Check = void (*)(std::string_view, const Reading&);
const std::map<std::string, Check> checks = {{"jpeg", check_jpeg},
                                             {"png", check_png},
                                             {"tiff", check_tiff},
                                             {"openexr", check_exr},
                                             {"bmp", check_bmp}};

// The library's message about the last failure. Reading it also clears it.
std::string last_words(const OIIO::ImageInput* in) {
  const std::string words = printable(in ? in->geterror() : OIIO::geterror());
  return words.empty() ? "the decoder gave no reason" : words;
}

}  // namespace

Error PictureInput::unreadable(const std::string& why) const {
  return Error("unreadable-image", "cannot read the image '" + path_.string() + "': " + why,
               "check that the file is complete; supported formats are JPEG, PNG, TIFF, OpenEXR, HDR, BMP "
               "and PNM")
      .parameter("path");
}

PictureInput::PictureInput(std::filesystem::path path, Reading reading, const OIIO::ImageSpec& hints)
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
  in_ = OIIO::ImageInput::create(format_);
  if (!in_) throw unreadable(last_words(nullptr));
  OIIO::ImageSpec first;
  if (!in_->open(path_.string(), first, hints)) throw unreadable(last_words(in_.get()));
}

void PictureInput::require(double bytes_per_sample, double more) const {
  const OIIO::ImageSpec& s = spec();
  if (s.width < 1 || s.height < 1 || s.nchannels < 1 || s.depth > 1)
    throw unreadable("it is empty or three-dimensional");
  const double pixels = double(s.width) * s.height, samples = pixels * s.nchannels;
  const std::string compression = s.get_string_attribute("compression");
  const double native = samples * static_cast<double>(s.format.size());
  if (native > largest_ratio(format_, compression) * static_cast<double>(size_) + 1e6)
    throw unreadable(fmt::format("{} bytes cannot hold {} × {} pixels of {} channels", size_, s.width,
                                 s.height, s.nchannels));
  const double tile =
      double(s.tile_width) * s.tile_height * s.nchannels * static_cast<double>(s.format.size());
  try {
    require_memory(native + samples * bytes_per_sample + tile + pixels * more, reading_.memory,
                   fmt::format("the image '{}' of {} × {} pixels", path_.string(), s.width, s.height));
  } catch (Error& e) {
    throw e.parameter("path");
  }
}

void PictureInput::decode(OIIO::TypeDesc type, void* to) {
  const int page = in_->current_subimage();
  bool good = false;
  std::string thrown;
  try {
    good = in_->read_image(page, 0, 0, spec().nchannels, type, to);
  } catch (const std::exception& e) {
    thrown = printable(e.what());
  }
  if (!good) throw unreadable(thrown.empty() ? last_words(in_.get()) : thrown);
  if (in_->has_error()) reading_.warn(path_.filename().string() + ": " + last_words(in_.get()));
}

std::string picture_text(const std::filesystem::path& path, const std::string& name, const Reading& reading) {
  try {
    return PictureInput(path, reading, {}).spec().get_string_attribute(name);
  } catch (const Error&) {
    return "";
  }
}

}  // namespace terrazzo
