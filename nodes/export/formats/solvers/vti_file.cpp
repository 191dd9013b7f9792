#include "nodes/export/formats/solvers/vti_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "graph/text/escape_xml.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/export/formats/units.h"

namespace terrazzo::exporting {

std::vector<VtkArray> cell_arrays(const VtiContent& content) {
  std::vector<VtkArray> arrays;
  const std::size_t planes = content.box.size.z();
  const std::size_t plane = content.box.plane();
  const auto add_numbers = [&](const char* name, auto&& number) {
    arrays.push_back(
        {name, "Int32", 1, planes, 4 * plane, [&content, plane, number](int z0, int z1, char* out) {
           content.id->read(z0, z1, out);
           auto* ids = reinterpret_cast<std::int32_t*>(out);
           for (std::size_t i = 0; i < plane * (z1 - z0); ++i) ids[i] = number(*content.regions, ids[i]);
         }});
  };
  if (content.regions) {
    add_numbers("material", [](const Regions& r, std::int32_t id) { return r.number(id); });
    add_numbers("phase", [](const Regions& r, std::int32_t id) { return r.phase(id); });
  }
  for (const VoxelSource& grid : content.grids)
    arrays.push_back({grid.name(), grid.whole() ? "Int32" : "Float32", grid.components(), planes,
                      grid.voxel_bytes() * plane,
                      [&grid](int z0, int z1, char* out) { grid.read(z0, z1, out); }});
  std::set<std::string> names;
  for (const VtkArray& a : arrays) {
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

void write_field_data(std::ostream& out, const VtiContent& content, const Work& work,
                      const std::vector<VtkArray>& more) {
  VtkStream fields(out, content.compression, work.quiet());
  out << "<FieldData>\n";
  if (!content.provenance.empty()) {
    out << "<Array type=\"String\" Name=\"provenance\" NumberOfTuples=\"1\" format=\"binary\">\n";
    fields.line(
        bytes_as_array("", "", content.provenance.c_str(), content.provenance.size() + 1));  // ends with 0
    out << "</Array>\n";
  }
  if (content.box.periodic)
    fields.tuples(bytes_as_array("period", "Int32", content.box.size.data(), 3 * sizeof(std::int32_t)), 3);
  for (const VtkArray& array : more)
    fields.tuples(array, array.planes * array.plane_bytes / sizeof(std::int64_t));
  out << "</FieldData>\n";
}

void write_vti(const std::filesystem::path& path, const VtiContent& content, const Work& work) {
  const std::vector<VtkArray> arrays = cell_arrays(content);
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
        << (content.compression == VtkCompression::Zlib ? " compressor=\"vtkZLibDataCompressor\"" : "")
        << ">\n"
        << "<ImageData WholeExtent=\"" << extent << "\" Origin=\"" << meters(box.corner) << "\" Spacing=\""
        << meters(box.spacing) << "\" Direction=\"1 0 0 0 1 0 0 0 1\">\n";
    write_field_data(out, content, work, {});
    out << "<Piece Extent=\"" << extent << "\">\n<PointData>\n</PointData>\n<CellData"
        << (content.regions ? " Scalars=\"material\"" : "") << ">\n";
    double done = 0, all = 0;
    for (const VtkArray& a : arrays) all += double(a.plane_bytes);
    for (const VtkArray& a : arrays) {
      VtkStream(out, content.compression, work.part(done / all, (done + double(a.plane_bytes)) / all))
          .element(a);
      done += double(a.plane_bytes);
    }
    out << "</CellData>\n</Piece>\n</ImageData>\n</VTKFile>\n";
  });
}

}  // namespace terrazzo::exporting
