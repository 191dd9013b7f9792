#include "tests/torture/input_seeds.h"

#include <zlib.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "nodes/common/io/image_file.h"
#include "nodes/data/labels.h"
#include "nodes/data/shapes.h"
#include "nodes/data/volume.h"
#include "nodes/export/formats/gltf.h"
#include "nodes/export/formats/mesh_file.h"
#include "nodes/export/formats/nifti_file.h"
#include "nodes/export/formats/npy_file.h"
#include "nodes/export/formats/picture_file.h"
#include "nodes/export/formats/solid_texture.h"
#include "nodes/export/formats/solvers/dream3d_file.h"
#include "nodes/export/formats/solvers/vti_file.h"
#include "nodes/export/formats/vdb_file.h"
#include "runtime/files.h"
#include "runtime/random.h"
#include "tests/nodes/volumes/load_volume/nifti_file.h"
#include "tests/support/png_file.h"
#include "tests/support/tiff_file.h"
#include "tests/support/zip_file.h"

namespace terrazzo::torture {
namespace {
using namespace exporting;
namespace fs = std::filesystem;

// One folder per seed, such as "LoadVolume.vdb/1", in which the reader opens the first file.
class Writer {
 public:
  explicit Writer(fs::path folder) : folder_(std::move(folder)) {}
  fs::path place(const std::string& reader, const std::string& name) {
    const fs::path folder = folder_ / reader / std::to_string(++count_[reader]);
    fs::create_directories(folder);
    return folder / name;
  }
  void text(const std::string& reader, const std::string& name, const std::string& content) {
    std::ofstream(place(reader, name), std::ios::binary) << content;
  }

