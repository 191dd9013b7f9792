#include "nodes/solids/synthesis/whole/measures.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "nodes/common/texture/band_statistics.h"
#include "nodes/common/texture/slice_family.h"
#include "nodes/common/texture/steerable_pyramid.h"
#include "nodes/common/texture/texture_measures.h"
#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/exemplar/finest_bands.h"

namespace terrazzo::solids {
namespace {

using Picture = PatchPicture;

Picture slice_picture(const SolidField& field, int axis, int slice) {
  Picture p;
  const int u = kSliceColumns[axis], v = kSliceRows[axis];
  p.width = field.size[u];
  p.height = field.size[v];
  int at[3];
  at[axis] = slice;
  for (at[v] = 0; at[v] < p.height; ++at[v])
    for (at[u] = 0; at[u] < p.width; ++at[u]) {
      const std::size_t i = voxel_at(at[0], at[1], at[2], field.size);
      Vec3f c = Vec3f::Zero();
      for (std::size_t k = 0; k < field.channel.size(); ++k) c[k] = field.channel[k][i];
      p.pixels.push_back(c);
    }
  return p;
}

Picture part_of(const SolidExemplar& e, int x0, int y0, int x1, int y1) {
  Picture p;
  p.width = x1 - x0;
  p.height = y1 - y0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) p.pixels.push_back(e.pixels[pixel_at(x, y, e.width)]);
  return p;
}

// Sums of squared gradients along columns and rows, and of their product.
Eigen::Array3d gradients(const Picture& p) {
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  for (int y = 0; y + 1 < p.height; ++y)
    for (int x = 0; x + 1 < p.width; ++x) {
      const Vec3f* c = &p.pixels[pixel_at(x, y, p.width)];
      const Vec3f du = ((c[1] - c[0]) + (c[p.width + 1] - c[p.width])) / 2,
                  dv = ((c[p.width] - c[0]) + (c[p.width + 1] - c[1])) / 2;
      sum += Eigen::Array3d(du.squaredNorm(), dv.squaredNorm(), du.dot(dv));
    }
  return sum;
}

// Factor by which gradients are more one-directional than the exemplar's, from squared gradients along
// columns and rows. 1 if they are less so, for example where grain turns and swells.
double more_striped(double columns, double rows, double exemplar_columns, double exemplar_rows) {
  const double slice = std::log(std::max(columns, 1e-12) / std::max(rows, 1e-12)),
               exemplar = std::log(std::max(exemplar_columns, 1e-12) / std::max(exemplar_rows, 1e-12));
  const bool same_way = slice * exemplar > 0;
  return std::exp(std::max(0.0, std::abs(slice) - (same_way ? std::abs(exemplar) : 0)));
}

// Mean |difference| between each slice and the next.
std::vector<double> steps_across(const SolidField& field, int axis, const Work& work) {
  const Vec3i& size = field.size;
  const std::size_t n = size[axis], layers = size.z();
  const std::ptrdiff_t steps[3] = {1, size.x(), static_cast<std::ptrdiff_t>(size.x()) * size.y()};
  // One sum per layer, so that the result does not depend on the number of threads.
  std::vector<double> of_layer(n * layers, 0.0);
  work.parallel(layers, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t z = begin; z < end; ++z) {
      Vec3i at(0, 0, static_cast<int>(z));
      std::ptrdiff_t i = at[2] * steps[2];
      for (at[1] = 0; at[1] < size.y(); ++at[1])
        for (at[0] = 0; at[0] < size.x(); ++at[0], ++i) {
          const std::ptrdiff_t next = i + (at[axis] + 1 < size[axis] ? 1 : 1 - size[axis]) * steps[axis];
          float square = 0;
          for (const auto& c : field.channel) {
            const float d = c[next] - c[i];
            square += d * d;
          }
          of_layer[z * n + at[axis]] += std::sqrt(square);
        }
    }
  });
  std::vector<double> sum(n, 0.0);
  for (std::size_t z = 0; z < layers; ++z)
    for (std::size_t k = 0; k < n; ++k) sum[k] += of_layer[z * n + k] * size[axis] / field.channel[0].size();
  return sum;
}

