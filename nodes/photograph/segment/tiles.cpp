#include "nodes/photograph/segment/tiles.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/segment/network/sharpness.h"

namespace terrazzo::segment {
namespace {

constexpr int kWhole = 4096, kTile = 2048, kAround = 256;

// Copies a window of a section; pixels that are ignored go along.
Image crop(const Image& image, const IgnoredPixels& ignored, int section, int left, int top, int width,
           int height, IgnoredPixels& of_crop) {
  Image out(width, height, 1, image.pixel_size);
  of_crop.clear();
  bool any = false;
  for (int y = 0; y < height; ++y) {
    const std::size_t from = image.index(left, top + y, section);
    std::copy_n(image.pixels.begin() + from, width, out.pixels.begin() + out.index(0, y, 0));
    if (ignored.empty()) continue;
    of_crop.insert(of_crop.end(), ignored.begin() + from, ignored.begin() + from + width);
    any = any || std::find(of_crop.end() - width, of_crop.end(), 1) != of_crop.end();
  }
  if (!any) of_crop.clear();
  return out;
}

bool all_ignored(const IgnoredPixels& ignored) {
  return !ignored.empty() && std::find(ignored.begin(), ignored.end(), 0) == ignored.end();
}

// Up to four windows, evenly spread over the tiles, as sections of one stack.
Finding look_at_some(const Image& photo, const SegmentOptions& options, const std::vector<Tile>& tiles,
                     const Work& work) {
  const int width = std::min(photo.width, kTile), height = std::min(photo.height, kTile);
  SegmentOptions some = options;
  some.ignored.clear();
  Image stack;
  constexpr std::size_t kSome = 4;
  const std::size_t count = std::min(kSome, tiles.size());
  for (std::size_t k = 0; k < count; ++k) {
    const Tile& t = tiles[(2 * k + 1) * tiles.size() / (2 * count)];
    IgnoredPixels ignored;
    Image window = crop(photo, options.ignored, t.section, std::min(t.left, photo.width - width),
                        std::min(t.top, photo.height - height), width, height, ignored);
    if (all_ignored(ignored)) continue;
    if (ignored.empty() && !options.ignored.empty()) ignored.assign(window.pixels.size(), 0);
    some.ignored.insert(some.ignored.end(), ignored.begin(), ignored.end());
    if (stack.pixels.empty()) {
      stack = std::move(window);
    } else {
      stack.pixels.insert(stack.pixels.end(), window.pixels.begin(), window.pixels.end());
      ++stack.sections;
    }
  }
  if (stack.pixels.empty())
    throw Error("empty-image", "nearly all of the picture is ignored", "ignore less, or cut the picture");
  return find_in_whole(stack, some, nullptr, work);
}

// Puts the particles of tiles into one picture.
class TileJoiner {
 public:
  TileJoiner(const Image& photo, Finding& found) : photo_(photo), found_(found) {
    found.result.labels.ids.assign(photo.pixels.size(), 0);
    found.coverage.assign(photo.pixels.size(), 0.0f);
  }

  void add(const Tile& t, const Finding& part) {
    if (!part.undecided.empty()) found_.undecided.resize(photo_.pixels.size(), 0);
    const std::vector<Body> bodies = add_pixels(t, part);
    const std::vector<std::int32_t> becomes = number(t, part, bodies);
    each_pixel(t, [&](int, int, std::size_t i, std::size_t to) {
      const std::int32_t id = becomes[part.result.labels.ids[i]];
      if (id == 0 || found_.result.labels.ids[to] != 0) return;
      found_.result.labels.ids[to] = id;
      found_.coverage[to] = std::max(0.5f, part.coverage[i]);
    });
    add_report(t, part.result);
    if (part.ignored.empty()) return;
    found_.ignored.resize(photo_.pixels.size(), 0);
    each_pixel(t, [&](int, int, std::size_t i, std::size_t to) {
      if (part.ignored[i]) found_.ignored[to] = 1;
    });
  }