 private:
  fs::path folder_;
  std::map<std::string, int> count_;
};

Image picture(int width, int height, bool smooth) {
  Image image(width, height, 1, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Random r(1, 1, static_cast<std::uint64_t>(y * width + x));
      image.at(x, y) = smooth ? Vec3f(float(x) / float(width), 0.5f, float(y) / float(height))
                              : Vec3f(float(r.uniform()), float(r.uniform()), float(r.uniform()));
    }
  return image;
}

void pictures(Writer& w) {
  for (const bool smooth : {false, true}) {
    const Image image = picture(23, 17, smooth);
    for (const char* name : {"a.png", "a.jpg", "a.tif", "a.exr", "a.hdr", "a.bmp", "a.ppm"}) {
      const std::string extension = fs::path(name).extension();
      write_image(w.place("LoadImage" + extension, name), image, 0, "{\"document\":\"\"}");
    }
    for (const char* name : {"a.png", "a.jpg", "a.tif", "a.exr"})
      write_image(w.place("provenance" + fs::path(name).extension().string(), name), image, 0,
                  "{\"document\":\"\"}");
  }
  Labels labels;
  labels.width = 9;
  labels.height = 7;
  labels.sections = 1;
  labels.pixel_size = 1;
  for (int i = 0; i < 63; ++i) labels.ids.push_back(i % 5);
  labels.classes.assign(4, 0);
  write_labels(w.place("LoadLabels.png", "a.png"), labels);
  write_labels(w.place("LoadLabels.tif", "a.tif"), labels);
  write_labels(w.place("LoadVolume.tif", "a.tif"), labels);
}

// What masks, volumes and photographs of other programs look like.
void stored_pictures(Writer& w) {
  using test::png_chunk;
  const std::string palette = png_chunk("PLTE", {0, 0, 0, 9, 9, 9, 80, 9, 9, 1, 2, 3});
  const std::string png =
      test::png_file({4, 2, 2, 3, {'\x1b', '\x4e'}, palette + png_chunk("tRNS", {'\xff', 0})});
  const auto little = [](std::uint32_t v) { return test::number_bytes<std::uint32_t>({v}); };
  const std::string bmp = "BM" + little(0) + little(0) + little(70) + little(40) + little(4) + little(1) +
                          std::string{1, 0, 8, 0} + std::string(16, '\0') + little(4) + little(0) +
                          std::string(16, '\x40') + std::string{3, 0, 1, 2};
  const std::string gif = std::string("GIF89a\2\0\1\0\x81\0\0", 13) + std::string(12, '\x33') +
                          std::string("\x2c\0\0\0\0\2\0\1\0\0\2\2\x8c\x0a\0\x3b", 16);
  test::TiffPage bits{5, 3};
  bits.bits = 1;
  bits.photometric = 0;
  bits.pixels = {'\x50', '\x20', '\x88'};
  test::TiffPage stack{2, 2};
  stack.pixels = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  stack.description = "ImageJ=1.5\nimages=3\nslices=3\n";
  test::TiffPage plane{2, 1};
  plane.pixels = {1, 2};
  plane.description =
      "<OME><Image><Pixels SizeC=\"1\" SizeZ=\"2\" SizeT=\"1\" DimensionOrder=\"XYCZT\"><TiffData IFD=\"0\" "
      "PlaneCount=\"2\"/></Pixels></Image></OME>";
  test::TiffPage thumbnail = bits;
  thumbnail.tags = {{254, {1}}};
  thumbnail.sub_pages = {plane};
  w.text("LoadLabels.png", "a.png", png);
  w.text("LoadLabels.bmp", "a.bmp", bmp);
  w.text("LoadLabels.gif", "a.gif", gif);
  w.text("LoadLabels.pnm", "a.pgm", "P2\n# c\n3 1\n15\n0 3 15\n");
  w.text("LoadLabels.pnm", "a.pbm", "P4 9 2\n\x60\x01\x60\x01");
  w.text("LoadLabels.tif", "a.tif", test::tiff_file({bits}));
  w.text("LoadImage.gif", "a.gif", gif);
  w.text("LoadImage.tif", "a.tif", test::tiff_file({thumbnail}));
  w.text("LoadVolume.tif", "a.tif", test::tiff_file({stack}));
  w.text("LoadVolume.tif", "a.tif", test::tiff_file({plane, plane, bits}));
  w.text("LoadVolume.tif", "a.tif", test::tiff_file({plane, plane}, {true, true}));
  const std::string bare = test::tiff_file({bits});
  test::write_zip(w.place("LoadVolume.zip", "a.zip"), {{"a/1.tif", bare}, {"a/2.tif", bare}});
  w.text("LoadImage.png", "a.png",
         test::png_file({1, 1, 8, 2, "abc",
                         png_chunk("gAMA", test::png_number(55556)) + png_chunk("cICP", {12, 13, 0, 1})}));
}

void meshes(Writer& w) {
  Shapes shapes;
  shapes.shapes.emplace_back();
  Mesh& m = shapes.shapes[0].mesh;
  for (int i = 0; i < 8; ++i) m.vertices.push_back(Vec3(i & 1, i >> 1 & 1, i >> 2 & 1));
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  for (const char* name : {"a.obj", "a.ply", "a.stl"})
    write_mesh(w.place("LoadMesh" + fs::path(name).extension().string(), name), shapes);
  write_glb(w.place("LoadMesh.glb", "a.glb"), shapes);
  w.text(
      "LoadMesh.gltf", "a.gltf",
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"scale":[1,2,1]}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"accessors":[{"bufferView":0,)"
      R"("componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},{"bufferView":1,)"
      R"("componentType":5121,"count":12,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":48},)"
      R"({"buffer":0,"byteOffset":48,"byteLength":12}],"buffers":[{"byteLength":60,"uri":)"
      R"("data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAIBAAEDAAMCAQID"}]})");
  std::ostringstream vertices, faces, facets;
  for (const auto& v : m.vertices) vertices << v.transpose() << "\n";
  for (const auto& t : m.triangles) {
    faces << "3 " << t[0] << " " << t[1] << " " << t[2] << "\n";
    facets << "facet normal 0 0 1\nouter loop\n";
    for (const int v : t) facets << "vertex " << m.vertices[static_cast<std::size_t>(v)].transpose() << "\n";
    facets << "endloop\nendfacet\n";
  }
  w.text("LoadMesh.off", "a.off", "OFF\n8 12 0\n" + vertices.str() + faces.str());
  w.text("LoadMesh.stl", "a.stl", "solid s\n" + facets.str() + "endsolid s\n");
  w.text("LoadMesh.ply", "a.ply",
         "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 12\nproperty list uchar int vertex_indices\nend_header\n" +
             vertices.str() + faces.str());
  w.text("LoadMesh.ply", "strips.ply",
         "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
         "0 0 0\n1 0 0\n0 1 0\n0 0 1\n12 0 2 1 3 -1 1 3 0 -1 0 3 2\n");
}