// Measures every band of slices that tile.
void measure_all_bands(const BandStatistics& wanted, int scales, const SolidField& field, PlaneMeasures& m,
                       SliceFamily::Workspace& space, const Work& work) {
  const int axis = m.axis, channels = field.channel.size();
  const SliceFamily family(field.size, axis, scales);
  std::vector<double> have(static_cast<std::size_t>(scales) + 2, 0), want(have);
  for (int c = 0; c < channels; ++c) {
    const auto ratio = family.deviations(field.channel[c], wanted.bands[c], space, work.quiet());
    for (std::size_t b = 0; b < ratio.size(); ++b) {
      const std::size_t scale = family.bands()[b].scale;
      const double d = wanted.bands[c][b].deviation;
      have[scale] += ratio[b] * ratio[b] * d * d;
      want[scale] += d * d;
    }
  }
  for (std::size_t b = 0; b < have.size(); ++b)
    m.bands.push_back(want[b] > 0 ? std::sqrt(have[b] / want[b]) : 1);
}

// Measures the finest band of slices that need not tile, with a filter that stays within them.
void measure_finest(const SolidExemplar& e, const SolidField& field, PlaneMeasures& m, const Work& work) {
  const int channels = field.channel.size();
  const double want = finest_deviation(e, channels);
  std::vector<double> of_slice(field.size[m.axis]);
  work.parallel(of_slice.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      Picture p = slice_picture(field, m.axis, k);
      SolidExemplar slice;
      slice.width = p.width;
      slice.height = p.height;
      slice.pixels = std::move(p.pixels);
      of_slice[k] = finest_deviation(slice, channels);
    }
  });
  double have = 0;
  for (const double d : of_slice) have += d * d / field.size[m.axis];
  m.bands.push_back(want > 0 ? std::sqrt(have) / want : 1);
}

double histogram_distance(const BandStatistics& wanted, const std::vector<Quantiles>& got) {
  double mean = 0;
  for (std::size_t c = 0; c < got.size(); ++c) {
    double sum = 0;
    for (std::size_t i = 0; i < got[c].at.size(); ++i) sum += std::abs(got[c].at[i] - wanted.values[c].at[i]);
    mean += sum / (got[c].at.size() * got.size());
  }
  return mean;
}

// The larger patch distance between the halves of an exemplar.
double patch_floor(const SolidExemplar& e, const Work& work) {
  const auto distance = [&](int x, int y, int from_x, int from_y) {
    return patch_distance({part_of(e, 0, 0, x, y)}, {part_of(e, from_x, from_y, e.width, e.height)}, 0, work);
  };
  return std::max({0.0, distance(e.width / 2, e.height, e.width / 2, 0),
                   distance(e.width, e.height / 2, 0, e.height / 2)});
}

// Compares the slices with the exemplar by their gradients and their patches.
void measure_patches(const SolidExemplar& e, const SolidField& field, PlaneMeasures& m, const Work& work) {
  const Picture whole = part_of(e, 0, 0, e.width, e.height);
  const Eigen::Array3d g = gradients(whole);
  // Of many slices every other one is enough. Sixteen are compared by their patches.
  const int n = field.size[m.axis], most = std::min(n, 16);
  const auto compared = [&](int k) { return k * most / n != (k + 1) * most / n; };
  std::vector<Picture> slices(n);
  std::vector<double> stripes(slices.size(), 1);
  work.parallel(slices.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const int k = i;
      if (!compared(k) && n > 32 && k % 2) continue;
      Picture p = slice_picture(field, m.axis, k);
      const Eigen::Array3d h = gradients(p);
      stripes[i] = more_striped(h[0], h[1], g[0], g[1]);
      if (compared(k)) slices[i] = std::move(p);
    }
  });
  std::erase_if(slices, [](const Picture& p) { return p.pixels.empty(); });
  m.stripes_worst = *std::max_element(stripes.begin(), stripes.end());
  m.patches = std::max(0.0, patch_distance({whole}, std::move(slices), 0, work));
}

