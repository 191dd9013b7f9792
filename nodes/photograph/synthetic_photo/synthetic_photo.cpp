#include "nodes/photograph/synthetic_photo/synthetic_photo.h"

#include <algorithm>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/synthetic_photo/light.h"
#include "nodes/photograph/synthetic_photo/objects.h"
#include "nodes/photograph/synthetic_photo/plane_section.h"
#include "nodes/photograph/synthetic_photo/relief.h"
#include "nodes/photograph/synthetic_photo/visible.h"

namespace terrazzo::synthetic_photo {
namespace {

struct One {
  Picture picture;
  std::vector<std::int32_t> labels;
  std::vector<std::uint8_t> other, unclear;
};

One take_one(const PhotoOptions& options, std::uint64_t number, const Work& work) {
  Random r(options.seed, 0x9407, number);
  Scene scene = options.scene;
  if (scene == Scene::Any) {
    const double which = r.uniform();
    scene = which < 0.5 ? Scene::Bank : which < 0.66 ? Scene::Heap : Scene::Section;
  }
  const bool joined = scene == Scene::Alloy, flat = joined || scene == Scene::Section;
  const bool phases =
      joined || (flat && r.uniform() < 0.35 && options.fill.value_or(0) <= 0.62);  // lobes don't fill more
  const bool gray = r.uniform() < (phases ? 0.75 : flat ? 0.3 : 0.04);
  const PhotoPalette palette(r,
                             phases                    ? Surroundings::Microscope
                             : flat                    ? Surroundings::Workshop
                             : scene == Scene::Outcrop ? Surroundings::Outcrop
                                                       : Surroundings::Outdoors,
                             gray);
  Canvas canvas(2 * options.width, 2 * options.height);
  if (flat)
    make_plane_section(canvas,
                       {options.fill.value_or(r.uniform(joined ? 0.3 : 0.05, phases ? 0.7 : 0.97)),
                        joined   ? SectionKind::Joined
                        : phases ? SectionKind::Grown
                                 : SectionKind::Mixed},
                       palette, r, work);
  else
    make_relief(canvas,
                {scene == Scene::Heap,
                 options.fill.value_or(scene == Scene::Heap ? r.uniform(1, 3) : r.uniform(0.05, 1.1))},
                palette, r, work);
  if (options.objects) add_objects(canvas, gray && flat, r);
  const std::vector<Vec3f> light =
      shade(canvas, random_light(r, flat, scene == Scene::Bank || scene == Scene::Outcrop), work);
  One one;
  one.picture = expose(canvas, light, gray, r);
  Visible visible = visible_particles(canvas, one.picture, flat ? 14 : 40, flat ? 0.025 : 0.045);
  one.labels = std::move(visible.labels);
  one.unclear = std::move(visible.unclear);
  one.other.resize(one.labels.size());
  for (int y = 0; y < options.height; ++y)
    for (int x = 0; x < options.width; ++x)
      one.other[pixel_at(x, y, options.width)] = canvas.other[canvas.at(2 * x, 2 * y)];
  develop(one.picture, gray, r);
  return one;
}

}  // namespace

Photo take_photo(const PhotoOptions& options, const Work& work) {
  std::vector<One> all(options.pictures);
  work.parallel(all.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) all[i] = take_one(options, i, work.quiet());
  });
  Photo photo;
  photo.image = Image(options.width, options.height, options.pictures, options.pixel_size);
  for (Labels* labels : {&photo.labels, &photo.not_material, &photo.unclear}) {
    labels->width = options.width;
    labels->height = options.height;
    labels->sections = options.pictures;
    labels->pixel_size = options.pixel_size;
  }
  photo.image.pixels.clear();
  for (const One& one : all) {
    for (const Vec3f& v : one.picture.pixels) photo.image.pixels.push_back(srgb_to_linear(v));
    const std::int32_t before = photo.labels.count();
    std::int32_t count = 0;
    for (const auto id : one.labels) {
      photo.labels.ids.push_back(id == 0 ? 0 : id + before);
      count = std::max(count, id);
    }
    photo.labels.classes.resize(before + count, 0);
    photo.not_material.ids.insert(photo.not_material.ids.end(), one.other.begin(), one.other.end());
    photo.unclear.ids.insert(photo.unclear.ids.end(), one.unclear.begin(), one.unclear.end());
  }
  for (Labels* mask : {&photo.not_material, &photo.unclear})
    mask->classes.assign(std::count(mask->ids.begin(), mask->ids.end(), 1) > 0 ? 1 : 0, 0);
  return photo;
}

}  // namespace terrazzo::synthetic_photo
