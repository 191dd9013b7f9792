#include "nodes/export/formats/solvers/dream3d_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/export/formats/solvers/euler_angles.h"
#include "nodes/export/formats/solvers/hdf5_output.h"

namespace terrazzo::exporting {
namespace {

constexpr double kMicrometersPerMm = 1000;
const std::string kContainer = "/DataContainers/ImageDataContainer";
const std::string kCells = kContainer + "/CellData";
const std::string kFeatures = kContainer + "/CellFeatureData";
const std::string kEnsembles = kContainer + "/CellEnsembleData";

// AttributeMatrix::Type of DREAM3D
constexpr std::uint32_t kCellMatrix = 3, kFeatureMatrix = 7, kEnsembleMatrix = 11;
constexpr std::uint32_t kPrimaryPhase = 0, kUnknownPhase = 999;

// Size of an attribute matrix: tuples along each axis, x first.
using Tuples = std::vector<std::uint64_t>;

void add_matrix(Hdf5Output& file, const std::string& path, std::uint32_t type, const Tuples& tuples) {
  file.group(path);
  file.attribute(path, "AttributeMatrixType", Hdf5Type::UInt32, 1, &type);
  file.attribute(path, "TupleDimensions", Hdf5Type::UInt64, tuples.size(), tuples.data());
}

void describe_array(Hdf5Output& file, const std::string& path, const Tuples& tuples, std::uint64_t components,
                    const std::string& object) {
  const std::int32_t version = 2;
  std::string axes;
  for (std::size_t a = 0; a < tuples.size(); ++a)
    axes += (a ? "," : "") + std::string(1, "xyz"[a]) + "=" + std::to_string(tuples[a]);
  file.attribute(path, "ComponentDimensions", Hdf5Type::UInt64, 1, &components);
  file.attribute(path, "DataArrayVersion", Hdf5Type::Int32, 1, &version);
  file.attribute(path, "ObjectType", object);
  file.attribute(path, "Tuple Axis Dimensions", axes);
  file.attribute(path, "TupleDimensions", Hdf5Type::UInt64, tuples.size(), tuples.data());
}

std::string object_of(Hdf5Type type) {
  switch (type) {
    case Hdf5Type::Int32:
      return "DataArray<int32_t>";
    case Hdf5Type::UInt32:
      return "DataArray<uint32_t>";
    case Hdf5Type::UInt8:
      return "DataArray<bool>";
    default:
      return "DataArray<float>";
  }
}

// The array of a feature or ensemble matrix, `components` numbers per row.
template <class T>
void add_column(Hdf5Output& file, const std::string& path, Hdf5Type type, std::uint64_t components,
                const std::vector<T>& values) {
  const Tuples tuples = {values.size() / components};
  file.dataset(path, type, {tuples[0], components}, values.data());
  describe_array(file, path, tuples, components, object_of(type));
}

void check_names(const Dream3dContent& content) {
  std::set<std::string> names;
  if (content.regions) names = {"FeatureIds", "Phases"};
  for (const VoxelSource& grid : content.grids) {
    const std::string& name = grid.name();
    if (name.empty() || name == "." ||
        std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < 32 || c == '/'; }))
      throw Error("bad-names", "a grid has no name, or a slash or control character in its name",
                  "choose other grids with grids")
          .parameter("grids");
    if (!names.insert(name).second)
      throw Error(
          "bad-names", "two arrays of the file would be named '" + name + "'",
          "FeatureIds and Phases are taken by the numbers of particles; leave that grid out with grids")
          .parameter("grids");
  }
}