  // Completes the labels. Tiles were added section by section, so their numbers are in order.
  void finish() {
    Labels& labels = found_.result.labels;
    labels.width = photo_.width;
    labels.height = photo_.height;
    labels.sections = photo_.sections;
    labels.pixel_size = photo_.pixel_size;
    labels.classes.assign(cut_.size(), 0);
  }

 private:
  // A particle of one tile.
  struct Body {
    double x = 0, y = 0;
    std::int64_t pixels = 0;
    bool cut = false;                               // by the margin's end, not by the picture's
    std::map<std::int32_t, std::int64_t> occupied;  // pixels by particle of an earlier tile
  };

  // Calls use(x, y, index in the tile, index in the picture) for each pixel that the tile sees.
  template <class Use>
  void each_pixel(const Tile& t, Use&& use) const {
    const int w = t.seen_right - t.seen_left, h = t.seen_bottom - t.seen_top;
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) use(x, y, pixel_at(x, y, w), global(t, x, y));
  }

  // Copies what is not particles from the core of the tile, and sums its particles.
  std::vector<Body> add_pixels(const Tile& t, const Finding& part) {
    const int w = t.seen_right - t.seen_left, h = t.seen_bottom - t.seen_top;
    std::vector<Body> bodies(part.confidence.size());
    each_pixel(t, [&](int x, int y, std::size_t i, std::size_t to) {
      if (x + t.seen_left >= t.left && x + t.seen_left < t.right && y + t.seen_top >= t.top &&
          y + t.seen_top < t.bottom) {
        if (found_.result.labels.ids[to] == 0) found_.coverage[to] = std::min(0.499f, part.coverage[i]);
        if (!part.undecided.empty()) found_.undecided[to] = part.undecided[i];
      }
      const std::int32_t id = part.result.labels.ids[i];
      if (id == 0) return;
      Body& b = bodies[id - 1];
      b.x += x;
      b.y += y;
      ++b.pixels;
      b.cut = b.cut || (x == 0 && t.seen_left > 0) || (y == 0 && t.seen_top > 0) ||
              (x == w - 1 && t.seen_right < photo_.width) || (y == h - 1 && t.seen_bottom < photo_.height);
      if (const std::int32_t there = found_.result.labels.ids[to]; there > 0) ++b.occupied[there];
    });
    return bodies;
  }

  // The number in the picture of each particle of the tile, counted from 1; 0 if it is left out.
  std::vector<std::int32_t> number(const Tile& t, const Finding& part, const std::vector<Body>& bodies) {
    std::vector<std::int32_t> becomes(bodies.size() + 1, 0);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const Body& b = bodies[k];
      if (b.pixels == 0) continue;
      const double x = t.seen_left + b.x / b.pixels, y = t.seen_top + b.y / b.pixels;
      std::int32_t most = 0;
      std::int64_t shared = 0, taken = 0;
      for (const auto& [id, pixels] : b.occupied) {
        taken += pixels;
        if (pixels > shared) {
          shared = pixels;
          most = id;
        }
      }
      if (b.cut && most > 0 && cut_[most - 1] && 2 * shared > taken) {
        becomes[k + 1] = most;  // two parts of one large particle
        continue;
      }
      // Twins of one particle may disagree by a pixel about which core their centroid is in.
      constexpr double kSlack = 4;
      const bool mine =
          x >= t.left - kSlack && x < t.right + kSlack && y >= t.top - kSlack && y < t.bottom + kSlack;
      if (!mine || 2 * taken > b.pixels) continue;
      found_.confidence.push_back(part.confidence[k]);
      cut_.push_back(b.cut);
      becomes[k + 1] = cut_.size();
    }
    return becomes;
  }

  void add_report(const Tile& t, const Segmentation& s) {
    Segmentation& all = found_.result;
    all.min_area = std::max(all.min_area, s.min_area);
    all.specks += s.specks;
    all.speck_pixels += s.speck_pixels;
    all.holes += s.holes;
    for (FoundObject o : s.not_material) {
      o.section = t.section;
      o.left += t.seen_left;
      o.right += t.seen_left;
      o.top += t.seen_top;
      o.bottom += t.seen_top;
      add_object(o);
    }
  }