void vdbs(Writer& w) {
  initialize_openvdb();
  Volume v;
  v.resolution = Vec3i(16, 16, 16);
  const auto add = [&]<class Grid>(const char* name, auto value) {
    auto g = Grid::create();
    g->setName(name);
    g->setTransform(voxel_transform(0.25));
    for (int i = 0; i < 50; ++i) g->tree().setValue(openvdb::Coord(i % 7 - 3, i % 11, i), value(i));
    g->tree().addTile(1, openvdb::Coord(512, 0, 0), value(3), true);
    g->tree().addTile(3, openvdb::Coord(8192, 0, 0), value(4), true);
    v.grids = {g};
    write_vdb(w.place("LoadVolume.vdb", "a.vdb"), v, "{}");
  };
  add.template operator()<openvdb::FloatGrid>("density", [](int i) { return 0.1f * float(i); });
  write_vdb(w.place("provenance.vdb", "a.vdb"), v, "{\"document\":\"\"}");
  add.template operator()<openvdb::Vec3SGrid>("Cd", [](int i) { return openvdb::Vec3s(float(i)); });
  add.template operator()<openvdb::BoolGrid>("mask", [](int i) { return i % 2 == 0; });
}

void voxel_files(Writer& w) {
  initialize_openvdb();
  Volume v;
  v.resolution = Vec3i(4, 3, 2);
  auto id = openvdb::Int32Grid::create(-1);
  auto color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.5f));
  id->setName("id");
  id->setTransform(voxel_transform(0.25));
  color->setName("Cd");
  color->setTransform(voxel_transform(0.25));
  for (int i = 0; i < 4; ++i) id->tree().setValue(openvdb::Coord(i, i % 3, i % 2), i);
  write_vdb(w.place("LoadVolume.vdb", "a.vdb"), {v.resolution, {id}}, "{}");  // whole numbers as floats
  v.grids = {id, color};
  const VoxelBox box = voxel_box(v);
  const VoxelSource ids(v, "id", box), colors(v, "Cd", box);
  const Regions regions = find_regions(ids, box, nullptr, RegionKind::Particles, {});
  for (const auto compression : {VtkCompression::Zlib, VtkCompression::None})
    for (const char* reader : {"LoadVolume.vti", "provenance.vti"})
      write_vti(w.place(reader, "a.vti"),
                {box, {ids, colors}, &ids, &regions, compression, "{\"document\":\"\"}"});
  w.text("LoadVolume.vti", "a.vti",
         "<VTKFile type=\"ImageData\" compressor=\"\"><ImageData WholeExtent=\"0 2 0 1 0 1\" Spacing=\"1 1 "
         "1\"><Piece>"
         "<CellData><DataArray type=\"Int8\" Name=\"a\">1 2</DataArray><DataArray type=\"UInt8\" Name=\"b\" "
         "format=\"appended\" offset=\"0\"/></CellData></Piece></ImageData><AppendedData encoding=\"raw\">_" +
             std::string("\2\0\0\0\1\2", 6) + "</AppendedData></VTKFile>");
  for (const char* reader : {"LoadVolume.dream3d", "provenance.dream3d"})
    write_dream3d(w.place(reader, "a.dream3d"),
                  {box, {ids, colors}, &ids, &regions, nullptr, "{\"document\":\"\"}"});
  write_npy(w.place("LoadVolume.npy", "a.npy"), ids, box);
  write_nifti(w.place("provenance.nii", "a.nii"), ids, box, "{\"document\":\"\"}");
  write_ktx2(w.place("provenance.ktx2", "a.ktx2"), solid_texels(v, {"Cd"}, false, 1 << 20),
             "{\"document\":\"\"}");
}

