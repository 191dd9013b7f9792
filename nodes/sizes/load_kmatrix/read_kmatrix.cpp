#include "nodes/sizes/load_kmatrix/read_kmatrix.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "nodes/common/io/json_input.h"

namespace terrazzo::load_kmatrix {
namespace {
using Json = nlohmann::json;

constexpr double kTolerance = 1e-6;  // of the end of a distribution

KMatrix::Entry entry_of(const JsonObject& o, int classes) {
  KMatrix::Entry e;
  e.probability = o.number("probability", 0, 1 + kTolerance);
  e.cls = o.whole("class", -1, std::numeric_limits<int>::max());
  e.mean_caliper = o.number("mean_caliper", JsonObject::kSmallest);
  e.max_section_area = o.number("max_section_area", JsonObject::kSmallest);
  e.volume = o.number("volume", JsonObject::kSmallest);
  e.profiles_per_caliper = o.number("profiles_per_caliper", JsonObject::kSmallest);
  if (o.has("trend")) {
    const auto trend = o.vector<Eigen::Vector3d>("trend");
    if (!(trend.y() > 0 && trend.z() >= 0))
      o.fail("the size in the field trend must be above 0, the spread 0 or more");
    e.trend = {trend.x(), trend.y(), trend.z()};
  }
  const std::size_t n = classes;
  const Json& rows = o.field("K");
  o.require_size("K", rows, n);
  for (const Json& row : rows) o.require_size("K", row, n);
  e.K.resize(classes, classes);
  for (int i = 0; i < classes; ++i)
    for (int j = 0; j < classes; ++j) e.K(i, j) = o.number_in("K", rows[i][j], 0, JsonObject::kLargest);
  e.cdf = o.numbers("cdf", 0, 1 + kTolerance);
  if (e.cdf.size() < 2 || !std::is_sorted(e.cdf.begin(), e.cdf.end()) || e.cdf.back() < 1 - kTolerance)
    o.fail("the field cdf must have at least two numbers that ascend to 1");
  return e;
}

}  // namespace

KMatrix read_kmatrix(const std::string& text, const std::string& file) {
  const JsonSource source{file, "use a .json file that Export wrote from a K matrix"};
  const Json json = parse_json(text, "kmatrix", source);
  const JsonObject all(json, source);
  KMatrix out;
  out.classes = all.whole("classes", 1, 4096);
  out.averaging = all.text("averaging");
  if (out.averaging != "uniform" && out.averaging != "upper_edge")
    all.fail("the field averaging is neither uniform nor upper_edge");
  out.residual = all.number("residual", 0);
  for (const Json& j : all.list("shapes"))
    out.shapes.push_back(entry_of(
        JsonObject(j, source, fmt::format("shape {}: ", out.shapes.size()), "bad-kmatrix"), out.classes));
  return out;
}

}  // namespace terrazzo::load_kmatrix
