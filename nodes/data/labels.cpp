#include "nodes/data/labels.h"

#include <nlohmann/json.hpp>

#include "nodes/data/indices.h"

namespace terrazzo {
namespace {

void encode(const Labels& v, Writer& w) {
  w.pod(v.width);
  w.pod(v.height);
  w.pod(v.sections);
  w.pod(v.pixel_size);
  w.array(v.ids);
  w.array(v.classes);
}

Labels decode_labels(Reader& r) {
  Labels v;
  v.width = r.pod<int>();
  v.height = r.pod<int>();
  v.sections = r.pod<int>();
  v.pixel_size = r.pod<double>();
  v.ids = r.array<std::int32_t>();
  v.classes = r.array<std::int32_t>();
  if (v.ids.size() != pixels_in(v.width, v.height) * v.sections)
    throw Error("damaged", "the stored labels have the wrong number of pixels");
  return v;
}

nlohmann::json describe(const Labels& v) {
  std::size_t inside = 0;
  for (const auto id : v.ids) inside += id > 0;
  return {{"width", v.width},
          {"height", v.height},
          {"sections", v.sections},
          {"pixel_size", v.pixel_size},
          {"profiles", v.count()},
          {"area_fraction", v.ids.empty() ? 0.0 : static_cast<double>(inside) / v.ids.size()}};
}

}  // namespace

template <>
const ValueType& value_type<Labels>() {
  static const ValueType type = make_value_type<Labels>(
      "Labels", "Profile number of each pixel, 0 for the binder", encode, decode_labels, describe);
  return type;
}

}  // namespace terrazzo
