#include "nodes/data/detail.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "nodes/data/indices.h"
#include "nodes/data/json.h"

namespace terrazzo {
namespace {

void encode(const Detail& v, Writer& w) {
  w.pod(v.pixel_size), w.pod(v.size), w.pod(v.softness), w.pod<std::uint8_t>(v.gray);
  w.raw_array(v.profile_color), w.array(v.profile_size), w.array(v.profile_group),
      w.raw_array(v.profile_contrast);
  w.raw_array(v.profile_broad);
  const Detail::Zones& z = v.zones;
  w.array(z.sigma);
  w.array(z.variance);
  w.array(z.level);
  w.array(z.level_by_width);
  w.pod(z.mean_level);
  w.bytes(z.dark.data(), sizeof(float) * 3);
  w.bytes(z.light.data(), sizeof(float) * 3);
  w.pod(z.dark_contrast);
  w.pod(z.light_contrast);
  w.pod<std::uint64_t>(v.phases.size());
  for (const auto& p : v.phases) {
    w.bytes(p.color.data(), sizeof(float) * 3);
    w.pod(p.slope);
    w.bytes(p.tilt.data(), sizeof(float) * 2);
    w.pod<std::uint64_t>(p.rims.size());
    for (const auto& rim : p.rims) {
      w.pod(rim.size);
      w.raw_array(rim.offset);
      w.raw_array(rim.right);
      w.raw_array(rim.up);
    }
    w.array(p.gain);
    w.array(p.grain_gain);
    w.raw_array(p.tile);
    w.raw_array(p.broad);
  }
  w.pod<std::uint64_t>(v.skins.size());
  for (const auto& skin : v.skins) {
    w.pod(skin.profile);
    w.bytes(skin.corner.data(), sizeof(double) * 2);
    w.pod(skin.size), w.pod(skin.width), w.pod(skin.height);
    w.bytes(skin.color.data(), sizeof(float) * 3);
    w.bytes(skin.center.data(), sizeof(float) * 2);
    w.bytes(skin.spread.data(), sizeof(float) * 4);
    w.raw_array(skin.shade);
  }
  w.bytes(v.relief.light.data(), sizeof(float) * 2);
  w.pod(v.relief.strength);
  w.pod(v.ground.width), w.pod(v.ground.height);
  w.raw_array(v.ground.shade);
  w.array(v.tones);
  w.array(v.noise.gray);
  w.array(v.noise.chroma);
  w.array(v.noise.gray_kernel);
  w.array(v.noise.chroma_kernel);
}

Detail::Skin decode_skin(Reader& r) {
  Detail::Skin skin;
  skin.profile = r.pod<std::int32_t>();
  r.bytes(skin.corner.data(), sizeof(double) * 2);
  skin.size = r.pod<float>();
  skin.width = r.pod<int>();
  skin.height = r.pod<int>();
  r.bytes(skin.color.data(), sizeof(float) * 3);
  r.bytes(skin.center.data(), sizeof(float) * 2);
  r.bytes(skin.spread.data(), sizeof(float) * 4);
  skin.shade = r.raw_array<Vec3f>();
  const auto finite_color = [](const Vec3f& v) { return v.allFinite(); };
  if (!skin.center.allFinite() || !skin.color.allFinite() || !skin.corner.allFinite() ||
      !std::all_of(skin.shade.begin(), skin.shade.end(), finite_color))
    throw Error("damaged", "the stored detail has a skin that is not finite");
  if (!(skin.size > 0) || skin.width < 1 || skin.height < 1 ||
      skin.shade.size() != pixels_in(skin.width, skin.height) || !(skin.spread.determinant() > 0))
    throw Error("damaged", "the stored detail has a skin of the wrong size");
  return skin;
}

bool finite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

Detail::Noise decode_noise(Reader& r) {
  Detail::Noise noise;
  noise.gray = r.array<float>();
  noise.chroma = r.array<float>();
  noise.gray_kernel = r.array<float>();
  noise.chroma_kernel = r.array<float>();
  constexpr int kSide = 2 * Detail::Noise::kReach + 1;
  for (const auto& [deviation, kernel] :
       {std::pair(&noise.gray, &noise.gray_kernel), {&noise.chroma, &noise.chroma_kernel}})
    if (kernel->size() != (deviation->empty() ? 0 : pixels_in(kSide, kSide)) || !finite(*deviation) ||
        !finite(*kernel))
      throw Error("damaged", "the stored detail has noise that is no noise");
  return noise;
}

Detail decode_detail(Reader& r) {
  Detail v;
  v.pixel_size = r.pod<double>();
  v.size = r.pod<int>();
  v.softness = r.pod<double>();
  v.gray = r.pod<std::uint8_t>() != 0;
  v.profile_color = r.raw_array<Vec3f>();
  v.profile_size = r.array<float>();
  v.profile_group = r.array<std::int32_t>();
  v.profile_contrast = r.raw_array<Eigen::Vector2f>();
  v.profile_broad = r.raw_array<Eigen::Vector2f>();
  Detail::Zones& z = v.zones;
  z.sigma = r.array<float>();
  z.variance = r.array<float>();
  z.level = r.array<float>();
  z.level_by_width = r.array<float>();
  z.mean_level = r.pod<float>();
  r.bytes(z.dark.data(), sizeof(float) * 3);
  r.bytes(z.light.data(), sizeof(float) * 3);
  z.dark_contrast = r.pod<float>();
  z.light_contrast = r.pod<float>();
  if (z.sigma.size() != z.variance.size() || (!z.level.empty() && z.sigma.empty()) ||
      z.level.empty() != z.level_by_width.empty() ||
      std::any_of(z.sigma.begin(), z.sigma.end(), [](float s) { return !(s > 0); }))
    throw Error("damaged", "the stored detail has zones without a field");
  const std::size_t profiles = v.profile_color.size();
  if (v.profile_contrast.size() != profiles || v.profile_broad.size() != profiles ||
      v.profile_size.size() != profiles || v.profile_group.size() != profiles)
    throw Error("damaged", "the stored detail has lists of different length");
  v.phases.resize(r.count(56));
  for (const std::int32_t group : v.profile_group)
    if (group < 1 || static_cast<std::size_t>(group) >= v.phases.size())
      throw Error("damaged", "the stored detail has a profile of an unknown group");
  const std::size_t n = v.size < 0 ? 0 : v.size;
  for (auto& p : v.phases) {
    r.bytes(p.color.data(), sizeof(float) * 3);
    p.slope = r.pod<float>();
    r.bytes(p.tilt.data(), sizeof(float) * 2);
    p.rims.resize(r.count(28));
    for (auto& rim : p.rims) {
      rim.size = r.pod<float>();
      rim.offset = r.raw_array<Vec3f>();
      rim.right = r.raw_array<Vec3f>();
      rim.up = r.raw_array<Vec3f>();
      if (!(rim.size > 0) || rim.offset.empty()) throw Error("damaged", "the stored detail has an empty rim");
      if (rim.right.size() != rim.up.size() || (!rim.up.empty() && rim.up.size() != rim.offset.size()))
        throw Error("damaged", "the stored detail has a rim with lists of different length");
    }
    p.gain = r.array<float>();
    p.grain_gain = r.array<float>();
    p.tile = r.raw_array<Vec3f>();
    p.broad = r.raw_array<Vec3f>();
    if (v.size < 1 || p.tile.size() != n * n * n || (!p.broad.empty() && p.broad.size() != n * n * n))
      throw Error("damaged", "the stored detail has a tile of the wrong size");
  }
  v.skins.resize(r.count(84));
  for (Detail::Skin& skin : v.skins) skin = decode_skin(r);
  r.bytes(v.relief.light.data(), sizeof(float) * 2);
  v.relief.strength = r.pod<float>();
  if (!v.relief.light.allFinite() || !(v.relief.strength >= 0) || !std::isfinite(v.relief.strength))
    throw Error("damaged", "the stored detail has a relief of skins that is not finite");
  v.ground.width = r.pod<int>();
  v.ground.height = r.pod<int>();
  v.ground.shade = r.raw_array<Vec3f>();
  if (v.ground.width < 0 || v.ground.height < 0 ||
      v.ground.shade.size() != pixels_in(v.ground.width, v.ground.height))
    throw Error("damaged", "the stored detail has a ground of the wrong size");
  v.tones = r.array<float>();
  v.noise = decode_noise(r);
  return v;
}

nlohmann::json describe(const Detail& v) {
  const auto rims = [](const std::vector<Detail::Rim>& all) {
    nlohmann::json list = nlohmann::json::array();
    for (const auto& rim : all) {
      nlohmann::json one = {{"size", rim.size}};
      for (const auto& [name, values] :
           {std::pair("offset", &rim.offset), {"right", &rim.right}, {"up", &rim.up}}) {
        one[name] = nlohmann::json::array();
        for (const Vec3f& o : *values) one[name].push_back(json_of(o));
      }
      list.push_back(std::move(one));
    }
    return list;
  };
  nlohmann::json phases = nlohmann::json::array();
  for (const auto& p : v.phases) {
    double sum = 0;
    for (std::size_t i = 0; i < p.tile.size(); ++i)
      sum += (p.broad.empty() ? p.tile[i] : Vec3f(p.tile[i] + p.broad[i])).squaredNorm();
    phases.push_back({{"color", json_of(p.color)},
                      {"slope", p.slope},
                      {"tilt", {p.tilt.x(), p.tilt.y()}},
                      {"rims", rims(p.rims)},
                      {"gain", p.gain},
                      {"grain_gain", p.grain_gain},
                      {"deviation", p.tile.empty() ? 0 : std::sqrt(sum / (3.0 * p.tile.size()))}});
  }
  return {{"pixel_size", v.pixel_size},
          {"size", v.size},
          {"gray", v.gray},
          {"softness", v.softness},
          {"zones", v.zones.level.empty()
                        ? nlohmann::json()
                        : nlohmann::json{{"dark", json_of(v.zones.dark)},
                                         {"light", json_of(v.zones.light)},
                                         {"sigma", v.zones.sigma},
                                         {"variance", v.zones.variance},
                                         {"level", v.zones.level},
                                         {"level_by_width", v.zones.level_by_width},
                                         {"contrast", {v.zones.dark_contrast, v.zones.light_contrast}}}},
          {"skins", v.skins.size()},
          {"relief", v.relief.strength},
          {"ground", {v.ground.width, v.ground.height}},
          {"tones", v.tones},
          {"noise", {{"gray", v.noise.gray}, {"chroma", v.noise.chroma}}},
          {"phases", std::move(phases)}};
}

}  // namespace

namespace {

// A value of the rims for this size, between those of two sizes by the logarithm.
template <class Of>
Vec3f between_sizes(const std::vector<Detail::Rim>& rims, float size, const Of& of) {
  if (rims.empty()) return Vec3f::Zero();
  if (!(size > 0)) return of(rims[rims.size() / 2]);
  const auto above =
      std::find_if(rims.begin(), rims.end(), [&](const Detail::Rim& r) { return r.size >= size; });
  if (above == rims.begin()) return of(*above);
  if (above == rims.end()) return of(rims.back());
  const auto below = above - 1;
  const float t = std::log(size / below->size) / std::log(above->size / below->size);
  return (1 - t) * of(*below) + t * of(*above);
}

}  // namespace

Vec3f Detail::rim_at(const std::vector<Rim>& rims, float distance, float size) {
  return between_sizes(rims, size, [&](const Rim& r) { return at_distance(r.offset, distance); });
}

Vec3f Detail::light_at(const std::vector<Rim>& rims, float distance, float size,
                       const Eigen::Vector2f& normal) {
  return between_sizes(rims, size, [&](const Rim& r) {
    if (r.up.empty()) return Vec3f(Vec3f::Zero());
    return Vec3f(normal.x() * at_distance(r.right, distance) + normal.y() * at_distance(r.up, distance));
  });
}

template <>
const ValueType& value_type<Detail>() {
  static const ValueType type = make_value_type<Detail>(
      "Detail", "Fine detail of binder and particles, as tileable solids", encode, decode_detail, describe);
  return type;
}

}  // namespace terrazzo
