// Compares how particles and binder are arranged in sections, by length.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "nodes/common/geometry/rank.h"
#include "nodes/compare/compare/comparison.h"
#include "nodes/data/indices.h"

namespace terrazzo::compare {
namespace {

constexpr int kDistances = 48;  // from 0, equally spaced
constexpr int kLines = 512;
constexpr std::size_t kLeast = 4;  // sections whose differences tell the noise
using Curve = std::vector<double>;

// S2 of the particles, and the probabilities that a segment lies in one particle or in the binder, at the
// distances k · reach / (kDistances − 1).
using Phases = std::array<Curve, 3>;

struct Window {
  const Labels* labels;
  int section, x, y, width, height;  // pixels
};

// Calls line(first id, pixels, stride) for rows and columns, at most about kLines of each.
template <class Line>
void each_line(const Window& w, Line&& line) {
  const Labels& l = *w.labels;
  const auto step = [](int all) { return std::max(1, all / kLines); };
  for (int y = 0; y < w.height; y += step(w.height))
    line(&l.ids[l.index(w.x, w.y + y, w.section)], w.width, 1);
  for (int x = 0; x < w.width; x += step(w.width))
    line(&l.ids[l.index(w.x + x, w.y, w.section)], w.height, l.width);
}

// Mean length of the segments that lines have in common with particles, mm.
double mean_intercept(const Labels& labels) {
  double pixels = 0, runs = 0;
  for (int s = 0; s < labels.sections; ++s)
    each_line({&labels, s, 0, 0, labels.width, labels.height},
              [&](const std::int32_t* p, int length, int stride) {
                std::int32_t before = 0;
                for (int i = 0; i < length; ++i) {
                  const std::int32_t id = p[static_cast<std::ptrdiff_t>(i) * stride];
                  pixels += id > 0;
                  runs += id > 0 && id != before;
                  before = id;
                }
              });
  return runs > 0 ? labels.pixel_size * pixels / runs : 0;
}

// Segments by their length in pixels: with both ends in particles, in one particle, in the binder, with both
// ends observed, and with the last one observed.
struct Counts {
  std::array<std::vector<std::int64_t>, 5> of;
  explicit Counts(std::size_t n) {
    for (auto& v : of) v.assign(n, 0);
  }
  void add(const Counts& c, int times) {
    for (std::size_t q = 0; q < of.size(); ++q)
      for (std::size_t r = 0; r < of[q].size(); ++r) of[q][r] += times * c.of[q][r];
  }
};

// The pixels of a line that have a property, 64 to a word.
class Bits {
 public:
  explicit Bits(int length) : words_(length / 64 + 2, 0) {}
  void clear() { std::ranges::fill(words_, 0); }
  void set(int i) { words_[i / 64] |= std::uint64_t{1} << (i % 64); }
  bool has(int i) const { return words_[i / 64] >> (i % 64) & 1; }
  // How many pixels, and those r pixels further, both have it.
  std::int64_t pairs(int r, int length) const {
    const int word = r / 64, bit = r % 64;
    std::int64_t count = 0;
    for (int k = 0; 64 * k + r < length; ++k) {
      const std::uint64_t low = words_[k + word] >> bit;
      const std::uint64_t high = bit > 0 ? words_[k + word + 1] << (64 - bit) : 0;
      count += std::popcount(words_[k] & (low | high));
    }
    return count;
  }

 private:
  std::vector<std::uint64_t> words_;
};

// Adds the segments within a run of equal ids.
void add_run(std::vector<std::int64_t>& within, int run, int longest) {
  for (int r = 0; r <= std::min(run - 1, longest); ++r) within[r] += run - r;
}

class SegmentCounter {
 public:
  SegmentCounter(const Window& w, int longest)
      : counts_(static_cast<std::size_t>(longest) + 1),
        longest_(longest),
        observed_(std::max(w.width, w.height)),
        particle_(observed_) {}

  void add_line(const std::int32_t* first, int length, int stride) {
    auto& [both, inside, binder, pairs, ends] = counts_.of;
    observed_.clear();
    particle_.clear();
    int seen = 0;  // observed pixels
    for (int i = 0, run = 0; i < length; ++i) {
      const std::int32_t id = first[static_cast<std::ptrdiff_t>(i) * stride];
      ++run;
      if (id >= 0) observed_.set(i);
      if (id > 0) particle_.set(i);
      seen += id >= 0;
      if (i + 1 < length && first[static_cast<std::ptrdiff_t>(i + 1) * stride] == id) continue;
      if (id >= 0) add_run(id > 0 ? inside : binder, run, longest_);
      run = 0;
    }
    const bool all = seen == length;
    for (int r = 0; r <= std::min(length - 1, longest_); ++r) {
      both[r] += particle_.pairs(r, length);
      pairs[r] += all ? length - r : observed_.pairs(r, length);
      ends[r] += seen;  // from pixel r on
      seen -= observed_.has(r);
    }
  }
  Counts take() { return std::move(counts_); }

 private:
  Counts counts_;
  int longest_;
  Bits observed_, particle_;
};

std::vector<Counts> count_segments(const std::vector<Window>& windows, double reach, const Work& work) {
  const int longest = round_up(reach / windows.front().labels->pixel_size) + 1;
  std::vector<Counts> counts(windows.size(), Counts(0));
  work.parallel(windows.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      SegmentCounter counter(windows[k], longest);
      each_line(windows[k], [&](const std::int32_t* first, int length, int stride) {
        counter.add_line(first, length, stride);
      });
      counts[k] = counter.take();
    }
  });
  return counts;
}

