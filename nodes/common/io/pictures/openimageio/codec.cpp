// The only file that uses OpenImageIO. It is a module of its own, which picture_codec() loads.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <stdexcept>

#include "nodes/common/io/pictures/picture_codec.h"

namespace terrazzo {
namespace {

Sample sample_of(OIIO::TypeDesc type) {
  switch (type.basetype) {
    case OIIO::TypeDesc::UINT8:
      return Sample::UInt8;
    case OIIO::TypeDesc::INT8:
      return Sample::Int8;
    case OIIO::TypeDesc::UINT16:
      return Sample::UInt16;
    case OIIO::TypeDesc::INT16:
      return Sample::Int16;
    case OIIO::TypeDesc::UINT32:
      return Sample::UInt32;
    case OIIO::TypeDesc::INT32:
      return Sample::Int32;
    case OIIO::TypeDesc::FLOAT:
      return Sample::Float;
    case OIIO::TypeDesc::DOUBLE:
      return Sample::Double;
    default:
      return Sample::Other;
  }
}

OIIO::TypeDesc type_of(Sample sample) {
  switch (sample) {
    case Sample::UInt8:
      return OIIO::TypeDesc::UINT8;
    case Sample::Int8:
      return OIIO::TypeDesc::INT8;
    case Sample::UInt16:
      return OIIO::TypeDesc::UINT16;
    case Sample::Int16:
      return OIIO::TypeDesc::INT16;
    case Sample::UInt32:
      return OIIO::TypeDesc::UINT32;
    case Sample::Int32:
      return OIIO::TypeDesc::INT32;
    case Sample::Float:
      return OIIO::TypeDesc::FLOAT;
    case Sample::Double:
      return OIIO::TypeDesc::DOUBLE;
    case Sample::Other:
      break;
  }
  throw std::runtime_error("unknown type of samples");
}

void set(OIIO::ImageSpec& spec, const PictureAttributes& attributes) {
  for (const auto& [name, value] : attributes)
    std::visit([&, &n = name](const auto& v) { spec.attribute(n, v); }, value);
}

class Decoder : public PictureDecoder {
 public:
  explicit Decoder(std::unique_ptr<OIIO::ImageInput> in) : in_(std::move(in)) { take_header(); }

  const PictureHeader& header() const override { return header_; }
  int page() const override { return in_->current_subimage(); }
  bool seek(int page) override {
    const bool found = in_->seek_subimage(page, 0);
    take_header();
    return found;
  }
  std::string text(const std::string& name) const override { return in_->spec().get_string_attribute(name); }
  float number(const std::string& name, float otherwise) const override {
    return in_->spec().get_float_attribute(name, otherwise);
  }
  int whole(const std::string& name, int otherwise) const override {
    return in_->spec().get_int_attribute(name, otherwise);
  }
  std::string bytes(const std::string& name) const override {
    const OIIO::ParamValue* found = in_->spec().find_attribute(name);
    if (!found || found->type().basetype != OIIO::TypeDesc::UINT8) return "";
    return {static_cast<const char*>(found->data()), static_cast<std::size_t>(found->datasize())};
  }
  bool read(Sample as, void* to) override {
    return in_->read_image(in_->current_subimage(), 0, 0, in_->spec().nchannels, type_of(as), to);
  }
  bool has_error() const override { return in_->has_error(); }
  std::string error() override { return in_->geterror(); }

 private:
  void take_header() {
    const OIIO::ImageSpec& s = in_->spec();
    header_ = {};
    header_.width = s.width;
    header_.height = s.height;
    header_.depth = s.depth;
    header_.tile_width = s.tile_width;
    header_.tile_height = s.tile_height;
    for (int i = 0; i < s.nchannels; ++i) header_.channels.emplace_back(s.channel_name(i));
    header_.alpha = s.alpha_channel;
    header_.sample = sample_of(s.format);
    header_.sample_bytes = s.format.size();
    header_.is_float = s.format.is_floating_point();
    header_.deep = s.deep;
  }

  std::unique_ptr<OIIO::ImageInput> in_;
  PictureHeader header_;
};

class Codec : public PictureCodec {
 public:
  std::unique_ptr<PictureDecoder> open(const std::filesystem::path& path, const std::string& format,
                                       const PictureAttributes& options) const override {
    auto in = OIIO::ImageInput::create(format.empty() ? path.string() : format);
    if (!in) throw std::runtime_error(OIIO::geterror());
    OIIO::ImageSpec first, hints;
    set(hints, options);
    if (!in->open(path.string(), first, hints)) throw std::runtime_error(in->geterror());
    return std::make_unique<Decoder>(std::move(in));
  }

  std::string encode(const std::filesystem::path& path, const PictureEncoding& encoding,
                     const void* samples) const override {
    auto out = OIIO::ImageOutput::create(path.string());
    if (!out) throw std::runtime_error(OIIO::geterror());
    const OIIO::TypeDesc type = type_of(encoding.sample);
    OIIO::ImageSpec spec(encoding.width, encoding.height, encoding.channels, type);
    if (encoding.alpha >= 0) spec.alpha_channel = encoding.alpha;
    set(spec, encoding.attributes);
    // In memory where possible: on a full disk libjpeg would end the program, and other formats report no
    // error. TIFF reports errors, and cannot write Exif to memory.
    OIIO::Filesystem::IOVecOutput memory;
    const bool in_memory =
        std::string(out->format_name()) != "tiff" && out->supports("ioproxy") && out->set_ioproxy(&memory);
    if (!out->open(path.string(), spec) || !out->write_image(type, samples) || !out->close())
      throw std::runtime_error(out->geterror());
    if (!in_memory) return {};
    return {reinterpret_cast<const char*>(memory.buffer().data()), memory.buffer().size()};
  }
};

}  // namespace
}  // namespace terrazzo

extern "C" const terrazzo::PictureCodec* terrazzo_picture_codec() {
  static const terrazzo::Codec codec;
  return &codec;
}
