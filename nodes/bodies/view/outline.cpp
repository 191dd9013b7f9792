#include "nodes/bodies/view/pieces.h"
#include "nodes/data/indices.h"

namespace terrazzo::view {
namespace {

// Walks along the edges of pixels with the piece to its left.
class EdgeWalk {
 public:
  EdgeWalk(const std::vector<std::int32_t>& ids, int width, int height, int x, int row)
      : ids_(ids), width_(width), height_(height), id_(ids[pixel_at(x, row, width)]) {
    at_ = Vec2i(x + 1, height - row);  // along the upper edge of the first pixel, to the left
    step_ = Vec2i(-1, 0);
  }

  Loop loop() {
    Loop middles;
    const Vec2i start = at_;
    const Vec2i first = step_;
    do {
      middles.push_back(at_.cast<double>() + step_.cast<double>() / 2);
      at_ += step_;
      turn();
    } while (at_ != start || step_ != first);
    return middles;
  }

 private:
  using Vec2i = Eigen::Vector2i;

  // A corner where only diagonal pixels are the piece's separates them, as 4-connected pieces are separate.
  void turn() {
    const Vec2i left(-step_.y(), step_.x());
    if (!inside(step_ + left))
      step_ = left;
    else if (inside(step_ - left))
      step_ = -left;
  }

  // The pixel at the corner, in a diagonal direction from it.
  bool inside(const Vec2i& diagonal) const {
    const int x = at_.x() + (diagonal.x() < 0 ? -1 : 0);
    const int y = at_.y() + (diagonal.y() < 0 ? -1 : 0);
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return false;
    return ids_[pixel_at(x, height_ - 1 - y, width_)] == id_;
  }

  const std::vector<std::int32_t>& ids_;
  int width_, height_;
  std::int32_t id_;
  Vec2i at_, step_;
};

}  // namespace

Loop outline_of_pixels(const std::vector<std::int32_t>& ids, int width, int height, int x, int row) {
  const Loop middles = EdgeWalk(ids, width, height, x, row).loop();
  Loop smooth;
  for (std::size_t i = 0; i < middles.size(); ++i) {
    const Vec2& before = middles[(i + middles.size() - 1) % middles.size()];
    const Vec2& after = middles[(i + 1) % middles.size()];
    smooth.push_back((before + 2 * middles[i] + after) / 4);
  }
  return smooth;
}

}  // namespace terrazzo::view
