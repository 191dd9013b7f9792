#include "nodes/photograph/marks/text_lines.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nodes/common/geometry/disjoint_sets.h"

namespace terrazzo::segment {
namespace {

struct Letter {
  cv::Rect box;
  double stroke = 0;  // width of the widest stroke, in pixels
};

struct Marks {
  std::vector<Letter> letters;  // from left to right
  std::vector<cv::Rect> bars;
};

// Full rows, and nothing else but at the ends.
bool is_bar(const cv::Mat& labels, int label, const cv::Rect& box) {
  constexpr int kShortest = 25;
  if (box.width < kShortest || box.width < 3 * box.height) return false;
  const int end = std::max(3, box.width / 20);
  std::ptrdiff_t full = 0, other = 0;
  for (int y = box.y; y < box.br().y; ++y) {
    const int* row = labels.ptr<int>(y);
    if (std::count(row + box.x, row + box.br().x, label) >= 0.97 * box.width)
      ++full;
    else
      other += std::count(row + box.x + end, row + box.br().x - end, label);
  }
  return full > 0 && other <= 0.02 * box.width;
}

Marks marks_of(const cv::Mat& ink, int highest) {
  cv::Mat labels, stats, centers, depth;
  const int count = cv::connectedComponentsWithStats(ink, labels, stats, centers, 8);
  cv::distanceTransform(ink, depth, cv::DIST_L2, 3);
  Marks out;
  constexpr int kLowest = 6;
  for (int k = 1; k < count; ++k) {
    const cv::Rect box(stats.at<int>(k, cv::CC_STAT_LEFT), stats.at<int>(k, cv::CC_STAT_TOP),
                       stats.at<int>(k, cv::CC_STAT_WIDTH), stats.at<int>(k, cv::CC_STAT_HEIGHT));
    if (is_bar(labels, k, box)) out.bars.push_back(box);
    // Letters may touch each other.
    if (box.height < kLowest || box.height > highest || box.width > 4 * box.height) continue;
    float deepest = 0;
    for (int y = box.y; y < box.br().y; ++y)
      for (int x = box.x; x < box.br().x; ++x)
        if (labels.at<int>(y, x) == k) deepest = std::max(deepest, depth.at<float>(y, x));
    const double stroke = 2.0 * static_cast<double>(deepest) - 1;
    if (stroke <= 0.36 * box.height) out.letters.push_back({box, stroke});
  }
  std::sort(out.letters.begin(), out.letters.end(), [](const Letter& a, const Letter& b) {
    return std::pair(a.box.x, a.box.y) < std::pair(b.box.x, b.box.y);
  });
  return out;
}

bool are_neighbors(const Letter& a, const Letter& b) {  // a is not to the right of b
  const int higher = std::max(a.box.height, b.box.height), lower = std::min(a.box.height, b.box.height);
  const int gap = b.box.x - a.box.br().x;
  // A space and a letter that reaches below the line, such as µ, may lie between them.
  constexpr double kWidestGap = 1.7;
  return std::abs(a.box.br().y - b.box.br().y) <= std::max(1.0, 0.1 * higher) && lower >= 0.55 * higher &&
         gap >= -0.2 * higher && gap <= kWidestGap * higher &&
         std::abs(a.stroke - b.stroke) <= std::max(2.0, 0.5 * std::max(a.stroke, b.stroke));
}

// Letters that stand on one line side by side, from left to right.
std::vector<std::vector<Letter>> rows_of(const std::vector<Letter>& letters) {
  int widest = 0;
  for (const Letter& l : letters) widest = std::max(widest, l.box.width + 2 * l.box.height);
  DisjointSets rows(letters.size());
  for (std::size_t i = 0; i < letters.size(); ++i)
    for (std::size_t j = i + 1; j < letters.size() && letters[j].box.x - letters[i].box.x <= widest; ++j)
      if (are_neighbors(letters[i], letters[j]))
        rows.join(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j));
  std::vector<std::vector<Letter>> all(letters.size());
  for (std::size_t i = 0; i < letters.size(); ++i)
    all[rows.find(static_cast<std::int32_t>(i))].push_back(letters[i]);
  std::erase_if(all, [](const auto& row) { return row.size() < 2; });
  return all;
}

bool is_text(const std::vector<Letter>& row) {
  if (row.size() < 4) return false;
  const auto [narrow, wide] = std::minmax_element(
      row.begin(), row.end(), [](const Letter& a, const Letter& b) { return a.box.width < b.box.width; });
  if (wide->box.width - narrow->box.width < std::max(2.0, 0.15 * row.front().box.height)) return false;
  return std::any_of(row.begin(), row.end(), [&](const Letter& a) {
    return std::count_if(row.begin(), row.end(), [&](const Letter& b) {
             return std::abs(a.box.height - b.box.height) <= std::max(1.0, 0.06 * a.box.height);
           }) >= 3;
  });
}

// Whether the bar belongs to text with this box: above, below or beside it.
bool belongs(const cv::Rect& bar, const cv::Rect& text) {
  const int h = text.height;
  const int above = std::max(bar.y - text.br().y, text.y - bar.br().y),
            beside = std::max(bar.x - text.br().x, text.x - bar.br().x);
  return (above <= 2 * h && beside <= 0) || (beside <= 2 * h && above <= 0);
}

// Whether a row of letters continues with text of this box, on the same line or the next one.
bool goes_on(const cv::Rect& row, const cv::Rect& text) {
  const int h = std::max(row.height, text.height);
  if (2 * std::min(row.height, text.height) < h) return false;
  const int beside = std::max(row.x - text.br().x, text.x - row.br().x),
            above = std::max(row.y - text.br().y, text.y - row.br().y);
  return (std::abs(row.br().y - text.br().y) <= 0.15 * h && beside <= 4 * h) ||
         (beside <= 0 && above <= 1.5 * h);
}

}  // namespace

std::vector<cv::Rect> find_bars(const cv::Mat& ink) { return marks_of(ink, 0).bars; }

std::vector<cv::Rect> find_text(const cv::Mat& ink, int highest) {
  const Marks marks = marks_of(ink, highest);
  std::vector<cv::Rect> found, others;
  for (const auto& row : rows_of(marks.letters)) {
    cv::Rect text = row.front().box;
    for (const Letter& l : row) text |= l.box;
    cv::Rect all = text;
    for (const cv::Rect& bar : marks.bars)
      if (belongs(bar, text)) all |= bar;
    (all != text || is_text(row) ? found : others).push_back(all);
  }
  for (std::size_t k = 0; k < found.size(); ++k) {
    const auto rest = std::stable_partition(others.begin(), others.end(),
                                            [&](const cv::Rect& row) { return !goes_on(row, found[k]); });
    found.insert(found.end(), rest, others.end());
    others.erase(rest, others.end());
  }
  return found;
}

}  // namespace terrazzo::segment
