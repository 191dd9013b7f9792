#include "nodes/data/volume.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "graph/diagnostic.h"
#include "nodes/data/volume_tree.h"

namespace terrazzo {

namespace {

using openvdb::GridBase;

template <class... Grids, class Op>
bool with_one_of(const std::string& type, Op& op) {
  return ((Grids::gridType() == type ? (op.template operator()<Grids>(), true) : false) || ...);
}
// Calls op.operator()<Grid>() for the grid type of that name; returns false if a volume cannot contain that
// type.
template <class Op>
bool with_grid_type(const std::string& type, Op&& op) {
  return with_one_of<openvdb::FloatGrid, openvdb::Vec3SGrid, openvdb::Int32Grid, openvdb::DoubleGrid,
                     openvdb::BoolGrid, openvdb::Vec3IGrid>(type, op);
}

Error unsupported(const std::string& name, const std::string& type) {
  return Error("unsupported-grid", "grid '" + name + "' has the unsupported type " + type,
               "convert it to float, double, vec3s, vec3i, int32 or bool");
}

// --- metadata, except OpenVDB's own metadata about a file

bool is_file_note(const std::string& name) { return name.starts_with("file_"); }

void encode_metadata(const GridBase& grid, Writer& w) {
  std::uint64_t count = 0;
  for (auto it = grid.beginMeta(); it != grid.endMeta(); ++it) count += !is_file_note(it->first);
  w.pod(count);
  for (auto it = grid.beginMeta(); it != grid.endMeta(); ++it) {  // a std::map, so ordered by name
    if (is_file_note(it->first)) continue;
    std::ostringstream bytes(std::ios::binary);
    it->second->write(bytes);
    w.text(it->first);
    w.text(it->second->typeName());
    w.text(bytes.str());
  }
}

void decode_metadata(GridBase& grid, Reader& r) {
  const std::size_t count = r.count(3 * sizeof(std::uint64_t));
  for (std::size_t i = 0; i < count; ++i) {
    const std::string name = r.text(), type = r.text(), bytes = r.text();
    std::uint32_t size = 0;
    if (bytes.size() >= sizeof size) std::memcpy(&size, bytes.data(), sizeof size);
    if (bytes.size() != sizeof size + size || !openvdb::Metadata::isRegisteredType(type))
      throw Error("damaged", "the stored volume has unreadable metadata");
    auto meta = openvdb::Metadata::createMetadata(type);
    std::istringstream in(bytes, std::ios::binary);
    try {
      meta->read(in);
    } catch (const openvdb::Exception&) {
      throw Error("damaged", "the stored volume has unreadable metadata");
    }
    if (!in || meta->size() != size) throw Error("damaged", "the stored volume has unreadable metadata");
    grid.insertMeta(name, *meta);
  }
}

// --- transforms: only affine ones, as their matrix

// The matrix in OpenVDB's order (row vectors). Reads scales directly, since getAffineMap() changes their last
// bits.
openvdb::math::Mat4d affine(const openvdb::math::Transform& transform) {
  using namespace openvdb::math;
  Vec3d scale, shift(0.0);
  if (const auto* st = dynamic_cast<const ScaleTranslateMap*>(transform.baseMap().get())) {
    scale = st->getScale();
    shift = st->getTranslation();
  } else if (const auto* s = dynamic_cast<const ScaleMap*>(transform.baseMap().get()))
    scale = s->getScale();
  else
    return transform.baseMap()->getAffineMap()->getMat4();
  Mat4d m = Mat4d::identity();
  for (int i = 0; i < 3; ++i) {
    m[i][i] = scale[i];
    m[3][i] = shift[i];
  }
  return m;
}

void encode_transform(const GridBase& grid, Writer& w) {
  if (!grid.transform().isLinear())
    throw Error("unsupported-grid", "grid '" + grid.getName() + "' has a frustum transform",
                "resample it to uniform voxels");
  const auto m = affine(grid.transform());
  for (int i = 0; i < 16; ++i) w.pod<double>(m.asPointer()[i] + 0.0);  // replaces −0 by 0
}

openvdb::math::Transform::Ptr decode_transform(Reader& r) {
  using namespace openvdb::math;
  double m[16];
  for (double& v : m) {
    v = r.pod<double>();
    if (!std::isfinite(v)) throw Error("damaged", "the stored volume has an invalid transform");
  }
  const Mat4d matrix(m);
  if (matrix.det() == 0 || m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
    throw Error("damaged", "the stored volume has an invalid transform");
  // OpenVDB's tools are faster on the specialized maps.
  const Vec3d scale(m[0], m[5], m[10]), shift(m[12], m[13], m[14]);
  const bool diagonal = m[1] == 0 && m[2] == 0 && m[4] == 0 && m[6] == 0 && m[8] == 0 && m[9] == 0;
  const bool even = m[0] == m[5] && m[0] == m[10];
  MapBase::Ptr map;
  try {
    if (!diagonal)
      map = std::make_shared<AffineMap>(matrix);
    else if (even)
      map = std::make_shared<UniformScaleTranslateMap>(scale[0], shift);
    else
      map = std::make_shared<ScaleTranslateMap>(scale, shift);
  } catch (const openvdb::Exception&) {
    throw Error("damaged", "the stored volume has an invalid transform");
  }
  // Use OpenVDB's reader: its constructors decompose a map and change the last bits of the scale.
  std::stringstream stream(std::ios::in | std::ios::out | std::ios::binary);
  openvdb::io::setCurrentVersion(stream);
  openvdb::writeString(stream, map->type());
  map->write(stream);
  auto transform = std::make_shared<Transform>();
  transform->read(stream);
  return transform;
}

// --- volumes

constexpr std::int32_t kFarthest = 1 << 30;  // keeps first + extent within 32 bits

// The period, or zeros, or an extent as negative numbers, which the first voxel follows. So volumes that were
// stored before there were extents stay readable.
void encode_box(const Volume& v, Writer& w) {
  if (!v.has_extent()) {
    for (int i = 0; i < 3; ++i) w.pod<std::int32_t>(v.resolution[i]);
    return;
  }
  for (int i = 0; i < 3; ++i) w.pod<std::int32_t>(-v.extent[i]);
  for (int i = 0; i < 3; ++i) w.pod<std::int32_t>(v.first[i]);
}

void decode_box(Volume& v, Reader& r) {
  Vec3i size;
  for (int i = 0; i < 3; ++i) size[i] = r.pod<std::int32_t>();
  if (size.minCoeff() >= 0) {
    v.resolution = size;
    return;
  }
  for (int i = 0; i < 3; ++i) {
    v.first[i] = r.pod<std::int32_t>();
    if (size[i] >= 0 || size[i] < -kFarthest || v.first[i] < -kFarthest || v.first[i] > kFarthest)
      throw Error("damaged", "the stored volume has an invalid extent");
    v.extent[i] = -size[i];
  }
}

void encode(const Volume& v, Writer& w) {
  encode_box(v, w);
  w.pod<std::uint64_t>(v.grids.size());
  for (const auto& grid : v.grids) {
    w.text(grid->getName());
    w.text(grid->type());
    encode_metadata(*grid, w);
    encode_transform(*grid, w);
    const bool known = with_grid_type(grid->type(), [&]<class Grid>() {
      TreeCodec<typename Grid::TreeType>::encode(static_cast<const Grid&>(*grid).tree(), w);
    });
    if (!known) throw unsupported(grid->getName(), grid->type());
  }
}

Volume decode_volume(Reader& r) {
  initialize_openvdb();
  Volume v;
  decode_box(v, r);
  const std::size_t count = r.count(3 * sizeof(std::uint64_t));
  std::set<std::string> names;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string name = r.text(), type = r.text();
    if (!names.insert(name).second)
      throw Error("damaged", "the stored volume has two grids with the same name");
    GridBase::Ptr grid;
    with_grid_type(type, [&]<class Grid>() { grid = Grid::create(); });
    if (!grid) throw Error("damaged", "the stored volume has a grid of unknown type");
    grid->clearMetadata();
    decode_metadata(*grid, r);
    if (grid->getName() != name)
      throw Error("damaged", "the stored volume has a grid whose name does not match its metadata");
    grid->setTransform(decode_transform(r));
    with_grid_type(type, [&]<class Grid>() {
      static_cast<Grid&>(*grid).setTree(TreeCodec<typename Grid::TreeType>::decode(r));
    });
    v.grids.push_back(grid);
  }
  return v;
}

// --- description

// Smallest and largest active value, per component; null if no voxel is active.
template <class Grid>
nlohmann::json range_of(const Grid& grid) {
  using T = typename Grid::ValueType;
  constexpr int kN = openvdb::VecTraits<T>::Size;
  using Component = typename openvdb::VecTraits<T>::ElementType;
  std::array<Component, kN> lo{}, hi{};
  bool any = false;
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    const T value = *it;
    for (int c = 0; c < kN; ++c) {
      Component x;
      if constexpr (openvdb::VecTraits<T>::IsVec)
        x = value[c];
      else
        x = value;
      if (!any || x < lo[c]) lo[c] = x;
      if (!any || x > hi[c]) hi[c] = x;
    }
    any = true;
  }
  if (!any) return {nullptr, nullptr};
  if constexpr (kN == 1)
    return {lo[0], hi[0]};
  else
    return {lo, hi};
}

nlohmann::json describe(const Volume& v) {
  auto grids = nlohmann::json::array();
  for (const auto& grid : v.grids) {
    nlohmann::json range = {nullptr, nullptr};
    with_grid_type(grid->type(), [&]<class Grid>() { range = range_of(static_cast<const Grid&>(*grid)); });
    const auto box = grid->evalActiveVoxelBoundingBox();
    const auto m = affine(grid->transform());
    const auto size = [&](int i) {
      return std::sqrt(m[i][0] * m[i][0] + m[i][1] * m[i][1] + m[i][2] * m[i][2]);
    };
    nlohmann::json bounds = nullptr;
    if (!box.empty())
      bounds = {{box.min()[0], box.min()[1], box.min()[2]}, {box.max()[0], box.max()[1], box.max()[2]}};
    grids.push_back({{"name", grid->getName()},
                     {"type", grid->valueType()},
                     {"class", GridBase::gridClassToString(grid->getGridClass())},
                     {"active_voxels", grid->activeVoxelCount()},
                     {"min", range[0]},
                     {"max", range[1]},
                     {"voxel_size", {size(0), size(1), size(2)}},
                     {"bounding_box", bounds}});  // first and last active voxel
  }
  nlohmann::json extent = nullptr;
  if (v.has_extent())
    extent = {{"first", {v.first[0], v.first[1], v.first[2]}},
              {"size", {v.extent[0], v.extent[1], v.extent[2]}}};
  return {{"resolution", {v.resolution[0], v.resolution[1], v.resolution[2]}},
          {"extent", extent},
          {"grids", grids}};
}

}  // namespace