void niftis(Writer& w) {
  const auto n = test::NiftiFile::counting();
  n.write(w.place("LoadVolume.nii", "a.nii"));
  const fs::path pair = w.place("LoadVolume.pair", "a.hdr");
  n.write_pair(pair, fs::path(pair).replace_extension(".img"));
  const std::string whole = *read_file(n.write(w.place("LoadVolume.nii", "b.nii")));
  const gzFile f = gzopen(w.place("LoadVolume.gz", "a.nii.gz").c_str(), "wb");
  gzwrite(f, whole.data(), static_cast<unsigned>(whole.size()));
  gzclose(f);
}

// A DICOM element in explicit little endian.
std::string element(std::uint32_t tag, const std::string& kind, std::string value) {
  if (value.size() % 2) value += kind == "UI" ? '\0' : ' ';
  std::string out;
  for (const unsigned shift : {16u, 24u, 0u, 8u}) out += static_cast<char>(tag >> shift);
  out += kind;
  const auto size = static_cast<std::uint32_t>(value.size());
  const bool wide = kind == "OW" || kind == "OB" || kind == "SQ";
  if (wide) out += std::string(2, '\0');
  for (unsigned shift = 0; shift < (wide ? 32u : 16u); shift += 8) out += static_cast<char>(size >> shift);
  return out + value;
}

void dicoms(Writer& w) {
  const auto number = [](int v) { return std::string{static_cast<char>(v), static_cast<char>(v >> 8)}; };
  const auto file = [&](const std::string& syntax, const std::string& pixels) {
    return std::string(128, '\0') + "DICM" + element(0x00020010, "UI", syntax) +
           element(0x00180050, "DS", "2") + element(0x0020000e, "UI", "1.2.3") +
           element(0x00200032, "DS", "-10\\-20\\5") + element(0x00200037, "DS", "1\\0\\0\\0\\1\\0") +
           element(0x00280002, "US", number(1)) + element(0x00280004, "CS", "MONOCHROME2") +
           element(0x00280010, "US", number(2)) + element(0x00280011, "US", number(3)) +
           element(0x00280030, "DS", "0.7\\0.8") + element(0x00280100, "US", number(16)) +
           element(0x00280101, "US", number(12)) + element(0x00280102, "US", number(11)) +
           element(0x00280103, "US", number(1)) + element(0x00281052, "DS", "-1000") +
           element(0x00281053, "DS", "2") + pixels;
  };
  std::string values;
  for (int i = 0; i < 6; ++i) values += number(100 * i);
  w.text("LoadVolume.dcm", "a.dcm", file("1.2.840.10008.1.2.1", element(0x7fe00010, "OW", values)));
  // Run-length encoded: two segments, the high bytes and the low bytes, each as one literal run.
  std::string rle(64, '\0'), high = "\5", low = "\5";
  rle[0] = 2;
  rle[4] = 64;
  rle[8] = 72;
  for (int i = 0; i < 6; ++i)
    high += values[static_cast<std::size_t>(2 * i + 1)], low += values[static_cast<std::size_t>(2 * i)];
  rle += high + '\0' + low + '\0';
  const auto item = [](const std::string& value) {
    return std::string("\xfe\xff\x00\xe0", 4) + static_cast<char>(value.size()) + std::string(3, '\0') +
           value;
  };
  const std::string fragments = std::string("\xe0\x7f\x10\x00OB\0\0\xff\xff\xff\xff", 12) + item("") +
                                item(rle) + std::string("\xfe\xff\xdd\xe0\0\0\0\0", 8);
  w.text("LoadVolume.dcm", "b.dcm", file("1.2.840.10008.1.2.5", fragments));
}

