#include "nodes/common/io/provenance_text.h"

#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <sstream>

#include "graph/input_file.h"
#include "nodes/data/indices.h"
#include "runtime/files/base64.h"

namespace terrazzo {
namespace {

constexpr std::size_t kLongest = std::size_t{16} << 20;  // bytes of provenance

std::string beginning_of(const std::filesystem::path& path) { return read_beginning(path, kLongest); }

}  // namespace

std::string provenance_in_usda(const std::filesystem::path& path) {
  const std::string text = beginning_of(path), key = "string provenance = \"";
  const auto at = text.find(key);
  if (!text.starts_with("#usda") || at == std::string::npos) return "";
  std::string out;
  for (std::size_t i = at + key.size(); i < text.size() && text[i] != '"'; ++i) {
    if (text[i] != '\\') {
      out += text[i];
    } else if (++i < text.size()) {
      out += text[i] == 'n' ? '\n' : text[i];
    }
  }
  return out;
}

std::string provenance_in_scene(const std::filesystem::path& path) {
  std::istringstream lines(beginning_of(path));
  std::string out;
  for (std::string line; std::getline(lines, line) && (line.starts_with("#") || line.starts_with("<"));) {
    if (line.starts_with("# provenance ")) return line.substr(13);
    if (line.starts_with("<!-- provenance ") && line.ends_with(" -->"))
      return decode_base64(std::string_view(line).substr(16, line.size() - 20), out) ? out : "";
  }
  return "";
}

std::string provenance_in_inp(const std::filesystem::path& path) {
  std::istringstream lines(beginning_of(path));
  const std::string key = "**provenance ";
  std::string out;
  for (std::string line; std::getline(lines, line) && line.starts_with("**");)
    if (line.starts_with(key)) out += line.substr(key.size());
  return out;
}

std::string provenance_in_vti(const std::filesystem::path& path) {
  const std::string text = beginning_of(path);
  const auto at = text.find(" Name=\"provenance\"");
  const auto begin = text.find('\n', at), end = text.find('\n', begin + 1);
  if (at == std::string::npos || begin == std::string::npos || end == std::string::npos) return "";
  const std::string_view line = std::string_view(text).substr(begin + 1, end - begin - 1);
  const bool compressed = text.substr(0, at).find("vtkZLibDataCompressor") != std::string::npos;
  std::string bytes;
  if (!compressed) {
    if (!decode_base64(line, bytes) || bytes.size() < 9) return "";
    return bytes.substr(8, bytes.size() - 9);  // after the length, without the final 0
  }
  std::array<std::uint64_t, 4> header;  // blocks, size, size of the last, compressed size
  constexpr std::size_t kHeaderDigits = (sizeof header + 2) / 3 * 4;
  if (line.size() < kHeaderDigits || !decode_base64(line.substr(0, kHeaderDigits), bytes) ||
      bytes.size() != sizeof header)
    return "";
  std::memcpy(header.data(), bytes.data(), sizeof header);
  uLongf size = header[2] ? header[2] : header[1];
  if (header[0] != 1 || size < 1 || size > kLongest || !decode_base64(line.substr(kHeaderDigits), bytes))
    return "";
  std::string out(size, '\0');
  if (uncompress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                 bytes.size()) != Z_OK ||
      size != out.size())
    return "";
  out.pop_back();
  return out;
}

std::string provenance_in_nifti(const std::filesystem::path& path) {
  const InputFile opened(path);
  const auto close = [](gzFile_s* f) { gzclose(f); };
  // Also reads what is not compressed. Closes its own descriptor.
  const std::unique_ptr<gzFile_s, decltype(close)> file(
      opened ? gzdopen(::dup(opened.descriptor()), "rb") : nullptr, close);
  std::array<char, 360> head;
  if (!file || gzread(file.get(), head.data(), head.size()) != count_of(head) || head[348] != 1) return "";
  std::array<std::int32_t, 2> extension;  // size with these numbers, code
  std::memcpy(extension.data(), head.data() + 352, sizeof extension);
  if (extension[1] != 6 || extension[0] < 8 || extension[0] > static_cast<std::int32_t>(kLongest)) return "";
  std::string out(static_cast<std::size_t>(extension[0]) - 8, '\0');
  if (gzread(file.get(), out.data(), static_cast<unsigned>(out.size())) != count_of(out)) return "";
  return out.substr(0, out.find('\0'));
}

}  // namespace terrazzo