void add_geometry(Hdf5Output& file, const VoxelBox& box) {
  const std::string path = kContainer + "/_SIMPL_GEOMETRY";
  file.group(path);
  file.attribute(path, "GeometryName", "ImageGeometry");
  file.attribute(path, "GeometryTypeName", "ImageGeometry");
  const std::uint32_t image = 0, three = 3;
  file.attribute(path, "GeometryType", Hdf5Type::UInt32, 1, &image);
  file.attribute(path, "SpatialDimensionality", Hdf5Type::UInt32, 1, &three);
  file.attribute(path, "UnitDimensionality", Hdf5Type::UInt32, 1, &three);
  std::array<std::int64_t, 3> size;
  std::array<float, 3> spacing, origin;
  for (int a = 0; a < 3; ++a) {
    const std::size_t k = a;
    size[k] = box.size[a];
    spacing[k] = box.spacing[a] * kMicrometersPerMm;
    origin[k] = box.corner[a] * kMicrometersPerMm;
    if (!std::isnormal(spacing[k]) || !std::isfinite(origin[k]))
      throw Error("too-large", "the size or position of a voxel is beyond the numbers of the format",
                  "scale the volume");
  }
  file.dataset(path + "/DIMENSIONS", Hdf5Type::Int64, {3}, size.data());
  file.dataset(path + "/ORIGIN", Hdf5Type::Float, {3}, origin.data());
  file.dataset(path + "/SPACING", Hdf5Type::Float, {3}, spacing.data());
  if (box.periodic) file.attribute(path, "Period", Hdf5Type::Int64, 3, size.data());
}

void add_cells(Hdf5Output& file, const Dream3dContent& content, const Work& work) {
  const Vec3i& n = content.box.size;
  const Tuples tuples = {static_cast<std::uint64_t>(n.x()), static_cast<std::uint64_t>(n.y()),
                         static_cast<std::uint64_t>(n.z())};
  add_matrix(file, kCells, kCellMatrix, tuples);
  const std::uint64_t rows = std::max<std::uint64_t>(1, (std::uint64_t{1} << 22) / content.box.plane());
  const double arrays = content.grids.size() + (content.regions ? 2 : 0);
  double done = 0;
  const auto add = [&](const std::string& name, const VoxelSource& grid, auto&& change) {
    const std::uint64_t components = grid.components();
    const Hdf5Type type = grid.whole() ? Hdf5Type::Int32 : Hdf5Type::Float;
    file.dataset(kCells + "/" + name, type, {tuples[2], tuples[1], tuples[0], components}, rows,
                 [&](std::uint64_t z0, std::uint64_t z1, void* out) {
                   work.check();
                   grid.read(z0, z1, out);
                   change(static_cast<std::int32_t*>(out), content.box.plane() * (z1 - z0));
                   work.progress((done + double(z1) / double(tuples[2])) / arrays);
                 });
    describe_array(file, kCells + "/" + name, tuples, components, object_of(type));
    ++done;
  };
  if (content.regions) {
    add("FeatureIds", *content.id, [&](std::int32_t* v, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) v[i] = content.regions->number(v[i]);
    });
    add("Phases", *content.id, [&](std::int32_t* v, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) v[i] = content.regions->phase(v[i]);
    });
  }
  for (const VoxelSource& grid : content.grids) add(grid.name(), grid, [](std::int32_t*, std::size_t) {});
}

