#include "nodes/export/formats/vti_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "graph/text/escape_xml.h"
#include "nodes/common/io/checked_file.h"
#include "runtime/files/base64.h"

namespace terrazzo::exporting {
namespace {

constexpr double kMetersPerMm = 0.001;
constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

// One array of the file: planes of `plane_bytes` bytes each.
struct VtiArray {
  std::string name;
  bool whole = true;
  int components = 1;
  std::size_t planes = 0, plane_bytes = 0;
  std::function<void(int z0, int z1, char* out)> fill;
};

std::vector<VtiArray> arrays_of(const VtiContent& content) {
  std::vector<VtiArray> arrays;
  const std::size_t planes = content.box.size.z();
  const std::size_t plane = content.box.plane();
  const auto add_numbers = [&](const char* name, auto&& number) {
    arrays.push_back({name, true, 1, planes, 4 * plane, [&content, plane, number](int z0, int z1, char* out) {
                        content.id->read(z0, z1, out);
                        auto* ids = reinterpret_cast<std::int32_t*>(out);
                        for (std::size_t i = 0; i < plane * (z1 - z0); ++i)
                          ids[i] = number(*content.regions, ids[i]);
                      }});
  };
  if (content.regions) {
    add_numbers("material", [](const Regions& r, std::int32_t id) { return r.number(id); });
    add_numbers("phase", [](const Regions& r, std::int32_t id) { return r.phase(id); });
  }
  for (const VoxelSource& grid : content.grids)
    arrays.push_back({grid.name(), grid.whole(), grid.components(), planes, grid.voxel_bytes() * plane,
                      [&grid](int z0, int z1, char* out) { grid.read(z0, z1, out); }});
  std::set<std::string> names;
  for (const VtiArray& a : arrays) {
    if (a.name.empty() || std::any_of(a.name.begin(), a.name.end(), [](unsigned char c) { return c < 32; }))
      throw Error("bad-names", "a grid has no name, or control characters in its name",
                  "choose other grids with grids")
          .parameter("grids");
    if (!names.insert(a.name).second)
      throw Error(
          "bad-names", fmt::format("two arrays of the file would be named '{}'", a.name),
          "the names material and phase are taken by the numbers of particles; leave that grid out with "
          "grids")
          .parameter("grids");
  }
  return arrays;
}

class VtiStream {
 public:
  VtiStream(std::ostream& out, VtiCompression compression, const Work& work)
      : out_(out), compression_(compression), work_(work) {}

  // The encoded array on one line.
  void line(const VtiArray& array) {
    if (compression_ == VtiCompression::Zlib)
      compressed(array);
    else
      plain(array);
    out_ << '\n';
  }

 private:
  // One length, then the bytes, encoded together.
  void plain(const VtiArray& array) {
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
  void compressed(const VtiArray& array) {
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
        throw Error("not-enough-memory", "zlib has no memory to compress the voxels",
                    "set compression: none");
      packed[b].resize(size);
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

  static std::size_t planes_per_block(const VtiArray& array) {
    return std::max<std::size_t>(1, kBlockBytes / std::max<std::size_t>(1, array.plane_bytes));
  }

  std::ostream& out_;
  VtiCompression compression_;
  const Work& work_;
};

VtiArray bytes_as_array(const void* data, std::size_t size) {
  return {"", true, 1, 1, size, [data, size](int, int, char* out) { std::memcpy(out, data, size); }};
}

}  // namespace

void write_vti(const std::filesystem::path& path, const VtiContent& content, const Work& work) {
  const std::vector<VtiArray> arrays = arrays_of(content);
  const VoxelBox& box = content.box;
  const std::string extent = fmt::format("0 {} 0 {} 0 {}", box.size.x(), box.size.y(), box.size.z());
  const auto meters = [](const Vec3& mm) {
    // 12 digits: 0.1 mm is 0.0001, not 0.00010000000000000002
    return fmt::format("{:.12g} {:.12g} {:.12g}", mm.x() * kMetersPerMm, mm.y() * kMetersPerMm,
                       mm.z() * kMetersPerMm);
  };
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    out << "<?xml version=\"1.0\"?>\n"
        << "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\""
        << (content.compression == VtiCompression::Zlib ? " compressor=\"vtkZLibDataCompressor\"" : "")
        << ">\n"
        << "<ImageData WholeExtent=\"" << extent << "\" Origin=\"" << meters(box.corner) << "\" Spacing=\""
        << meters(box.spacing) << "\" Direction=\"1 0 0 0 1 0 0 0 1\">\n";
    const Work quiet = work.quiet();
    VtiStream fields(out, content.compression, quiet);
    out << "<FieldData>\n";
    if (!content.provenance.empty()) {
      out << "<Array type=\"String\" Name=\"provenance\" NumberOfTuples=\"1\" format=\"binary\">\n";
      fields.line(bytes_as_array(content.provenance.c_str(), content.provenance.size() + 1));  // ends with 0
      out << "</Array>\n";
    }
    if (box.periodic) {
      out << "<DataArray type=\"Int32\" Name=\"period\" NumberOfTuples=\"3\" format=\"binary\">\n";
      fields.line(bytes_as_array(box.size.data(), 3 * sizeof(std::int32_t)));
      out << "</DataArray>\n";
    }
    out << "</FieldData>\n<Piece Extent=\"" << extent << "\">\n<PointData>\n</PointData>\n<CellData"
        << (content.regions ? " Scalars=\"material\"" : "") << ">\n";
    double done = 0, all = 0;
    for (const VtiArray& a : arrays) all += double(a.plane_bytes);
    for (const VtiArray& a : arrays) {
      out << "<DataArray type=\"" << (a.whole ? "Int32" : "Float32") << "\" Name=\"" << escape_xml(a.name)
          << "\" NumberOfComponents=\"" << a.components << "\" format=\"binary\">\n";
      const Work part = work.part(done / all, (done + double(a.plane_bytes)) / all);
      VtiStream(out, content.compression, part).line(a);
      out << "</DataArray>\n";
      done += double(a.plane_bytes);
    }
    out << "</CellData>\n</Piece>\n</ImageData>\n</VTKFile>\n";
  });
}

}  // namespace terrazzo::exporting
