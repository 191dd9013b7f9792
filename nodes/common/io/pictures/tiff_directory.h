// Directories of TIFF files, and of the EXIF data that other files contain, with every offset checked.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace terrazzo {

struct TiffEntry {
  std::uint64_t type = 0;
  int width = 0;  // bytes per value; 0 if the type is unknown
  std::uint64_t count = 0, at = 0;
};

struct TiffDirectory {
  std::uint64_t at = 0, next = 0;
  std::map<std::uint64_t, TiffEntry> entries;  // by tag
};

// Reads numbers in the file's byte order and width. Throws Error "unreadable-image" if something refers
// beyond the content.
class TiffReader {
 public:
  explicit TiffReader(std::string_view content);
  bool is_little() const { return little_; }
  bool is_big() const { return big_; }  // BigTIFF: 64-bit offsets
  std::uint64_t size() const { return content_.size(); }
  std::uint64_t first() const;  // where the first directory is
  std::uint64_t number(std::uint64_t at, int bytes) const;
  // All entries, each of which is within the content.
  TiffDirectory directory(std::uint64_t at) const;
  // Value i of an entry of whole numbers.
  std::uint64_t value(const TiffEntry&, std::uint64_t i) const;
  // The first value of a tag, or `otherwise` if the directory lacks it.
  std::uint64_t value(const TiffDirectory&, std::uint64_t tag, std::uint64_t otherwise) const;
  // The text of a tag up to its first zero byte, or "".
  std::string text(const TiffDirectory&, std::uint64_t tag) const;
  // A tag of one rational number, or 0.
  double ratio(const TiffDirectory&, std::uint64_t tag) const;

 private:
  std::string_view content_;
  bool little_, big_ = false;
};

namespace tiff {
constexpr std::uint64_t kNewSubfileType = 254, kSubfileType = 255, kWidth = 256, kHeight = 257, kBits = 258,
                        kCompression = 259, kPhotometric = 262, kDescription = 270, kStripOffsets = 273,
                        kOrientation = 274, kSamples = 277, kStripLengths = 279, kXResolution = 282,
                        kYResolution = 283, kPlanar = 284, kColorMap = 320, kTileOffsets = 324,
                        kTileLengths = 325, kSubDirectories = 330, kExtraSamples = 338, kSampleFormat = 339,
                        kDepth = 32997, kMetaMorph = 33629, kExif = 34665, kDngVersion = 50706;
}

// The directories of the main chain in their order. Throws Error "unreadable-image" for more directories and
// entries than any real file has, which would only cost time.
std::vector<TiffDirectory> main_directories(const TiffReader&);
// The directories that the tag SubIFDs of another one refers to, without those in `seen`, to which it adds
// them.
std::vector<TiffDirectory> sub_directories(const TiffReader&, const TiffDirectory&,
                                           std::set<std::uint64_t>& seen);

}  // namespace terrazzo