void add_features(Hdf5Output& file, const Dream3dContent& content) {
  const auto& all = content.regions->all;
  add_matrix(file, kFeatures, kFeatureMatrix, {all.size()});
  const double voxel = content.box.spacing.prod() * std::pow(kMicrometersPerMm, 3);
  std::vector<std::int32_t> phases, elements, particle;
  std::vector<std::uint8_t> active;
  std::vector<float> volumes, diameters, sizes, colors, quaternions, angles;
  for (const Region& r : all) {
    phases.push_back(r.phase);
    particle.push_back(r.particle);
    elements.push_back(static_cast<std::int32_t>(std::min<std::size_t>(r.voxels, 0x7fffffff)));
    active.push_back(phases.size() > 1);
    const double volume = r.voxels * voxel;
    volumes.push_back(static_cast<float>(volume));
    diameters.push_back(static_cast<float>(std::cbrt(6 * volume / std::numbers::pi)));
    if (!content.particles) continue;
    const bool one = r.particle >= 0;
    const std::size_t p = r.particle;
    const Quat turn = one ? content.particles->orientation[p].normalized() : Quat::Identity();
    // DREAM3D stores the rotation from the sample to the crystal.
    for (const double v : {-turn.x(), -turn.y(), -turn.z(), turn.w()})
      quaternions.push_back(static_cast<float>(v));
    for (const double v : euler_angles(turn)) angles.push_back(static_cast<float>(v));
    sizes.push_back(one ? static_cast<float>(content.particles->size[p] * kMicrometersPerMm) : 0);
    const bool binder = r.is == Region::Is::Binder;
    const Vec3f color = one      ? content.particles->color[p]
                        : binder ? content.particles->binder_color
                                 : Vec3f(0, 0, 0);
    colors.insert(colors.end(), {color[0], color[1], color[2]});
  }
  add_column(file, kFeatures + "/Active", Hdf5Type::UInt8, 1, active);
  add_column(file, kFeatures + "/Phases", Hdf5Type::Int32, 1, phases);
  add_column(file, kFeatures + "/NumElements", Hdf5Type::Int32, 1, elements);
  add_column(file, kFeatures + "/Volumes", Hdf5Type::Float, 1, volumes);
  add_column(file, kFeatures + "/EquivalentDiameters", Hdf5Type::Float, 1, diameters);
  add_column(file, kFeatures + "/Particle", Hdf5Type::Int32, 1, particle);
  if (!content.particles) return;
  add_column(file, kFeatures + "/AvgQuats", Hdf5Type::Float, 4, quaternions);
  add_column(file, kFeatures + "/EulerAngles", Hdf5Type::Float, 3, angles);
  add_column(file, kFeatures + "/Size", Hdf5Type::Float, 1, sizes);
  add_column(file, kFeatures + "/Color", Hdf5Type::Float, 3, colors);
}

void add_ensembles(Hdf5Output& file, const Regions& regions, const SolverMaterials* materials) {
  std::map<std::int32_t, std::string> keys = {{0, "BINDER"}};  // by phase
  for (const Region& r : regions.all) keys[r.phase] = phase_key(r);
  const std::size_t count = keys.rbegin()->first + 1;
  std::vector<std::string> names(count);
  std::vector<std::uint32_t> crystals(count, dream3d_crystal("")), types(count, kPrimaryPhase);
  types[0] = kUnknownPhase;
  for (std::size_t k = 0; k < count; ++k) {
    const auto it = keys.find(k);
    names[k] = it == keys.end() ? fmt::format("PHASE_{}", k - 1) : it->second;
  }
  for (const Region& r : regions.all)
    if (materials && r.voxels > 0) {
      const SolverMaterial& m = materials->of(r);
      names[r.phase] = m.name;
      crystals[r.phase] = dream3d_crystal(m.lattice);
    }
  add_matrix(file, kEnsembles, kEnsembleMatrix, {count});
  add_column(file, kEnsembles + "/CrystalStructures", Hdf5Type::UInt32, 1, crystals);
  add_column(file, kEnsembles + "/PhaseTypes", Hdf5Type::UInt32, 1, types);
  file.texts(kEnsembles + "/PhaseName", names);
  describe_array(file, kEnsembles + "/PhaseName", {count}, 1, "StringDataArray");
}

}  // namespace

void write_dream3d(const std::filesystem::path& path, const Dream3dContent& content, const Work& work) {
  check_names(content);
  Hdf5Output file(path, content.compress);
  file.attribute("/", "FileVersion", "7.0");
  file.attribute("/", "DREAM3D Version", "Terrazzo");
  file.group("/DataContainerBundles");
  file.group("/Pipeline");
  add_geometry(file, content.box);
  add_cells(file, content, work);
  if (content.regions) {
    add_features(file, content);
    add_ensembles(file, *content.regions, content.materials);
  }
  if (!content.provenance.empty()) file.text("/Terrazzo/Provenance", content.provenance);
  file.finish();
}

}  // namespace terrazzo::exporting
