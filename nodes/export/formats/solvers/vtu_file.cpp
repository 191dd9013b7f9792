#include "nodes/export/formats/solvers/vtu_file.h"

#include <fmt/format.h>

#include <array>

#include "nodes/common/io/checked_file.h"
#include "nodes/export/formats/units.h"
#include "runtime/memory.h"

namespace terrazzo::exporting {
namespace {

constexpr int kCorners = 8;
constexpr double kCompressedBytes = 12;  // of a voxel's corners
constexpr char kHexahedron = 12;         // VTK_HEXAHEDRON

struct VtuMesh {
  explicit VtuMesh(const VoxelBox& b) : box(b), n((b.size + Vec3i::Ones()).cast<std::int64_t>()) {}
  std::int64_t point(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return i + n.x() * (j + n.y() * k);
  }
  const VoxelBox& box;
  Eigen::Matrix<std::int64_t, 3, 1> n;  // points along each axis
};

VtkArray points_of(const VtuMesh& m) {
  const std::size_t plane = m.n.x() * m.n.y();
  return {"points",
          "Float64",
          3,
          std::size_t(m.n.z()),
          3 * sizeof(double) * plane,
          [m](int z0, int z1, char* out) {
            auto* p = reinterpret_cast<double*>(out);
            for (int k = z0; k < z1; ++k)
              for (int j = 0; j < m.n.y(); ++j)
                for (int i = 0; i < m.n.x(); ++i)
                  for (int a = 0; a < 3; ++a) {
                    const std::array<int, 3> at = {i, j, k};
                    *p++ = (m.box.corner[a] + at[a] * m.box.spacing[a]) * kMetersPerMm;
                  }
          }};
}

VtkArray corners_of(const VtuMesh& m) {
  const Vec3i size = m.box.size;
  return {"connectivity",
          "Int64",
          1,
          std::size_t(size.z()),
          kCorners * sizeof(std::int64_t) * m.box.plane(),
          [m, size](int z0, int z1, char* out) {
            auto* corner = reinterpret_cast<std::int64_t*>(out);
            for (int k = z0; k < z1; ++k)
              for (int j = 0; j < size.y(); ++j)
                for (int i = 0; i < size.x(); ++i)
                  for (int up = 0; up < 2; ++up)
                    for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
                      *corner++ = m.point(i + x, j + y, k + up);
          }};
}

VtkArray offsets_of(const VtuMesh& m) {
  const std::size_t plane = m.box.plane();
  return {"offsets",
          "Int64",
          1,
          std::size_t(m.box.size.z()),
          sizeof(std::int64_t) * plane,
          [plane](int z0, int z1, char* out) {
            auto* offset = reinterpret_cast<std::int64_t*>(out);
            for (std::size_t c = plane * z0; c < plane * z1; ++c) *offset++ = kCorners * (c + 1);
          }};
}

VtkArray types_of(const VtuMesh& m) {
  const std::size_t plane = m.box.plane();
  return {
      "types", "UInt8",
      1,       std::size_t(m.box.size.z()),
      plane,   [plane](int z0, int z1, char* out) { std::fill(out, out + plane * (z1 - z0), kHexahedron); }};
}

// The points of the sides X0, X1, Y0, … Z1.
std::array<std::vector<std::int64_t>, 6> side_points(const VtuMesh& m) {
  std::array<std::vector<std::int64_t>, 6> out;
  for (int a = 0; a < 3; ++a)
    for (int side = 0; side < 2; ++side) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      std::array<std::int64_t, 3> at{};
      at[a] = side * (m.n[a] - 1);
      for (at[c] = 0; at[c] < m.n[c]; ++at[c])
        for (at[b] = 0; at[b] < m.n[b]; ++at[b]) out[2 * a + side].push_back(m.point(at[0], at[1], at[2]));
    }
  return out;
}

}  // namespace

void write_vtu(const std::filesystem::path& path, const VtiContent& content, std::uint64_t memory,
               const Work& work) {
  const std::vector<VtkArray> cells = cell_arrays(content);
  const VtuMesh mesh(content.box);
  const bool compressed = content.compression == VtkCompression::Zlib;
  const double on_sides =
      2.0 * double(mesh.n.x() * mesh.n.y() + mesh.n.y() * mesh.n.z() + mesh.n.z() * mesh.n.x());
  require_memory(
      (compressed ? kCompressedBytes * double(content.box.count()) : 0) + sizeof(std::int64_t) * on_sides,
      memory, "the mesh of the volume");
  const auto sides = side_points(mesh);
  std::vector<VtkArray> side_arrays;
  for (std::size_t s = 0; s < sides.size(); ++s)
    side_arrays.push_back(bytes_as_array(fmt::format("nodes_{}{}", "XYZ"[s / 2], s % 2), "Int64",
                                         sides[s].data(), sides[s].size() * sizeof(std::int64_t)));
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    const double steps = cells.size() + 4;
    double done = 0;
    const auto add = [&](const VtkArray& array) {
      VtkStream(out, content.compression, work.part(done / steps, (done + 1) / steps)).element(array);
      ++done;
    };
    out << "<?xml version=\"1.0\"?>\n"
        << "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt64\""
        << (compressed ? " compressor=\"vtkZLibDataCompressor\"" : "") << ">\n<UnstructuredGrid>\n";
    write_field_data(out, content, work, side_arrays);
    out << fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n", mesh.n.prod(),
                       content.box.count());
    add(points_of(mesh));
    out << "</Points>\n<Cells>\n";
    add(corners_of(mesh));
    add(offsets_of(mesh));
    add(types_of(mesh));
    out << "</Cells>\n<CellData" << (content.regions ? " Scalars=\"material\"" : "") << ">\n";
    for (const VtkArray& array : cells) add(array);
    out << "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  });
}

}  // namespace terrazzo::exporting
