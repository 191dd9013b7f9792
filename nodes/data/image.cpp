#include "nodes/data/image.h"

#include "nodes/data/indices.h"
#include "nodes/data/json.h"

namespace terrazzo {
namespace {

void encode(const Image& v, Writer& w) {
  w.pod(v.width);
  w.pod(v.height);
  w.pod(v.sections);
  w.pod(v.pixel_size);
  w.raw_array(v.pixels);
  if (!v.georeference) return;  // the bytes are those of former versions
  w.pod(v.georeference->m);
  w.pod(v.georeference->epsg);
}

Image decode_image(Reader& r) {
  Image v;
  v.width = r.pod<int>();
  v.height = r.pod<int>();
  v.sections = r.pod<int>();
  v.pixel_size = r.pod<double>();
  v.pixels = r.raw_array<Vec3f>();
  if (v.pixels.size() != pixels_in(v.width, v.height) * v.sections)
    throw Error("damaged", "the stored image has the wrong number of pixels");
  if (r.left() == 0) return v;
  v.georeference.emplace();
  v.georeference->m = r.pod<std::array<double, 6>>();
  v.georeference->epsg = r.pod<int>();
  return v;
}

nlohmann::json describe(const Image& v) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : v.pixels) mean += p.cast<double>();
  if (!v.pixels.empty()) mean /= static_cast<double>(v.pixels.size());
  nlohmann::json out = {{"width", v.width},
                        {"height", v.height},
                        {"sections", v.sections},
                        {"pixel_size", v.pixel_size},
                        {"mean", json_of(mean)}};
  if (v.georeference) out["georeference"] = {{"affine", v.georeference->m}, {"epsg", v.georeference->epsg}};
  return out;
}

}  // namespace

template <>
const ValueType& value_type<Image>() {
  static const ValueType type = make_value_type<Image>(
      "Image", "One section or a stack of sections of equal scale, scene-linear Rec. 709", encode,
      decode_image, describe);
  return type;
}

}  // namespace terrazzo
