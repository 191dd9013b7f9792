#include "nodes/media/annealing/media_base.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "nodes/data/indices.h"

namespace terrazzo {
namespace {
using annealing::AnnealOptions;
using media::PhaseMap;

// One field list drives encoding and decoding.
template <class Stream>
void fields(Stream&& each, AnnealOptions& o) {
  for (int a = 0; a < 3; ++a) {
    each(o.size[a]);
    each(o.plane[a]);
  }
  each(o.turned);
  each(o.seed);
}

template <class Stream>
void fields(Stream&& each, PhaseMap& m) {
  each(m.width);
  each(m.height);
  each(m.phases);
  each(m.pixel_size);
}

template <class T>
void read_fields(Reader& r, T& of) {
  fields([&](auto& field) { field = r.pod<std::decay_t<decltype(field)>>(); }, of);
}
template <class T>
void write_fields(Writer& w, T of) {
  fields([&](const auto& field) { w.pod(field); }, of);
}

void encode(const MediaBase& v, Writer& w) {
  w.pod<std::uint64_t>(v.request.maps.size());
  for (const PhaseMap& m : v.request.maps) {
    write_fields(w, m);
    w.array(m.at);
  }
  w.raw_array(v.request.color);
  write_fields(w, v.request.options);
  w.pod(v.coarse.stride);
  for (int a = 0; a < 3; ++a) w.pod(v.coarse.size[a]);
  w.array(v.coarse.phase);
}

bool phases_below(const std::vector<std::uint8_t>& list, int phases, bool unobserved) {
  return std::all_of(list.begin(), list.end(),
                     [&](std::uint8_t p) { return p < phases || (unobserved && p == media::kUnobserved); });
}

bool is_whole(const PhaseMap& m, int phases) {
  return m.width > 0 && m.height > 0 && m.phases == phases && m.pixel_size > 0 &&
         static_cast<double>(m.width) * m.height == static_cast<double>(m.at.size()) &&
         phases_below(m.at, phases, true);
}

// An empty base is whole.
bool is_whole(const MediaBase& v) {
  const auto& [maps, color, options] = v.request;
  if (maps.empty()) return color.empty() && v.coarse.phase.empty();
  const int phases = maps[0].phases;
  if (phases < 2 || phases > media::kMostPhases || count_of(color) < phases) return false;
  if (!std::all_of(maps.begin(), maps.end(), [&](const PhaseMap& m) { return is_whole(m, phases); }))
    return false;
  for (const int p : options.plane)
    if (p < -1 || p >= count_of(maps)) return false;
  const auto& coarse = v.coarse;
  return *std::max_element(options.plane.begin(), options.plane.end()) >= 0 && coarse.stride > 1 &&
         options.size.minCoeff() >= annealing::kLeastEdge &&
         coarse.size == annealing::size_at(options.size, coarse.stride) &&
         coarse.size.cast<double>().prod() == static_cast<double>(coarse.phase.size()) &&
         phases_below(coarse.phase, phases, false);
}

MediaBase decode(Reader& r) {
  MediaBase v;
  for (std::size_t n = r.count(1); n > 0; --n) {
    read_fields(r, v.request.maps.emplace_back());
    v.request.maps.back().at = r.array<std::uint8_t>();
  }
  v.request.color = r.raw_array<Vec3f>();
  read_fields(r, v.request.options);
  v.coarse.stride = r.pod<int>();
  for (int a = 0; a < 3; ++a) v.coarse.size[a] = r.pod<int>();
  v.coarse.phase = r.array<std::uint8_t>();
  if (!is_whole(v)) throw Error("damaged", "the stored base of a solid of phases is invalid");
  return v;
}

nlohmann::json describe(const MediaBase& v) {
  nlohmann::json pictures = nlohmann::json::array();
  for (const PhaseMap& m : v.request.maps)
    pictures.push_back({{"width", m.width}, {"height", m.height}, {"phases", m.phases}});
  const auto list = [](const Vec3i& n) { return nlohmann::json{n.x(), n.y(), n.z()}; };
  return {{"size", list(v.request.options.size)},
          {"pictures", std::move(pictures)},
          {"coarse_size", list(v.coarse.size)}};
}

}  // namespace

template <>
const ValueType& value_type<MediaBase>() {
  static const ValueType type = make_value_type<MediaBase>(
      "MediaBase", "Data that the blocks of a large solid of phases share", encode, decode, describe);
  return type;
}

}  // namespace terrazzo
