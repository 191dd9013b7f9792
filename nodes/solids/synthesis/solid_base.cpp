#include "nodes/solids/synthesis/solid_base.h"

#include <nlohmann/json.hpp>

namespace terrazzo {
namespace {
using namespace solids;

// One field list drives encoding and decoding.
template <class Stream>
void fields(Stream&& each, SolidOptions& s) {
  for (int a = 0; a < 3; ++a) {
    each(s.size[a]);
    each(s.plane[a]);
  }
  each(s.levels);
  each(s.color);
  each(s.exponent);
  each(s.overuse);
  each(s.copying);
  each(s.guide);
  each(s.window);
  each(s.finish);
  each(s.blockwise_iterations);
  each(s.seed);
}

void encode(const NeighborField& f, Writer& w) {
  for (const int n : {f.axis, f.exemplar, f.slices, f.columns, f.rows, f.width, f.height}) w.pod(n);
  w.array(f.at);
  w.array(f.weight);
}

NeighborField decode_family(Reader& r, std::size_t exemplars) {
  NeighborField f;
  for (int* n : {&f.axis, &f.exemplar, &f.slices, &f.columns, &f.rows, &f.width, &f.height})
    *n = r.pod<int>();
  f.at = r.array<std::uint32_t>();
  f.weight = r.array<float>();
  const double patches = static_cast<double>(f.slices) * f.columns * f.rows;
  if (f.axis < 0 || f.axis > 2 || f.exemplar < 0 || f.exemplar >= static_cast<int>(exemplars) ||
      std::min({f.slices, f.columns, f.rows}) < 1 || patches != f.at.size() || f.at.size() != f.weight.size())
    throw Error("damaged", "the stored matches have an invalid shape");
  return f;
}

void encode(const ValueMap& m, Writer& w) {
  w.pod(m.map().low());
  w.pod(m.map().scale());
  w.array(m.map().bins());
}

ValueMap decode_map(Reader& r) {
  const auto low = r.pod<float>(), scale = r.pod<float>();
  auto bins = r.array<Remap::Bin>();
  if (bins.size() != Remap::kBins) throw Error("damaged", "a stored value map has an invalid size");
  return ValueMap(Remap(low, scale, std::move(bins)));
}

// Nested lists; `one` encodes or decodes an element.
template <class T, class One>
void encode_list(const std::vector<T>& list, Writer& w, One&& one) {
  w.pod<std::uint64_t>(list.size());
  for (const T& v : list) one(v);
}
template <class T, class One>
std::vector<T> decode_list(Reader& r, One&& one) {
  std::vector<T> out;
  for (std::size_t n = r.count(1); n > 0; --n) out.push_back(one());
  return out;
}

void encode(const LevelStatistics& s, Writer& w) {
  const auto map = [&](const ValueMap& m) { encode(m, w); };
  const auto maps = [&](const std::vector<ValueMap>& list) { encode_list(list, w, map); };
  encode_list(s.penalty, w, [&](const auto& v) { w.array(v); });
  encode_list(s.values, w, maps);
  encode_list(s.floor, w, [&](const auto& v) { w.array(v); });
  encode_list(s.finish, w, [&](const auto& rounds) {
    encode_list(rounds, w, [&](const FinishMaps& m) { encode_list(m.bands, w, maps), maps(m.values); });
  });
}

LevelStatistics decode_statistics(Reader& r) {
  const auto maps = [&] { return decode_list<ValueMap>(r, [&] { return decode_map(r); }); };
  LevelStatistics s;
  s.penalty = decode_list<std::vector<float>>(r, [&] { return r.array<float>(); });
  s.values = decode_list<std::vector<ValueMap>>(r, maps);
  s.floor = decode_list<std::vector<float>>(r, [&] { return r.array<float>(); });
  s.finish = decode_list<std::vector<FinishMaps>>(r, [&] {
    return decode_list<FinishMaps>(r, [&] {
      FinishMaps m;
      m.bands = decode_list<std::vector<ValueMap>>(r, maps);
      m.values = maps();
      return m;
    });
  });
  return s;
}

void encode(const SolidBase& v, Writer& w) {
  SolidOptions s = v.request.settings;
  fields([&](const auto& field) { w.pod(field); }, s);
  w.array(s.iterations);
  w.pod(v.request.voxel);
  encode_list(v.request.exemplars, w, [&](const SolidExemplar& e) {
    w.pod(e.width);
    w.pod(e.height);
    w.raw_array(e.pixels);
    w.array(e.usable);
    w.raw_array(e.features);
  });
  w.pod(v.base.whole.level);
  encode_list(v.base.whole.families, w, [&](const NeighborField& f) { encode(f, w); });
  encode_list(v.base.statistics, w, [&](const LevelStatistics& l) { encode(l, w); });
}

SolidBase decode(Reader& r) {
  SolidBase v;
  SolidOptions& s = v.request.settings;
  fields([&](auto& field) { field = r.pod<std::decay_t<decltype(field)>>(); }, s);
  if (s.color < SolidColor::Lab || s.color > SolidColor::Rgb)
    throw Error("damaged", "the stored color space is unknown");
  s.method = SolidMethod::Blockwise;
  s.iterations = r.array<int>();
  v.request.voxel = r.pod<double>();
  v.request.exemplars = decode_list<SolidExemplar>(r, [&] {
    SolidExemplar e;
    e.width = r.pod<int>();
    e.height = r.pod<int>();
    e.pixels = r.raw_array<Vec3f>();
    e.usable = r.array<std::uint8_t>();
    e.features = r.raw_array<Vec3f>();
    const double n = static_cast<double>(e.width) * e.height;
    const auto fits = [&](const auto& list, bool needed) {
      return (list.empty() && !needed) || static_cast<double>(list.size()) == n;
    };
    if (e.width < 1 || e.height < 1 || !fits(e.pixels, true) || !fits(e.usable, false) ||
        !fits(e.features, false))
      throw Error("damaged", "a stored exemplar has an invalid size");
    return e;
  });
  v.base.whole.level = r.pod<int>();
  v.base.whole.families =
      decode_list<NeighborField>(r, [&] { return decode_family(r, v.request.exemplars.size()); });
  v.base.statistics = decode_list<LevelStatistics>(r, [&] { return decode_statistics(r); });
  return v;
}

nlohmann::json describe(const SolidBase& v) {
  const SolidOptions& s = v.request.settings;
  nlohmann::json exemplars = nlohmann::json::array();
  for (const auto& e : v.request.exemplars) exemplars.push_back({{"width", e.width}, {"height", e.height}});
  std::size_t matches = 0;
  for (const auto& f : v.base.whole.families) matches += f.count();
  return {{"size", {s.size.x(), s.size.y(), s.size.z()}},
          {"voxel", v.request.voxel},
          {"exemplars", std::move(exemplars)},
          {"levels", v.base.statistics.size()},
          {"whole_level", v.base.whole.level},
          {"matches", matches}};
}

}  // namespace

template <>
const ValueType& value_type<SolidBase>() {
  static const ValueType type = make_value_type<SolidBase>(
      "SolidBase", "Data that the blocks of a large solid texture share", encode, decode, describe);
  return type;
}

}  // namespace terrazzo
