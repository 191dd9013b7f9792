#include "nodes/data/kmatrix.h"

#include <nlohmann/json.hpp>

#include "nodes/data/class_codec.h"

namespace terrazzo {
namespace {

void encode(const KMatrix& v, Writer& w) {
  w.pod(v.classes);
  w.text(v.averaging);
  w.pod(v.residual);
  w.pod<std::uint64_t>(v.shapes.size());
  for (const auto& e : v.shapes) {
    w.pod(e.probability);
    w.pod(e.mean_caliper);
    w.pod(e.max_section_area);
    w.pod(e.volume);
    w.pod(e.profiles_per_caliper);
    w.bytes(e.K.data(),
            e.K.size() * sizeof(double));  // classes² numbers, column by column
    w.array(e.cdf);
  }
  encode_classes(v.shapes, w, have_trend(v.shapes));
  if (have_trend(v.shapes)) encode_trends(v.shapes, w);
}

KMatrix decode_kmatrix(Reader& r) {
  KMatrix v;
  v.classes = r.pod<int>();
  v.averaging = r.text();
  v.residual = r.pod<double>();
  if (v.classes < 1 || v.classes > 4096) throw Error("damaged", "the stored K matrix has an invalid size");
  v.shapes.resize(r.count(40 + sizeof(double) * v.classes * v.classes));
  for (auto& e : v.shapes) {
    e.probability = r.pod<double>();
    e.mean_caliper = r.pod<double>();
    e.max_section_area = r.pod<double>();
    e.volume = r.pod<double>();
    e.profiles_per_caliper = r.pod<double>();
    e.K.resize(v.classes, v.classes);
    r.bytes(e.K.data(), e.K.size() * sizeof(double));
    e.cdf = r.array<double>();
  }
  decode_classes(v.shapes, r);
  if (r.left() > 0) decode_trends(v.shapes, r);
  return v;
}

nlohmann::json describe(const KMatrix& v) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& e : v.shapes) {
    nlohmann::json rows = nlohmann::json::array();
    for (Eigen::Index i = 0; i < e.K.rows(); ++i) {
      nlohmann::json row = nlohmann::json::array();
      for (Eigen::Index j = 0; j < e.K.cols(); ++j) row.push_back(e.K(i, j));
      rows.push_back(std::move(row));
    }
    list.push_back({{"probability", e.probability},
                    {"class", e.cls},
                    {"mean_caliper", e.mean_caliper},
                    {"max_section_area", e.max_section_area},
                    {"volume", e.volume},
                    {"profiles_per_caliper", e.profiles_per_caliper},
                    {"K", std::move(rows)},
                    {"cdf", e.cdf}});
    if (!e.trend.even()) list.back()["trend"] = {e.trend.power, e.trend.size, e.trend.spread};
  }
  return {{"classes", v.classes},
          {"averaging", v.averaging},
          {"residual", v.residual},
          {"shapes", std::move(list)}};
}

}  // namespace

template <>
const ValueType& value_type<KMatrix>() {
  static const ValueType type = make_value_type<KMatrix>(
      "KMatrix", "Frequency of profiles of each size class from particles of each size class", encode,
      decode_kmatrix, describe);
  return type;
}

}  // namespace terrazzo