// One number per voxel after a header of text or words.
void arrays(Writer& w) {
  std::string voxels;
  for (int i = 0; i < 12; ++i) voxels += {static_cast<char>(i), '\0'};
  uLongf size = 200;
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(voxels.data()),
           voxels.size());
  packed.resize(size);
  const std::string nrrd = "NRRD0004\ntype: short\ndimension: 3\nsizes: 3 2 2\nendian: little\n";
  w.text(
      "LoadVolume.nrrd", "a.nrrd",
      nrrd +
          "encoding: raw\nspace: left-posterior-superior\nspace directions: (0.5,0,0) (0,2,0) (0,0,1)\n\n" +
          voxels);
  w.text("LoadVolume.nrrd", "a.nrrd",
         nrrd + "encoding: ascii\nspacings: 1 1 2\n\n1 2 3 4 5 6\n7 8 9 10 11 12\n");
  w.text("LoadVolume.nrrd", "a.nrrd", nrrd + "encoding: gzip\nspacings: 1 1 2\n\n" + packed);
  const fs::path header = w.place("LoadVolume.nrrd", "a.nhdr");
  std::ofstream(header) << nrrd + "encoding: raw\nspacings: 1 1 1\nbyte skip: -1\ndata file: a.raw\n";
  std::ofstream(header.parent_path() / "a.raw", std::ios::binary) << "ab" << voxels;
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nDimSize = 3 2 2\nElementSpacing = 1 1 2\nElementType = MET_SHORT\n"
      "TransformMatrix = 0 1 0 1 0 0 0 0 1\n";
  w.text("LoadVolume.mha", "a.mha", meta + "ElementByteOrderMSB = True\nElementDataFile = LOCAL\n" + voxels);
  w.text("LoadVolume.mha", "a.mha", meta + "CompressedData = True\nElementDataFile = LOCAL\n" + packed);
  const fs::path beside = w.place("LoadVolume.mha", "a.mhd");
  std::ofstream(beside) << meta + "HeaderSize = 2\nElementDataFile = a.raw\n";
  std::ofstream(beside.parent_path() / "a.raw", std::ios::binary) << "ab" << voxels;
  std::string mrc(1024, '\0');
  const auto put = [&](std::size_t word, auto v) { std::memcpy(mrc.data() + 4 * (word - 1), &v, 4); };
  const std::int32_t numbers[] = {3, 2, 2, 1, 0, 0, 0, 3, 2, 2};
  for (std::size_t k = 0; k < 10; ++k) put(k + 1, numbers[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    put(k + 11, 2e7f);
    put(k + 14, 90.0f);
    put(k + 17, static_cast<std::int32_t>(3 - k));
  }
  put(23, std::int32_t{1});
  mrc.replace(208, 4, "MAP ");
  mrc[212] = mrc[213] = 0x44;
  w.text("LoadVolume.mrc", "a.mrc", mrc + voxels);
}

