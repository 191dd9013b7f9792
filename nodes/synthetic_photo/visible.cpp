#include "nodes/synthetic_photo/visible.h"

#include <algorithm>
#include <array>

namespace terrazzo::synthetic_photo {
namespace {

// The particle in most of the four canvas pixels of each picture pixel.
std::vector<std::int32_t> halve(const Canvas& c, int width, int height) {
  std::vector<std::int32_t> out(static_cast<std::size_t>(width) * height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::array<std::int32_t, 4> v{c.id[c.at(2 * x, 2 * y)], c.id[c.at(2 * x + 1, 2 * y)],
                                          c.id[c.at(2 * x, 2 * y + 1)], c.id[c.at(2 * x + 1, 2 * y + 1)]};
      std::int32_t best = v[0];
      long most = 0;
      for (const auto id : v)
        if (const long count = std::count(v.begin(), v.end(), id); count > most) most = count, best = id;
      out[static_cast<std::size_t>(y) * width + x] = best;
    }
  return out;
}

// Spots of mud and pits within a particle belong to it, as a person would draw it.
void fill_holes(std::vector<std::int32_t>& label, int w, int h) {
  constexpr std::size_t kLargest = 60;  // pixels
  std::vector<std::uint8_t> seen(label.size(), 0);
  std::vector<std::size_t> hole;
  for (std::size_t i = 0; i < label.size(); ++i) {
    if (label[i] != 0 || seen[i]) continue;
    std::int32_t around = 0;
    bool closed = true;
    hole.assign(1, i);
    seen[i] = 1;
    for (std::size_t q = 0; q < hole.size(); ++q) {
      const int x = static_cast<int>(hole[q] % w), y = static_cast<int>(hole[q] / w);
      const auto visit = [&](int nx, int ny) {
        if (nx < 0 || ny < 0 || nx >= w || ny >= h) {
          closed = false;
          return;
        }
        const std::size_t p = static_cast<std::size_t>(ny) * w + nx;
        if (label[p] == 0) {
          if (!seen[p]) seen[p] = 1, hole.push_back(p);
        } else if (around == 0) {
          around = label[p];
        } else if (around != label[p]) {
          closed = false;
        }
      };
      visit(x - 1, y), visit(x + 1, y), visit(x, y - 1), visit(x, y + 1);
    }
    if (closed && hole.size() <= kLargest)
      for (const auto p : hole) label[p] = around;
  }
}

}  // namespace

std::vector<std::int32_t> visible_particles(const Canvas& c, const Picture& clear, int smallest,
                                            double contrast) {
  const int w = clear.width, h = clear.height;
  const std::vector<std::int32_t> id = halve(c, w, h);
  // 4-connected pieces of equal id
  std::vector<std::int32_t> piece(id.size(), 0);
  struct Piece {
    std::int32_t id = 0;
    int area = 0, border = 0;
    double difference = 0;
  };
  std::vector<Piece> pieces;
  std::vector<std::size_t> stack;
  for (std::size_t i = 0; i < id.size(); ++i) {
    if (id[i] == 0 || piece[i] != 0) continue;
    pieces.push_back({id[i]});
    piece[i] = static_cast<std::int32_t>(pieces.size());
    stack.push_back(i);
    while (!stack.empty()) {
      const std::size_t p = stack.back();
      stack.pop_back();
      ++pieces.back().area;
      const int x = static_cast<int>(p % w), y = static_cast<int>(p / w);
      const auto visit = [&](int nx, int ny) {
        const std::size_t q = static_cast<std::size_t>(ny) * w + nx;
        if (id[q] == id[p] && piece[q] == 0) piece[q] = piece[p], stack.push_back(q);
      };
      if (x > 0) visit(x - 1, y);
      if (x + 1 < w) visit(x + 1, y);
      if (y > 0) visit(x, y - 1);
      if (y + 1 < h) visit(x, y + 1);
    }
  }
  const auto compare = [&](int x, int y, int dx, int dy) {
    const std::size_t p = static_cast<std::size_t>(y) * w + x,
                      q = static_cast<std::size_t>(y + dy) * w + x + dx;
    if (piece[p] == piece[q]) return;
    // Two pixels on either side, since the border itself is blurred.
    const int ax = std::clamp(x - dx, 0, w - 1), ay = std::clamp(y - dy, 0, h - 1),
              bx = std::clamp(x + 2 * dx, 0, w - 1), by = std::clamp(y + 2 * dy, 0, h - 1);
    const double d = (clear.pixels[static_cast<std::size_t>(ay) * w + ax] -
                      clear.pixels[static_cast<std::size_t>(by) * w + bx])
                         .cwiseAbs()
                         .maxCoeff();
    for (const auto k : {piece[p], piece[q]})
      if (k > 0) pieces[k - 1].difference += d, ++pieces[k - 1].border;
  };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      if (x + 1 < w) compare(x, y, 1, 0);
      if (y + 1 < h) compare(x, y, 0, 1);
    }
  std::vector<std::int32_t> largest(c.particles + 1, 0);
  for (std::size_t k = 0; k < pieces.size(); ++k)
    if (std::int32_t& best = largest[pieces[k].id]; best == 0 || pieces[k].area > pieces[best - 1].area)
      best = static_cast<std::int32_t>(k + 1);
  std::vector<std::int32_t> number(pieces.size() + 1, 0);
  std::int32_t count = 0;
  for (const auto k : largest) {
    if (k == 0) continue;
    const Piece& p = pieces[k - 1];
    if (p.area < smallest || (p.border > 0 && p.difference < contrast * p.border)) continue;
    number[k] = ++count;
  }
  std::vector<std::int32_t> out(id.size());
  for (std::size_t i = 0; i < id.size(); ++i) out[i] = number[piece[i]];
  fill_holes(out, w, h);
  return out;
}

}  // namespace terrazzo::synthetic_photo
