#include "tests/torture/mutate.h"

#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cstring>

namespace terrazzo::torture {
namespace {

const char* const words[] = {"nan",   "inf",         "-1", "4294967295", "18446744073709551616",
                             "1e308", "-2147483648", "0",  "1e-320",     "99999999",
                             "",      "''",          "[",  "{",          "&a",
                             "*a",    "\xff\xfe",    "%s"};
const std::uint64_t lengths[] = {0,
                                 1,
                                 0xff,
                                 0x7fff,
                                 0xffff,
                                 0x10000,
                                 0x7fffffff,
                                 0x80000000,
                                 0xffffffff,
                                 0x40000000,
                                 0x7fffffffffffffff,
                                 0xffffffffffffffff,
                                 0x100000000};

// Replaces a number in the text.
void edit_number(std::string& b, Random& r) {
  const std::size_t from = r.below(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) {
    const std::size_t at = (from + i) % b.size();
    if (!std::isdigit(static_cast<unsigned char>(b[at]))) continue;
    std::size_t end = at;
    while (end < b.size() && (std::isalnum(static_cast<unsigned char>(b[end])) || b[end] == '.')) ++end;
    b.replace(at, end - at, words[r.below(std::size(words))]);
    return;
  }
}

void edit(std::string& b, const std::string& other, Random& r) {
  if (b.empty()) b = " ";
  // The beginning, which holds headers, is hit more often.
  const std::size_t at = r.below(2) ? r.below(b.size()) : r.below(std::min<std::size_t>(b.size(), 400));
  switch (r.below(9)) {
    case 0:
      b[at] = static_cast<char>(b[at] ^ (1 << r.below(8)));
      break;
    case 1:
      b[at] = static_cast<char>(r.below(256));
      break;
    case 2:
    case 3: {  // a length, in either byte order
      const std::size_t size = std::size_t{1} << r.below(4);
      std::uint64_t v = lengths[r.below(std::size(lengths))];
      char bytes[8];
      std::memcpy(bytes, &v, 8);
      if (r.below(2)) std::reverse(bytes, bytes + size);
      if (at + size <= b.size()) std::memcpy(&b[at], bytes, size);
      break;
    }
    case 4:
      b.resize(at);
      break;
    case 5:
      b.erase(at, 1 + r.below(64));
      break;
    case 6:
      b.insert(at, b.substr(r.below(b.size()), 1 + r.below(64)));
      break;
    case 7:
      if (!other.empty()) b = b.substr(0, at) + other.substr(r.below(other.size()));
      break;
    default:
      edit_number(b, r);
  }
}

std::string unpacked(const std::string& b) {
  z_stream z = {};
  if (inflateInit2(&z, 31) != Z_OK) return {};
  std::string out(1 << 16, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(b.data()));
  z.avail_in = static_cast<uInt>(b.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  inflate(&z, Z_FINISH);
  out.resize(z.total_out);
  inflateEnd(&z);
  return out;
}

std::string packed(const std::string& b) {
  z_stream z = {};
  if (deflateInit2(&z, 6, Z_DEFLATED, 31, 8, Z_DEFAULT_STRATEGY) != Z_OK) return {};
  std::string out(deflateBound(&z, b.size()), '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(b.data()));
  z.avail_in = static_cast<uInt>(b.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

void renew_png_checksums(std::string& b) {
  const auto big32 = [&](std::size_t at) {
    std::uint32_t v = 0;
    for (std::size_t k = 0; k < 4; ++k) v = v << 8 | static_cast<unsigned char>(b[at + k]);
    return v;
  };
  for (std::size_t at = 8; b.size() - std::min(at, b.size()) >= 12;) {
    const std::size_t length = big32(at);
    if (length > b.size() - at - 12) return;
    const auto sum =
        crc32(0, reinterpret_cast<const Bytef*>(b.data() + at + 4), static_cast<uInt>(length + 4));
    for (std::size_t k = 0; k < 4; ++k) b[at + 8 + length + k] = static_cast<char>(sum >> (24 - 8 * k));
    at += 12 + length;
  }
}

}  // namespace

std::string mutated(const std::string& whole, const std::string& other, Random& r) {
  const bool renew = r.below(2);
  const bool zipped = renew && whole.starts_with("\x1f\x8b");
  std::string b = zipped ? unpacked(whole) : whole;
  for (std::uint64_t edits = 1 + r.below(r.below(4) == 0 ? 8 : 2); edits > 0; --edits) edit(b, other, r);
  if (zipped) return packed(b);
  if (renew && b.starts_with("\x89PNG")) renew_png_checksums(b);
  return b;
}

}  // namespace terrazzo::torture
