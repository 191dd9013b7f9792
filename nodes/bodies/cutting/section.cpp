#include "nodes/bodies/cutting/section.h"

#include <algorithm>
#include <cmath>

#include "nodes/bodies/cutting/cut.h"
#include "nodes/bodies/cutting/raster.h"
#include "nodes/bodies/cutting/soften.h"
#include "nodes/data/indices.h"
#include "nodes/detail/residual/picture_detail.h"
#include "nodes/detail/residual/residual_field.h"

namespace terrazzo::section {

namespace {

// The profile of a cut, and the visible part of its region. The area is 0 if nothing is visible.
Profile profile_of(const Cut& cut, const Particles& particles, const SectionLayout& layout, Region& visible) {
  Profile p;
  p.section = cut.section;
  p.cls = particles.cls[cut.particle];
  p.color = particles.color[cut.particle];
  visible = cut.region;
  if (!layout.tile) {
    const Extent e = region_extent(cut.region);
    const Vec2 size = e.hi - e.lo;
    p.touches_border = e.lo.minCoeff() < 0 || e.hi.x() > layout.width || e.hi.y() > layout.height;
    if (p.touches_border) {
      p.weight = 0;
      visible = clipped(cut.region, layout.width, layout.height);
      if (visible.empty() || !(region_area(visible) > 0)) return {};
    } else {
      p.weight = layout.window_area() / ((layout.width - size.x()) * (layout.height - size.y()));
    }
  }
  p.area = region_area(visible);
  p.centroid = region_centroid(visible);
  p.contour = visible[0];
  return p;
}

// All periodic copies of the tile's regions that reach into the tile.
std::vector<Region> with_images(const std::vector<Region>& regions, const SectionLayout& layout) {
  std::vector<Region> all;
  for (const Region& r : regions) {
    const Extent e = region_extent(r);
    const int x0 = -round_down(e.hi.x() / layout.width), x1 = -round_down(e.lo.x() / layout.width);
    const int y0 = -round_down(e.hi.y() / layout.height), y1 = -round_down(e.lo.y() / layout.height);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) all.push_back(translated(r, {x * layout.width, y * layout.height}));
  }
  return all;
}

struct Canvas {
  std::vector<Vec3f> color;
  std::vector<float> cover;
  std::vector<std::int32_t>
      owner;                 // particle with the largest share of the pixel, −1 if none; only for detail
  std::vector<float> share;  // of the owner
};

// Adds the detail of particles and binder to encoded colors, in proportion to their share of each pixel.
void add_detail(Vec3f* pixels, const Canvas& canvas, const PixelGrid& grid, const SectionPlane& plane,
                const residual::ResidualField& detail, const Work& work) {
  std::vector<std::int32_t> ids(canvas.owner.size());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = canvas.share[i] >= 0.5f ? canvas.owner[i] + 1 : 0;
  residual::add_to_picture(pixels,
                           {grid.width, grid.height, grid.mm_x, grid.mm_y, grid.wrap, plane.origin,
                            plane.frame.col(0), plane.frame.col(1)},
                           ids, canvas.owner, canvas.cover, detail, work);
}

// Paints one section. Where particles overlap, their colors are averaged.
void paint(Section& out, int section, std::size_t first, const std::vector<Region>& visible,
           const PixelGrid& grid, const Vec3f& binder, const SectionPlane& plane,
           const residual::ResidualField* detail, const residual::Camera& camera,
           const std::function<void(const Image&)>& flat, const Work& work) {
  const std::size_t pixels = pixels_in(grid.width, grid.height);
  Canvas canvas{std::vector<Vec3f>(pixels, Vec3f::Zero()), std::vector<float>(pixels, 0.0f), {}, {}};
  if (detail) {
    canvas.owner.assign(pixels, -1);
    canvas.share.assign(pixels, 0.0f);
  }
  for (std::size_t k = 0; k < visible.size(); ++k) {
    work.check();
    const Profile& p = out.profiles.profiles[first + k];
    cover_pixels(visible[k], grid, [&](int x, int row, double share) {
      const std::size_t at = pixel_at(x, row, grid.width);
      canvas.color[at] += static_cast<float>(share) * p.color;
      canvas.cover[at] += static_cast<float>(share);
      if (detail && share > canvas.share[at]) {
        canvas.share[at] = share;
        canvas.owner[at] = static_cast<std::int32_t>(std::get<double>(out.table.rows[first + k][1]));
      }
    });
    fill_pixels(visible[k], grid,
                [&](int x, int row) { out.labels.ids[out.labels.index(x, row, section)] = first + k + 1; });
  }
  for (std::size_t at = 0; at < pixels; ++at) {
    if (at % (1u << 20) == 0) work.check();
    const float c = canvas.cover[at];
    out.image.pixels[section * pixels + at] =
        c > 1 ? Vec3f(canvas.color[at] / c) : Vec3f(canvas.color[at] + (1 - c) * binder);
  }
  if (!detail) return;
  if (flat && out.image.sections == 1) flat(out.image);
  soften(&out.image.pixels[section * pixels], canvas.cover.data(), grid, camera.softness / grid.mm_x);
  add_detail(&out.image.pixels[section * pixels], canvas, grid, plane, *detail, work);
  residual::add_noise(&out.image.pixels[section * pixels], grid.width, grid.height, grid.mm_x, grid.wrap,
                      camera, section, work);
}

}  // namespace