// The step across the seam of a solid that tiles, over the mean step inside.
double seam_of(const SolidField& field, int axis, const Work& work) {
  const auto steps = steps_across(field, axis, work);
  const double inside =
      std::accumulate(steps.begin(), steps.end() - 1, 0.0) / static_cast<double>(steps.size() - 1);
  return inside > 0 ? steps.back() / inside : 1;
}

}  // namespace

void measure_planes(const std::vector<SolidExemplar>& working, const SolidOptions& s, const SolidField& field,
                    std::vector<PlaneMeasures>& out, const Work& work) {
  const bool tiles = s.blocks == Vec3i::Ones();
  SliceFamily::Workspace space;
  std::vector<Quantiles> values(field.channel.size());
  work.quiet().parallel(values.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) values[c] = quantiles_of(field.channel[c]);
  });
  for (PlaneMeasures& m : out) {
    const SolidExemplar& e = working[s.plane[m.axis]];
    Image image(e.width, e.height, 1, 1);
    image.pixels = e.pixels;
    const int scales = pyramid_scales(
        std::min({e.width, e.height, field.size[kSliceColumns[m.axis]], field.size[kSliceRows[m.axis]]}));
    const BandStatistics wanted = measure_bands(image, field.channel.size(), scales, work.quiet());
    if (tiles)
      measure_all_bands(wanted, scales, field, m, space, work);
    else
      measure_finest(e, field, m, work);
    m.histogram = histogram_distance(wanted, values);
  }
  std::vector<double> floors(working.size());
  work.quiet().parallel(floors.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e)
      if (std::find(s.plane.begin(), s.plane.end(), static_cast<int>(e)) != s.plane.end())
        floors[e] = patch_floor(working[e], work.quiet());
  });
  work.quiet().parallel(out.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      PlaneMeasures& m = out[i];
      measure_patches(working[s.plane[m.axis]], field, m, work.quiet());
      m.patches_floor = floors[s.plane[m.axis]];
      if (tiles) m.seam = seam_of(field, m.axis, work.quiet());
    }
  });
}

std::vector<PlaneMeasures> measure_copies(const std::vector<NeighborField>& families, const Work& work) {
  std::vector<PlaneMeasures> out(families.size());
  work.parallel(families.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const NeighborField& f = families[k];
      out[k].axis = f.axis;
      double all = 0;
      const std::size_t plane = pixels_in(f.columns, f.rows);
      for (int s = 0; s < f.slices; ++s) {
        std::size_t same = 0;
        for (int j = 0; j < f.rows; ++j)
          for (int i = 0; i + 1 < f.columns; ++i) {
            const std::uint32_t* at = &f.at[s * plane + pixel_at(i, j, f.columns)];
            same += at[1] == at[0] + 2;
          }
        const double share = static_cast<double>(same) / (static_cast<double>(f.columns - 1) * f.rows);
        out[k].copied_worst = std::max(out[k].copied_worst, share);
        all += share;
      }
      out[k].copied = all / f.slices;
    }
  });
  return out;
}

double directedness(const SolidExemplar& e) {
  const Eigen::Array3d g = gradients(part_of(e, 0, 0, e.width, e.height));
  const double total = g[0] + g[1];
  return total > 0 ? std::sqrt((g[0] - g[1]) * (g[0] - g[1]) + 4 * g[2] * g[2]) / total : 0;
}

double coarseness(const SolidExemplar& e) {
  const auto variance = [](const std::vector<Vec3f>& v) {
    Vec3 mean = Vec3::Zero();
    double square = 0;
    for (const auto& p : v) {
      mean += p.cast<double>();
      square += p.cast<double>().squaredNorm();
    }
    const double n = v.size();
    return square / n - (mean / n).squaredNorm();
  };
  SolidExemplar plain;
  plain.width = e.width;
  plain.height = e.height;
  plain.pixels = e.pixels;
  const double all = variance(e.pixels);
  return all > 0 ? variance(shrink(plain, 8, 8).pixels) / all : 0;
}

}  // namespace terrazzo::solids
