#include "nodes/packing/measure3d/classes.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace terrazzo::measure3d {
namespace {

// The labels in increasing order, at most one more than are measured.
std::set<std::int32_t> labels_in(const std::vector<std::int32_t>& ids, const Work& work) {
  std::set<std::int32_t> found;
  for (std::size_t i = 0; i < ids.size() && found.size() <= kMostClasses; ++i) {
    if (i % (1 << 20) == 0) work.check();
    if (i == 0 || ids[i] != ids[i - 1]) found.insert(std::max(ids[i], -1));
  }
  return found;
}

void add_class(Classes& classes, std::string name, bool faces_only, std::size_t voxels) {
  classes.name.push_back(std::move(name));
  classes.faces_only.push_back(faces_only);
  classes.wanted.push_back(1);
  classes.voxels.push_back(voxels);
}

}  // namespace

std::optional<Classes> classes_of_labels(const Raster& raster, const Work& work) {
  const auto labels = labels_in(raster.ids, work);
  if (labels.size() < 2 || labels.size() > kMostClasses) return {};
  Classes out;
  out.box = raster.box;
  std::map<std::int32_t, std::uint8_t> slot;
  for (const std::int32_t label : labels) {
    slot[label] = out.count();
    add_class(out, label < 0 ? "binder" : fmt::format("{}", label), label < 0, 0);
  }
  out.of.resize(raster.count());
  std::uint8_t k = 0;
  for (std::size_t i = 0; i < out.of.size(); ++i) {
    if (i % (1 << 20) == 0) work.check();
    if (i == 0 || raster.ids[i] != raster.ids[i - 1]) k = slot[std::max(raster.ids[i], -1)];
    out.of[i] = k;
    ++out.voxels[k];
  }
  return out;
}

Classes classes_of_phase(const Raster& raster, Phase phase) {
  constexpr const char* kNames[] = {"particles", "voids", "binder"};  // in the order of Phase
  Classes out;
  out.box = raster.box;
  out.of = raster.in;
  add_class(out, "rest", phase != Phase::Binder, raster.count() - raster.inside);
  add_class(out, kNames[static_cast<int>(phase)], phase == Phase::Binder, raster.inside);
  return out;
}

}  // namespace terrazzo::measure3d