Section cut_section(const Particles& particles, const Shapes& shapes, const SectionLayout& layout,
                    const Work& work, const residual::ResidualField* detail, const residual::Camera& camera,
                    const std::function<void(const Image&)>& flat) {
  check_particles(particles, shapes);
  const std::vector<Cut> cuts = cut_particles(particles, shapes, layout, work.part(0, 0.5));
  const int sections = layout.planes.size();

  Section out;
  out.image = Image(layout.pixels_x, layout.pixels_y, sections, layout.pixel_size);
  out.labels.width = layout.pixels_x;
  out.labels.height = layout.pixels_y;
  out.labels.sections = sections;
  out.labels.pixel_size = layout.pixel_size;
  out.labels.ids.assign(out.image.pixels.size(), 0);
  Profiles& profiles = out.profiles;
  profiles.sections = sections;
  profiles.window = {layout.width, layout.height};
  profiles.observed_area = layout.window_area() * sections;
  profiles.binder_color = particles.binder_color;
  out.table.columns = {"section", "particle", "class", "area mm²", "perimeter mm", "holes", "weight"};

  std::vector<std::vector<Region>> visible(sections);
  std::vector<std::size_t> first(sections + 1, 0);
  double sum = 0;
  for (const Cut& cut : cuts) {
    Region region;
    Profile p = profile_of(cut, particles, layout, region);
    if (!(p.area > 0)) continue;
    ++first[cut.section + 1];
    sum += p.area;
    profiles.classes = std::max(profiles.classes, p.cls + 1);
    out.labels.classes.push_back(p.cls);
    out.table.rows.push_back({double(cut.section), double(cut.particle), double(p.cls), p.area,
                              region_perimeter(region), double(region.size() - 1), p.weight});
    profiles.profiles.push_back(std::move(p));
    visible[cut.section].push_back(std::move(region));
  }
  for (int s = 0; s < sections; ++s) first[s + 1] += first[s];

  const PixelGrid grid{layout.pixels_x, layout.pixels_y, layout.width / layout.pixels_x,
                       layout.height / layout.pixels_y, layout.tile};
  std::vector<double> covered(sections, 0.0);
  work.part(0.5, 1).parallel(sections, 1, [&](std::size_t s, std::size_t) {
    paint(out, s, first[s], visible[s], grid, particles.binder_color, layout.planes[s], detail, camera, flat,
          work);
    covered[s] =
        union_area(layout.tile ? with_images(visible[s], layout) : visible[s], layout.width, layout.height);
  });
  double united = 0;
  for (double c : covered) united += c;
  profiles.area_fraction = united / profiles.observed_area;
  // The tolerance keeps rounding errors from being reported as overlap.
  out.overlap = sum > united * (1 + 1e-7) ? (sum - united) / profiles.observed_area : 0;
  return out;
}

}  // namespace terrazzo::section