Counts sum_of(const std::vector<Counts>& counts) {
  Counts sum = counts.front();
  for (std::size_t k = 1; k < counts.size(); ++k) sum.add(counts[k], 1);
  return sum;
}

Phases curves_of(const Counts& counts, double reach, double pixel) {
  const std::size_t n = counts.of[3].size();
  const auto share = [&](std::size_t q, std::size_t r) {
    const std::int64_t all = counts.of[q == 0 ? 3 : 4][r];
    return all > 0 ? static_cast<double>(counts.of[q][r]) / all : 0;
  };
  Phases out;
  for (std::size_t q = 0; q < out.size(); ++q)
    for (int k = 0; k < kDistances; ++k) {
      const double at = reach * k / (kDistances - 1) / pixel;
      const auto low = std::min<std::size_t>(at, n - 2);
      const double t = at - low;
      out[q].push_back((1 - t) * share(q, low) + t * share(q, low + 1));
    }
  return out;
}

double largest_difference(const Curve& x, const Curve& y) {
  double d = 0;
  for (std::size_t i = 0; i < x.size(); ++i) d = std::max(d, std::abs(x[i] - y[i]));
  return d;
}

std::vector<Window> sections_of(const Labels& labels) {
  std::vector<Window> all;
  for (int s = 0; s < labels.sections; ++s) all.push_back({&labels, s, 0, 0, labels.width, labels.height});
  return all;
}

// Quarters of every section, if there are too few sections.
std::vector<Window> samples_of(const Labels& labels) {
  std::vector<Window> all = sections_of(labels);
  if (all.size() >= kLeast) return all;
  std::vector<Window> quarters;
  const int w = labels.width / 2, h = labels.height / 2;
  for (const Window& s : all)
    for (int k = 0; k < 4; ++k)
      quarters.push_back(
          {&labels, s.section, (k % 2) * (labels.width - w), (k / 2) * (labels.height - h), w, h});
  return quarters;
}

double area_of(const Window& w) {
  const double s = w.labels->pixel_size;
  return s * s * w.width * w.height;
}

// How far the curves of one of the windows of `labels` lie from those of the others, scaled to the difference
// of two sets of the given areas: the 95th percentile.
std::array<double, 3> noise_of(const Labels& labels, double area_a, double area_b, double reach,
                               const Work& work) {
  const std::vector<Window> samples = samples_of(labels);
  const std::vector<Counts> counts = count_segments(samples, reach, work);
  const Counts all = sum_of(counts);
  std::array<std::vector<double>, 3> apart;
  for (const Counts& one : counts) {
    Counts rest = all;
    rest.add(one, -1);
    const Phases x = curves_of(one, reach, labels.pixel_size), y = curves_of(rest, reach, labels.pixel_size);
    for (std::size_t q = 0; q < 3; ++q) apart[q].push_back(largest_difference(x[q], y[q]));
  }
  const double n = samples.size();
  const double area = area_of(samples.front());
  const double scale = std::sqrt((area / area_a + area / area_b) / (1 + 1 / (n - 1)));
  const auto last = static_cast<std::size_t>(std::ceil(0.95 * n)) - 1;
  std::array<double, 3> out{};
  for (std::size_t q = 0; q < 3; ++q) out[q] = scale * at_rank(apart[q], last);
  return out;
}

}  // namespace

void compare_phases(const Labels& a, const Labels& b, const CompareOptions& choice, Comparison& out,
                    const Work& work) {
  if (!choice.two_point && !choice.lineal_path) return;
  double shortest = 1e300, whole_a = 0, whole_b = 0;
  for (const Labels* l : {&a, &b})
    shortest = std::min(shortest, l->pixel_size * std::min(l->width, l->height));
  for (const Window& w : sections_of(a)) whole_a += area_of(w);
  for (const Window& w : sections_of(b)) whole_b += area_of(w);
  const double reach = std::min(shortest / 4, 4 * std::max(mean_intercept(a), mean_intercept(b)));
  if (!(reach > 4 * std::max(a.pixel_size, b.pixel_size))) {
    out.warnings.push_back("two_point and lineal_path are left out: the particles are too small");
    return;
  }
  const auto measure = [&](const Labels& l) {
    return curves_of(sum_of(count_segments(sections_of(l), reach, work.quiet())), reach, l.pixel_size);
  };
  const Phases of_a = measure(a), of_b = measure(b);
  const std::array<double, 3> noise =
      noise_of(b.sections > a.sections ? b : a, whole_a, whole_b, reach, work.quiet());
  const auto add = [&](std::size_t q, const char* measure, const char* item, const char* title) {
    const double difference = largest_difference(of_a[q], of_b[q]);
    out.numbers.push_back(
        {measure, std::string(item) + ", largest difference", "", 0, 0, 0, difference, noise[q]});
    auto& metric = out.metrics[std::string(measure) + "_difference"];
    metric = std::max(metric, difference);
    Plot plot;
    plot.title = title;
    plot.x_label = "distance, mm";
    plot.y_label = "share";
    for (const Curve* c : {&of_a[q], &of_b[q]}) {
      PlotSeries s;
      for (int k = 0; k < kDistances; ++k) {
        s.x.push_back(reach * k / (kDistances - 1));
        s.y.push_back((*c)[k]);
      }
      s.color = c == &of_b[q];
      plot.series.push_back(s);
    }
    out.plots.push_back(plot);
  };
  if (choice.two_point) add(0, "two_point", "particles", "Two-point correlation of particles");
  if (choice.lineal_path) {
    add(1, "lineal_path", "one particle", "Lineal path in one particle");
    add(2, "lineal_path", "binder", "Lineal path in the binder");
  }
}

}  // namespace terrazzo::compare