  std::size_t global(const Tile& t, int x, int y) const {
    return photo_.index(t.seen_left + x, t.seen_top + y, t.section);
  }
  // The parts of one object overlap or touch.
  void add_object(FoundObject o) {
    auto& objects = found_.result.not_material;
    for (std::size_t k = 0; k < objects.size();) {
      const FoundObject& other = objects[k];
      if (other.section == o.section && other.left <= o.right + 1 && o.left <= other.right + 1 &&
          other.top <= o.bottom + 1 && o.top <= other.bottom + 1) {
        o.left = std::min(o.left, other.left);
        o.right = std::max(o.right, other.right);
        o.top = std::min(o.top, other.top);
        o.bottom = std::max(o.bottom, other.bottom);
        o.pixels = std::max(o.pixels, other.pixels);
        objects.erase(objects.begin() + k);
        k = 0;
      } else {
        ++k;
      }
    }
    objects.push_back(o);
  }

  const Image& photo_;
  Finding& found_;
  std::vector<bool> cut_;  // of label k at k − 1
};

}  // namespace

bool needs_tiles(const Image& image) {
  return static_cast<std::int64_t>(image.width) * image.height > static_cast<std::int64_t>(kWhole) * kWhole;
}

std::vector<Tile> tiles_of(int width, int height, int sections) {
  std::vector<Tile> tiles;
  for (int section = 0; section < sections; ++section)
    for (int top = 0; top < height; top += kTile)
      for (int left = 0; left < width; left += kTile) {
        Tile t{section, left, top, std::min(width, left + kTile), std::min(height, top + kTile), 0, 0, 0, 0};
        t.seen_left = std::max(0, t.left - kAround);
        t.seen_top = std::max(0, t.top - kAround);
        t.seen_right = std::min(width, t.right + kAround);
        t.seen_bottom = std::min(height, t.bottom + kAround);
        tiles.push_back(t);
      }
  return tiles;
}

Finding find_in_tiles(const Image& photo, const SegmentOptions& given, const Work& work) {
  SegmentOptions options = given;
  if (options.method == Method::Scribbles ||
      (options.method == Method::Auto && options.scribbles.particles && options.scribbles.binder))
    throw Error("too-large", "scribbles can be used on pictures of at most 4096² pixels",
                "cut or reduce the picture, or use another method");
  std::optional<Network> network;  // read once
  if (!options.network && options.method != Method::Clusters)
    options.network = &network.emplace(built_in_model());
  if (options.method != Method::Clusters && options.network_scale <= 0)
    options.network_scale = network_scale_of(photo);  // one for all tiles
  const std::vector<Tile> tiles = tiles_of(photo.width, photo.height, photo.sections);
  // The first stage takes about as long as four tiles.
  const double share = 4.0 / (4 + tiles.size());
  Finding found;
  std::optional<Ground> ground;
  Settled settled;
  if (options.method == Method::Network) {
    found.result.method = Method::Network;
  } else {
    Finding some = look_at_some(photo, options, tiles, work.part(0, share));
    settled.method = some.result.method;
    if (!some.result.ground.clusters.centers.empty()) settled.ground = &ground.emplace(some.result.ground);
    found.result.method = some.result.method;
    found.result.ground = std::move(some.result.ground);
    found.result.distinct_phases = some.result.distinct_phases;
    found.result.reliability = some.result.reliability;
  }
  found.result.network_scale = options.network_scale;
  found.ignored = options.ignored;
  TileJoiner picture(photo, found);
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    const Tile& t = tiles[k];
    const double from = share + (1 - share) * static_cast<double>(k) / tiles.size(),
                 to = share + (1 - share) * static_cast<double>(k + 1) / tiles.size();
    SegmentOptions part = options;
    const Image seen = crop(photo, options.ignored, t.section, t.seen_left, t.seen_top,
                            t.seen_right - t.seen_left, t.seen_bottom - t.seen_top, part.ignored);
    if (all_ignored(part.ignored)) continue;
    picture.add(t, find_in_whole(seen, part, &settled, work.part(from, to)));
  }
  picture.finish();
  return found;
}

}  // namespace terrazzo::segment