void texts(Writer& w, const fs::path& source) {
  const auto content = [&](const char* name) { return read_file(source / name).value_or(""); };
  w.text("LoadProfiles.csv", "a.csv",
         "Label,Area (mm2),X,Class,Section\n1,7.5,71.85,0,0\n2,1.5e1,52,1,0\n3,9,17,0,1\n");
  w.text("LoadProfiles.csv", "a.csv", "# remark\ndiameter;weight\n1,5;2\n2,5;1\n");
  w.text("LoadProfiles.csv", "a.csv", " ,Area (\xb5m\xb2),Feret (\xb5m)\r1,7,3\rMean,7,3\r");
  w.text("LoadProfiles.csv", "a.csv",
         std::string("\xff\xfe"
                     "d\0_\0u\0m\0,\0e\0c\0d\0\r\0\n\0"
                     "1\0,\0"
                     "2\0",
                     28));
  w.text("LoadProfiles.json", "a.json",
         "{\"observed_area\":100,\"sections\":2,\"classes\":1,\"window\":[5,10],\"binder_color\":[0,0.5,1],"
         "\"area_fraction\":0.25,\"profiles\":[{\"section\":1,\"class\":0,\"area\":2.5,\"centroid\":[1,2],"
         "\"touches_border\":false,\"weight\":1.25,\"confidence\":1,\"color\":[0,1,0.5],"
         "\"contour\":[[0,0],[1,0],[1,1]]}]}");
  const std::string geojson =
      "{\"type\":\"FeatureCollection\",\"picture\":{\"width\":9,\"height\":8,\"pixel_size_mm\":0.5},"
      "\"features\":[{\"type\":\"Feature\",\"geometry\":{\"type\":\"MultiPolygon\",\"coordinates\":[[[[1,1],["
      "5,"
      "1],[5,5],[1,5],[1,1]],[[2,2],[2,3],[3,3],[2,2]]]]},\"properties\":{\"class\":1,\"section\":0}}]}";
  const std::string coco =
      "{\"images\":[{\"id\":1,\"width\":9,\"height\":8}],\"categories\":[{\"id\":2}],\"annotations\":["
      "{\"image_id\":1,\"category_id\":2,\"segmentation\":[[1,1,5,1,5,5]]},{\"image_id\":1,\"category_id\":2,"
      "\"segmentation\":{\"size\":[8,9],\"counts\":[56,3,13]}},{\"image_id\":1,\"category_id\":2,"
      "\"segmentation\":{\"size\":[8,9],\"counts\":\"03U2\"}}]}";
  std::string roi("Iout\0\xe4\0\0\0\2\0\1\0\5\0\6\0\3", 18);
  roi.resize(63);
  roi += std::string("\x4c\0\0\0\5\0\3\0\0\0\2\0\3", 13);
  roi.resize(140);
  w.text("LoadProfiles.geojson", "a.geojson", geojson);
  w.text("LoadProfiles.json", "a.json", coco);
  w.text("LoadProfiles.roi", "a.roi", roi);
  w.text("LoadEBSD.ang", "a.ang",
         "# Phase 1\n# MaterialName a\n# Symmetry 43\n# GRID: HexGrid\n# XSTEP: 1\n# YSTEP: 0.866\n"
         "# NCOLS_ODD: 3\n# NCOLS_EVEN: 2\n# NROWS: 2\n1 1 1 0 0 9 0.9 1\n1 1 1 1 0 9 0.9 1\n"
         "2 1 0 2 0 9 0.9 1\n12.5664 12.5664 12.5664 0.5 0.866 1 -1 0\n1 1 1 1.5 0.866 9 0.9 1\n");
  w.text("LoadEBSD.ctf", "a.ctf",
         "Channel Text File\nJobMode\tGrid\nXCells\t2\nYCells\t2\nXStep\t1\nYStep\t0,5\nPhases\t1\n"
         "1;1;1\t90;90;90\tIron\t11\t229\nPhase\tX\tY\tEuler1\tEuler2\tEuler3\tMAD\tBC\n"
         "1\t0\t0\t1\t2\t3\t0,5\t9\n1\t1\t0\t1\t2\t3\t0.5\t9\n0\t0\t0,5\t0\t0\t0\t0\t0\n"
         "1\t1\t0,5\t90\t2\t3\t1\t9\n");
  w.text("LoadEBSD.ang", "a.ang",
         "# MaterialName a\n# Symmetry 43\n# GRID: SqrGrid#\n# NOTES: Start\n# a\n# NOTES: End\n"
         "# COLUMN_HEADERS: x, y, Phase index, CI, IQ, phi1, PHI, phi2\n"
         "# COLUMN_UNITS: nm, nm, , , , degrees, degrees, degrees\n"
         "5 7 1 1 9 1 1 1\n5 8 1 1 9 2 1 1\n6 8 1 1 9 2 1 1\n");
  w.text("LoadParticles.json", "a.json",
         "{\"box\":[1,2,3],\"shape\":[0,1],\"class\":[0,0],\"position\":[[0.5,0.5,0.5],[1,2,3]],"
         "\"orientation\":[[1,0,0,0],[0,0.6,0,0.8]],\"scale\":[1,1e-3],\"size\":[1,2],"
         "\"color\":[[0,0,0],[1,1,1]],\"binder_color\":[0,1,0],\"voids\":[1],\"x\":{\"y\":[null]}}\n");
  w.text("LoadShapes.json", "a.json", content("nodes/shapes/load_shapes/stones.json"));
  w.text(
      "LoadShapes.json", "a.json",
      "{\"shapes\":[{\"name\":\"a\",\"probability\":1,\"class\":2,\"volume\":1,\"surface_area\":1,"
      "\"mean_caliper\":1,\"max_section_area\":1,\"smooth\":true,\"mesh\":{\"vertices\":[[0,0,0],[1,0,0],"
      "[0,1,0],[0,0,1]],\"triangles\":[[0,2,1],[0,1,3],[0,3,2],[1,2,3]],\"color\":[[0,0,0],[1,0,0],[0,1,0],"
      "[0,0,1]],\"uv\":[[0,0,1,0,1,1],[0,0,1,0,1,1],[0,0,1,0,1,1],[0,0,1,0,1,1]]}}]}");
  w.text(
      "LoadKMatrix.json", "a.json",
      "{\"classes\":2,\"averaging\":\"uniform\",\"residual\":0,\"shapes\":[{\"probability\":1,\"class\":-1,"
      "\"mean_caliper\":1,\"max_section_area\":1,\"volume\":1,\"profiles_per_caliper\":1,\"K\":[[0.5,0.25],"
      "[0,0.75]],\"cdf\":[0.1,0.5,1]}]}");
  w.text("LoadDistribution.json", "a.json", content("nodes/sizes/load_distribution/sizes.json"));
  w.text("LoadTable.csv", "a.csv", content("nodes/compare/load_table/sieve.csv"));
  w.text("LoadTable.csv", "a.csv", "a;b\n1,5;\"x\"\"\ny\"\n-2;\n");
  w.text("LoadTable.json", "a.json", "{\"columns\":[\"a\",\"b\"],\"rows\":[[1.5,\"x\"],[null,\"\"]]}");
  w.text(
      "LoadStrokes.json", "a.json",
      "{\"strokes\":[{\"area\":false,\"radius\":2.5,\"points\":[[1,2],[3,4.5]]},{\"area\":true,\"radius\":0,"
      "\"parts\":[[[0,0],[9,0],[9,9]]]}]}");
  const fs::path answers = w.place("StudyAnova.csv", "a.csv");
  std::ofstream(answers) << content("nodes/study/study_anova/answers.csv");
  std::ofstream(answers.parent_path() / "key.csv") << content("nodes/study/study_anova/key.csv");
  w.text("LoadStrokes.svg", "a.svg", content("nodes/cooccurrence/load_strokes/strokes.svg"));
  w.text("LoadStrokes.svg", "a.svg",
         "<svg viewBox='0 0 100 100' width='50mm' height='50mm'><g transform='rotate(30 5 5) scale(2)'>"
         "<path stroke='red' d='M1 2 A3 4 10 0 1 9 9 C1 1 2 2 3 3 q1 1 2 0 t3 3 Z'/>"
         "<circle r='9' cx='4' cy='4'/><polygon points='1,1 9,1 9,9'/></g></svg>");
  w.text("LoadStrokes.yaml", "a.yaml",
         "strokes:\n- {radius: 6, points: [[10, 20], [30, 40]]}\n- &a {area: true, parts: [[[0, 0], [9, 0], "
         "[9, 9]]]}\n- *a\n");
  for (const char* graph : {"nodes/packing/anneal/example.yaml", "nodes/sizes/unfold/example.yaml",
                            "nodes/bodies/render_solid/example.yaml"})
    w.text("graph.yaml", "a.yaml", content(graph));
  std::string json = "{\"asset\":{\"version\":\"2.0\",\"extras\":{\"document\":\"\"}}}";
  while (json.size() % 4) json += ' ';
  const auto word = [](std::size_t v) {
    const auto n = static_cast<std::uint32_t>(v);
    return std::string(reinterpret_cast<const char*>(&n), 4);
  };
  w.text("provenance.glb", "a.glb",
         "glTF" + word(2) + word(20 + json.size()) + word(json.size()) + "JSON" + json);
  w.text("provenance.mtlx", "a.mtlx",
         "<?xml version=\"1.0\"?>\n<!-- provenance e30= -->\n<materialx version=\"1.38\"/>\n");
}

}  // namespace

void write_input_seeds(const fs::path& folder, const fs::path& source) {
  Writer w(folder);
  pictures(w), stored_pictures(w), meshes(w), vdbs(w), voxel_files(w), niftis(w), dicoms(w), arrays(w),
      texts(w, source);
}

std::vector<InputSeed> read_input_seeds(const fs::path& folder) {
  std::map<std::string, InputSeed> sorted;
  for (const auto& file : fs::recursive_directory_iterator(folder)) {
    if (!file.is_regular_file()) continue;
    const fs::path seed = file.path().parent_path();
    auto& s = sorted[seed.string()];
    s.reader = seed.parent_path().filename();
    s.files[file.path().filename()] = read_file(file.path()).value_or("");
  }
  std::vector<InputSeed> seeds;
  for (auto& [place, s] : sorted) seeds.push_back(std::move(s));
  return seeds;
}

}  // namespace terrazzo::torture
