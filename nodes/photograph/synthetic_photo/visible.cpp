#include "nodes/photograph/synthetic_photo/visible.h"

#include <algorithm>
#include <array>

#include "nodes/common/geometry/components.h"
#include "nodes/data/indices.h"

namespace terrazzo::synthetic_photo {
namespace {

// The particle in most of the four canvas pixels of each picture pixel.
std::vector<std::int32_t> halve(const Canvas& c, int width, int height) {
  std::vector<std::int32_t> out(pixels_in(width, height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::array<std::int32_t, 4> v{c.id[c.at(2 * x, 2 * y)], c.id[c.at(2 * x + 1, 2 * y)],
                                          c.id[c.at(2 * x, 2 * y + 1)], c.id[c.at(2 * x + 1, 2 * y + 1)]};
      std::int32_t best = v[0];
      long most = 0;
      for (const auto id : v)
        if (const long count = std::count(v.begin(), v.end(), id); count > most) {
          most = count;
          best = id;
        }
      out[pixel_at(x, y, width)] = best;
    }
  return out;
}

// Spots of mud and pits within a particle belong to it, as a person would draw it.
void fill_holes(std::vector<std::int32_t>& label, int w, int h) {
  constexpr std::int64_t kLargest = 60;  // pixels
  constexpr double kShare = 0.3;         // of the particle around it
  std::vector<std::int32_t> empty(label.size());
  std::vector<std::int64_t> areas(*std::max_element(label.begin(), label.end()) + 1, 0);
  for (const auto id : label) ++areas[id];
  for (std::size_t i = 0; i < label.size(); ++i) empty[i] = label[i] == 0;
  const Components holes = connected_components(empty, w, h, false);
  // The one particle around each hole; −1: several, or the picture's border.
  std::vector<std::int32_t> around(holes.count() + 1, 0);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const std::int32_t hole = holes.ids[pixel_at(x, y, w)];
      if (hole == 0) continue;
      const auto meet = [&](int nx, int ny) {
        std::int32_t& one = around[hole];
        if (nx < 0 || ny < 0 || nx >= w || ny >= h) {
          one = -1;
          return;
        }
        const std::int32_t neighbor = label[static_cast<std::size_t>(ny) * w + nx];
        if (neighbor != 0 && one != neighbor) one = one == 0 ? neighbor : -1;
      };
      meet(x - 1, y);
      meet(x + 1, y);
      meet(x, y - 1);
      meet(x, y + 1);
    }
  for (std::size_t i = 0; i < label.size(); ++i)
    if (const auto hole = holes.ids[i]; hole > 0 && around[hole] > 0) {
      const auto size = holes.sizes[hole - 1];
      if (size <= kLargest || size <= kShare * areas[around[hole]]) label[i] = around[hole];
    }
}

// A connected part of a particle.
struct ShownPiece {
  std::int32_t id = 0;
  int area = 0, border = 0;
  double difference = 0;  // sum over the border
};

// Finds the 4-connected pieces of equal id. `piece`: the number of each pixel's, from 1; 0 in the binder.
std::vector<ShownPiece> find_pieces(const std::vector<std::int32_t>& id, int w, int h,
                                    std::vector<std::int32_t>& piece) {
  piece.assign(id.size(), 0);
  std::vector<ShownPiece> pieces;
  std::vector<std::size_t> stack;
  for (std::size_t i = 0; i < id.size(); ++i) {
    if (id[i] == 0 || piece[i] != 0) continue;
    pieces.push_back({id[i]});
    piece[i] = pieces.size();
    stack.push_back(i);
    while (!stack.empty()) {
      const std::size_t p = stack.back();
      stack.pop_back();
      ++pieces.back().area;
      const int x = p % w, y = p / w;
      const auto visit = [&](int nx, int ny) {
        const std::size_t q = static_cast<std::size_t>(ny) * w + nx;
        if (id[q] == id[p] && piece[q] == 0) {
          piece[q] = piece[p];
          stack.push_back(q);
        }
      };
      if (x > 0) visit(x - 1, y);
      if (x + 1 < w) visit(x + 1, y);
      if (y > 0) visit(x, y - 1);
      if (y + 1 < h) visit(x, y + 1);
    }
  }
  return pieces;
}

// Sums differences of color across the borders of pieces.
void compare_borders(const Picture& clear, const std::vector<std::int32_t>& piece,
                     std::vector<ShownPiece>& pieces) {
  const int w = clear.width, h = clear.height;
  const auto compare = [&](int x, int y, int dx, int dy) {
    const std::size_t p = pixel_at(x, y, w), q = pixel_at(x, y + dy, w) + dx;
    if (piece[p] == piece[q]) return;
    // Two pixels on either side, since the border itself is blurred.
    const int ax = std::clamp(x - dx, 0, w - 1), ay = std::clamp(y - dy, 0, h - 1),
              bx = std::clamp(x + 2 * dx, 0, w - 1), by = std::clamp(y + 2 * dy, 0, h - 1);
    const double d = (clear.pixels[static_cast<std::size_t>(ay) * w + ax] -
                      clear.pixels[static_cast<std::size_t>(by) * w + bx])
                         .cwiseAbs()
                         .maxCoeff();
    for (const auto k : {piece[p], piece[q]})
      if (k > 0) {
        pieces[k - 1].difference += d;
        ++pieces[k - 1].border;
      }
  };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      if (x + 1 < w) compare(x, y, 1, 0);
      if (y + 1 < h) compare(x, y, 0, 1);
    }
}

}  // namespace

Visible visible_particles(const Canvas& c, const Picture& clear, int smallest, double contrast) {
  const int w = clear.width, h = clear.height;
  const std::vector<std::int32_t> id = halve(c, w, h);
  std::vector<std::int32_t> piece;
  std::vector<ShownPiece> pieces = find_pieces(id, w, h, piece);
  compare_borders(clear, piece, pieces);
  std::vector<std::int32_t> largest(c.particles + 1, 0);
  for (std::size_t k = 0; k < pieces.size(); ++k)
    if (std::int32_t& best = largest[pieces[k].id]; best == 0 || pieces[k].area > pieces[best - 1].area)
      best = k + 1;
  std::vector<std::int32_t> number(pieces.size() + 1, 0);
  std::int32_t count = 0;
  for (const auto k : largest) {
    if (k == 0) continue;
    const ShownPiece& p = pieces[k - 1];
    if (p.area < smallest || (p.border > 0 && p.difference < contrast * p.border)) continue;
    number[k] = ++count;
  }
  Visible out;
  out.labels.resize(id.size());
  out.unclear.resize(id.size());
  for (std::size_t i = 0; i < id.size(); ++i) out.labels[i] = number[piece[i]];
  fill_holes(out.labels, w, h);
  for (std::size_t i = 0; i < id.size(); ++i) out.unclear[i] = id[i] > 0 && out.labels[i] == 0;
  return out;
}

}  // namespace terrazzo::synthetic_photo
