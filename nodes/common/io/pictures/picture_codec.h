// Decodes and encodes picture files. OpenImageIO does it, but it brings 260 shared libraries, which take 0.2
// s of CPU time to load. So only the module in nodes/common/io/pictures/openimageio/ is linked to it, and
// picture_codec() loads that module with the first picture. Nothing else may include OpenImageIO's headers.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace terrazzo {

enum class Sample { UInt8, Int8, UInt16, Int16, UInt32, Int32, Float, Double, Other };

// Metadata and options, under OpenImageIO's names.
using PictureAttributes = std::vector<std::pair<std::string, std::variant<int, float, std::string>>>;

struct PictureHeader {
  int width = 0, height = 0, depth = 1;
  int tile_width = 0, tile_height = 0;  // 0: rows
  std::vector<std::string> channels;    // their names
  int alpha = -1;                       // the alpha channel; −1 if there is none
  Sample sample = Sample::UInt8;        // Other: a type that Sample does not name, such as half
  std::size_t sample_bytes = 1;
  bool is_float = false;
  bool deep = false;

  int count() const { return channels.size(); }
};

// An open file.
class PictureDecoder {
 public:
  virtual ~PictureDecoder() = default;
  virtual const PictureHeader& header() const = 0;  // of the current page
  virtual int page() const = 0;
  virtual bool seek(int page) = 0;
  // An attribute of the page, or `otherwise`.
  virtual std::string text(const std::string& name) const = 0;
  virtual float number(const std::string& name, float otherwise = 0) const = 0;
  virtual int whole(const std::string& name, int otherwise = 0) const = 0;
  // An attribute of bytes, such as "ICCProfile"; "" if the page has none.
  virtual std::string bytes(const std::string& name) const = 0;
  // Reads all samples of the page and converts them; `as` is not Other. False if that fails.
  virtual bool read(Sample as, void* to) = 0;
  virtual bool has_error() const = 0;
  // The reason for the last failure, "" if none. Clears it.
  virtual std::string error() = 0;
};

struct PictureEncoding {
  int width = 0, height = 0, channels = 3;
  int alpha = -1;
  Sample sample = Sample::UInt8;
  PictureAttributes attributes;
};

class PictureCodec {
 public:
  virtual ~PictureCodec() = default;
  // `format`: OpenImageIO's name of the format; "" selects it by the file's name. Throws std::runtime_error
  // with the reason, which may be empty.
  virtual std::unique_ptr<PictureDecoder> open(const std::filesystem::path&, const std::string& format,
                                               const PictureAttributes& options) const = 0;
  // Returns the bytes of the file; the extension determines the format. Formats that are not encoded in
  // memory, such as TIFF, are written to the path, and the result is empty. `samples` have the type of the
  // encoding. Throws std::runtime_error with the reason.
  virtual std::string encode(const std::filesystem::path&, const PictureEncoding&,
                             const void* samples) const = 0;
};

// Loads the module on the first call. Throws Error "program" if it cannot be loaded, "no-memory" if the
// address space is too small for it.
const PictureCodec& picture_codec();

}  // namespace terrazzo

// The function that picture_codec() looks up by name.
extern "C" const terrazzo::PictureCodec* terrazzo_picture_codec();