template <>
const ValueType& value_type<Volume>() {
  static const ValueType type =
      make_value_type<Volume>("Volume", "Named OpenVDB grids in one box", encode, decode_volume, describe);
  return type;
}

void initialize_openvdb() {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

openvdb::CoordBBox voxels_of(const Volume& volume, const openvdb::GridBase& grid) {
  if (!volume.periodic() && !volume.has_extent()) return grid.evalActiveVoxelBoundingBox();
  const Vec3i first = volume.periodic() ? Vec3i::Zero().eval() : volume.first,
              last = first + (volume.periodic() ? volume.resolution : volume.extent) - Vec3i::Ones();
  return {openvdb::Coord(first.x(), first.y(), first.z()), openvdb::Coord(last.x(), last.y(), last.z())};
}

openvdb::CoordBBox voxels_of(const Volume& volume) {
  openvdb::CoordBBox box;
  for (const auto& grid : volume.grids) box.expand(voxels_of(volume, *grid));
  return box;
}

openvdb::math::Transform::Ptr voxel_transform(double size) {
  initialize_openvdb();
  constexpr double kSmallest = 1.5e-5;  // OpenVDB takes smaller voxels for empty ones
  if (!(size >= kSmallest))
    throw Error(
        "bad-spacing",
        fmt::format("voxels of {:.4g} mm are too small: their edges must be at least {} mm", size, kSmallest),
        "state all lengths in a larger unit, as if 1 µm were 1 mm");
  auto transform = openvdb::math::Transform::createLinearTransform(size);
  transform->postTranslate(openvdb::Vec3d(size / 2));
  return transform;
}

}  // namespace terrazzo
