#include "nodes/data/size_distribution.h"

#include <nlohmann/json.hpp>

namespace terrazzo {
namespace {

void encode(const SizeDistribution& v, Writer& w) {
  w.array(v.class_edges);
  w.pod<std::uint64_t>(v.shapes.size());
  for (const auto& e : v.shapes) {
    w.pod(e.shape);
    w.pod(e.cls);
    w.array(e.N_V);
    w.array(e.low);
    w.array(e.high);
  }
  w.pod(v.volume_fraction);
  w.pod(v.d_max);
  w.pod(v.goodness_of_fit);
}

SizeDistribution decode_size_distribution(Reader& r) {
  SizeDistribution v;
  v.class_edges = r.array<double>();
  v.shapes.resize(r.count(32));
  for (auto& e : v.shapes) {
    e.shape = r.pod<int>();
    e.cls = r.pod<int>();
    e.N_V = r.array<double>();
    e.low = r.array<double>();
    e.high = r.array<double>();
    if (e.N_V.size() != v.classes() || e.low.size() != v.classes() || e.high.size() != v.classes())
      throw Error("damaged", "the stored distribution has the wrong number of classes");
  }
  v.volume_fraction = r.pod<double>();
  v.d_max = r.pod<double>();
  v.goodness_of_fit = r.pod<double>();
  return v;
}

nlohmann::json describe(const SizeDistribution& v) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& e : v.shapes)
    list.push_back({{"shape", e.shape}, {"class", e.cls}, {"N_V", e.N_V}, {"low", e.low}, {"high", e.high}});
  return {{"class_edges", v.class_edges},
          {"shapes", std::move(list)},
          {"volume_fraction", v.volume_fraction},
          {"d_max", v.d_max},
          {"goodness_of_fit", v.goodness_of_fit}};
}

}  // namespace

template <>
const ValueType& value_type<SizeDistribution>() {
  static const ValueType type = make_value_type<SizeDistribution>(
      "SizeDistribution", "Number of particles per volume in each size class", encode,
      decode_size_distribution, describe);
  return type;
}

}  // namespace terrazzo
