#include "nodes/data/particles.h"

#include "nodes/data/json.h"

namespace terrazzo {
namespace {

void encode(const Particles& v, Writer& w) {
  w.bytes(v.box.data(), sizeof(double) * 3);
  w.array(v.shape);
  w.array(v.cls);
  w.raw_array(v.position);
  w.raw_array(v.orientation);
  w.array(v.scale);
  w.array(v.size);
  w.raw_array(v.color);
  w.bytes(v.binder_color.data(), sizeof(float) * 3);
  // Packings without voids are equal, whether the list is missing or all zero.
  w.array(v.void_count() > 0 ? v.voids : std::vector<std::uint8_t>());
}

Particles decode_particles(Reader& r) {
  Particles v;
  r.bytes(v.box.data(), sizeof(double) * 3);
  v.shape = r.array<std::int32_t>();
  v.cls = r.array<std::int32_t>();
  v.position = r.raw_array<Vec3>();
  v.orientation = r.raw_array<Quat>();
  v.scale = r.array<double>();
  v.size = r.array<double>();
  v.color = r.raw_array<Vec3f>();
  r.bytes(v.binder_color.data(), sizeof(float) * 3);
  v.voids = r.array<std::uint8_t>();
  const std::size_t n = v.count();
  if (v.shape.size() != n || v.cls.size() != n || v.orientation.size() != n || v.scale.size() != n ||
      v.size.size() != n || v.color.size() != n || (!v.voids.empty() && v.voids.size() != n))
    throw Error("damaged", "the lists of the stored particles differ in length");
  return v;
}

nlohmann::json describe(const Particles& v) {
  nlohmann::json position = nlohmann::json::array();
  nlohmann::json orientation = position;
  nlohmann::json color = position;
  for (std::size_t i = 0; i < v.count(); ++i) {
    position.push_back(json_of(v.position[i]));
    const Quat& q = v.orientation[i];
    orientation.push_back({q.w(), q.x(), q.y(), q.z()});
    color.push_back(json_of(v.color[i]));
  }
  std::vector<std::size_t> voids;
  for (std::size_t i = 0; i < v.count(); ++i)
    if (v.is_void(i)) voids.push_back(i);
  return {{"box", json_of(v.box)},
          {"count", v.count()},
          {"shape", v.shape},
          {"class", v.cls},
          {"position", std::move(position)},
          {"orientation", std::move(orientation)},
          {"scale", v.scale},
          {"size", v.size},
          {"color", std::move(color)},
          {"binder_color", json_of(v.binder_color)},
          {"voids", std::move(voids)}};
}

}  // namespace

template <>
const ValueType& value_type<Particles>() {
  static const ValueType type = make_value_type<Particles>(
      "Particles", "Instances of shapes in a periodic box", encode, decode_particles, describe);
  return type;
}

}  // namespace terrazzo
