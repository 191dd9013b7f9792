#include "nodes/export/formats/solvers/vtk_arrays.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "graph/diagnostic.h"
#include "graph/text/escape_xml.h"
#include "runtime/files/base64.h"

namespace terrazzo::exporting {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

std::size_t planes_per_block(const VtkArray& array) {
  return std::max<std::size_t>(1, kBlockBytes / std::max<std::size_t>(1, array.plane_bytes));
}

}  // namespace

VtkArray bytes_as_array(const std::string& name, const char* type, const void* data, std::size_t size) {
  return {name, type, 1, 1, size, [data, size](int, int, char* out) { std::memcpy(out, data, size); }};
}

void VtkStream::line(const VtkArray& array) {
  if (compression_ == VtkCompression::Zlib)
    compressed(array);
  else
    plain(array);
  out_ << '\n';
}

void VtkStream::element(const VtkArray& array) {
  out_ << "<DataArray type=\"" << array.type << "\" Name=\"" << escape_xml(array.name)
       << "\" NumberOfComponents=\"" << array.components << "\" format=\"binary\">\n";
  line(array);
  out_ << "</DataArray>\n";
}

void VtkStream::tuples(const VtkArray& array, std::size_t count) {
  out_ << fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfTuples=\"{}\" format=\"binary\">\n",
                      array.type, array.name, count);
  line(array);
  out_ << "</DataArray>\n";
}

// One length, then the bytes, encoded together.
void VtkStream::plain(const VtkArray& array) {
  Base64Writer text(out_);
  const std::uint64_t bytes = array.planes * array.plane_bytes;
  text.write(&bytes, sizeof bytes);
  const std::size_t batch = 16 * planes_per_block(array);
  std::vector<char> data(batch * array.plane_bytes);
  for (std::size_t first = 0; first < array.planes; first += batch) {
    const std::size_t count = std::min(batch, array.planes - first);
    work_.quiet().parallel(count, planes_per_block(array), [&](std::size_t begin, std::size_t end) {
      array.fill(static_cast<int>(first + begin), static_cast<int>(first + end),
                 data.data() + begin * array.plane_bytes);
    });
    text.write(data.data(), count * array.plane_bytes);
    work_.progress(double(first + count) / double(array.planes));
  }
  text.finish();
}

// Number and size of blocks, size of a last, smaller block or 0, and the compressed sizes, encoded; then
// the compressed blocks, encoded.
void VtkStream::compressed(const VtkArray& array) {
  const std::size_t per_block = planes_per_block(array);
  const std::size_t blocks = (array.planes + per_block - 1) / per_block;
  std::vector<std::string> packed(blocks);
  work_.parallel(blocks, 1, [&](std::size_t b, std::size_t) {
    const std::size_t first = b * per_block, last = std::min(array.planes, first + per_block);
    std::vector<char> data((last - first) * array.plane_bytes);
    array.fill(static_cast<int>(first), static_cast<int>(last), data.data());
    uLongf size = compressBound(data.size());
    packed[b].resize(size);
    if (compress2(reinterpret_cast<Bytef*>(packed[b].data()), &size,
                  reinterpret_cast<const Bytef*>(data.data()), data.size(), 4) != Z_OK)
      throw Error("not-enough-memory", "zlib has no memory to compress the voxels", "set compression: none");
    packed[b].resize(size);
    packed[b].shrink_to_fit();
  });
  const std::size_t rest = array.planes % per_block;
  std::vector<std::uint64_t> header = {blocks, per_block * array.plane_bytes, rest * array.plane_bytes};
  for (const auto& p : packed) header.push_back(p.size());
  Base64Writer head(out_), body(out_);
  head.write(header.data(), header.size() * sizeof header[0]);
  head.finish();
  for (const auto& p : packed) body.write(p.data(), p.size());
  body.finish();
}

}  // namespace terrazzo::exporting
