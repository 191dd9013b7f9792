#include "nodes/detail/detail_solid/lines.h"

#include <opencv2/core.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "nodes/common/geometry/rank.h"
#include "runtime/random.h"

namespace terrazzo::detail_solid {
namespace {

constexpr double kLeastOfFilter = 0.5;  // of a filter
constexpr double kBelowLimit = 0.99;    // share of the values without lines that lie below
constexpr float kClear = 2;             // times the largest score of chance
constexpr int kFewestClear = 3;
constexpr double kCrossesRim = 0.7;  // cosine
constexpr int kLinesApart = 3;       // pixels between the middles of neighboring lines
constexpr std::uint64_t kPhaseStream = 0x6c696e65;

// The strongest response of all directions at each pixel.
struct Ridges {
  cv::Mat strength;  // CV_32F; below 0 for dark lines
  cv::Mat angle;     // CV_8U
};

double angle_of(int k, int angles) { return std::numbers::pi * k / angles; }

// An elongated second difference whose values sum to 0, with opposite corners joined.
cv::Mat line_kernel(const LineOptions& o, double angle, const cv::Size& size) {
  const int reach = cvCeil(3 * o.along) + 2;
  const double wide = 3 * o.across, c = std::cos(angle), s = std::sin(angle);
  cv::Mat narrow(2 * reach + 1, 2 * reach + 1, CV_32F), broad(narrow.size(), CV_32F);
  for (int y = -reach; y <= reach; ++y)
    for (int x = -reach; x <= reach; ++x) {
      const double u = (x * c + y * s) / o.along, v = y * c - x * s;
      const auto bell = [&](double width) { return std::exp(-(u * u + v * v / (width * width)) / 2); };
      narrow.at<float>(y + reach, x + reach) = static_cast<float>(bell(o.across));
      broad.at<float>(y + reach, x + reach) = static_cast<float>(bell(wide));
    }
  const cv::Mat kernel = narrow / cv::sum(narrow)[0] - broad / cv::sum(broad)[0];
  cv::Mat out = cv::Mat::zeros(size, CV_32F);
  for (int y = -reach; y <= reach; ++y)
    for (int x = -reach; x <= reach; ++x)
      out.at<float>((y + size.height) % size.height, (x + size.width) % size.width) +=
          kernel.at<float>(y + reach, x + reach);
  return out;
}

cv::Mat spectrum_of_picture(const cv::Mat& picture, const cv::Size& size) {
  cv::Mat out = cv::Mat::zeros(size, CV_32F);
  picture.copyTo(out(cv::Rect(cv::Point(), picture.size())));
  cv::dft(out, out);
  return out;
}

cv::Mat line_filtered(const cv::Mat& spectrum, const cv::Mat& kernel, const cv::Size& shown) {
  cv::Mat out;
  cv::mulSpectrums(spectrum, kernel, out, 0);
  cv::idft(out, out, cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
  return out(cv::Rect(cv::Point(), shown));
}

bool along_rim(const cv::Vec3f& rim, double angle) {
  return rim[2] > 0 && std::abs(rim[0] * std::cos(angle) + rim[1] * std::sin(angle)) < kCrossesRim;
}

// `response`: to the filter of direction k. `variance`: of the response to white noise; less than `least` is
// no response.
void keep_stronger(Ridges& best, const cv::Mat& response, const cv::Mat& variance, float least, int k) {
  for (int y = 0; y < response.rows; ++y)
    for (int x = 0; x < response.cols; ++x) {
      const float of = variance.at<float>(y, x);
      if (of < least) continue;
      const float value = response.at<float>(y, x) / std::sqrt(of);
      if (std::abs(value) > std::abs(best.strength.at<float>(y, x))) {
        best.strength.at<float>(y, x) = value;
        best.angle.at<std::uint8_t>(y, x) = k;
      }
    }
}

// Of each picture, whose known pixels are the same.
std::vector<Ridges> find_ridges(const std::vector<cv::Mat>& pictures, const LinePicture& p,
                                const LineOptions& o, const Work& work) {
  const cv::Size shown = p.value.size();
  const int reach = cvCeil(3 * o.along) + 2;
  const cv::Size size(cv::getOptimalDFTSize(shown.width + reach),
                      cv::getOptimalDFTSize(shown.height + reach));
  std::vector<cv::Mat> spectra;
  for (const cv::Mat& picture : pictures) spectra.push_back(spectrum_of_picture(picture, size));
  const cv::Mat known = spectrum_of_picture(p.known, size);
  constexpr int kParts = 4;
  std::array<std::vector<Ridges>, kParts> parts;
  work.quiet().parallel(kParts, 1, [&](std::size_t part, std::size_t) {
    for (std::size_t n = 0; n < pictures.size(); ++n)
      parts[part].push_back({cv::Mat::zeros(shown, CV_32F), cv::Mat::zeros(shown, CV_8U)});
    for (std::size_t k = part * o.angles / kParts; k < (part + 1) * o.angles / kParts; ++k) {
      work.check();
      const double angle = angle_of(k, o.angles);
      cv::Mat kernel = line_kernel(o, angle, size), squares = kernel.mul(kernel);
      const auto least = static_cast<float>(kLeastOfFilter * cv::sum(squares)[0]);
      cv::dft(kernel, kernel);
      cv::dft(squares, squares);
      const cv::Mat variance = line_filtered(known, squares, shown);
      for (std::size_t n = 0; n < pictures.size(); ++n)
        keep_stronger(parts[part][n], line_filtered(spectra[n], kernel, shown), variance, least, k);
    }
  });
  std::vector<Ridges> out = std::move(parts[0]);
  for (int part = 1; part < kParts; ++part)
    for (std::size_t n = 0; n < out.size(); ++n) {
      const Ridges& other = parts[part][n];
      const cv::Mat stronger = cv::abs(other.strength) > cv::abs(out[n].strength);
      other.strength.copyTo(out[n].strength, stronger);
      other.angle.copyTo(out[n].angle, stronger);
    }
  for (Ridges& r : out)
    for (int y = 0; y < shown.height; ++y)
      for (int x = 0; x < shown.width; ++x)
        if (along_rim(p.rim.at<cv::Vec3f>(y, x), angle_of(r.angle.at<std::uint8_t>(y, x), o.angles)))
          r.strength.at<float>(y, x) = 0;
  return out;
}

// A field of the picture's power spectrum with random phases.
cv::Mat with_random_phases(const LinePicture& p, std::uint64_t seed, const Work& work) {
  const cv::Size shown = p.value.size();
  const cv::Size size(cv::getOptimalDFTSize(shown.width), cv::getOptimalDFTSize(shown.height));
  cv::Mat noise(size, CV_32F), picture = cv::Mat::zeros(size, CV_32F);
  for (int y = 0; y < size.height; ++y) {
    Random random(seed, kPhaseStream, y);
    for (int x = 0; x < size.width; ++x) noise.at<float>(y, x) = static_cast<float>(random.normal());
  }
  p.value.copyTo(picture(cv::Rect(cv::Point(), shown)));
  cv::Mat waves, phases;
  cv::dft(picture, waves, cv::DFT_COMPLEX_OUTPUT);
  cv::dft(noise, phases, cv::DFT_COMPLEX_OUTPUT);
  for (int y = 0; y < size.height; ++y) {
    work.check();
    for (int x = 0; x < size.width; ++x) {
      const cv::Vec2f of = waves.at<cv::Vec2f>(y, x);
      cv::Vec2f& phase = phases.at<cv::Vec2f>(y, x);
      phase *= std::hypot(of[0], of[1]) / std::max(1e-12f, std::hypot(phase[0], phase[1]));
    }
  }
  cv::Mat field;
  cv::idft(phases, field, cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
  return field;
}

// The picture with random phases. Each kind keeps its values.
cv::Mat without_lines(const LinePicture& p, std::uint64_t seed, const Work& work) {
  const cv::Size shown = p.value.size();
  const cv::Mat field = with_random_phases(p, seed, work);
  std::map<int, std::vector<cv::Point>> places;
  for (int y = 0; y < shown.height; ++y)
    for (int x = 0; x < shown.width; ++x)
      if (p.known.at<float>(y, x) > 0) places[p.kind.at<std::uint8_t>(y, x)].emplace_back(x, y);
  cv::Mat out = cv::Mat::zeros(shown, CV_32F);
  for (auto& [kind, at] : places) {
    work.check();
    std::vector<float> values;
    for (const cv::Point& q : at) values.push_back(p.value.at<float>(q));
    std::sort(values.begin(), values.end());
    std::stable_sort(at.begin(), at.end(), [&](const cv::Point& a, const cv::Point& b) {
      return field.at<float>(a) < field.at<float>(b);
    });
    for (std::size_t i = 0; i < at.size(); ++i) out.at<float>(at[i]) = values[i];
  }
  return out;
}

// The value in the middle of whose neighborhood across its line lies none as strong: CV_8U, 1 dark, 2 light.
cv::Mat crests_of(const Ridges& r, float limit, int angles) {
  cv::Mat out = cv::Mat::zeros(r.strength.size(), CV_8U);
  const auto size_at = [&](double x, double y) {
    const int u = cvFloor(x), v = cvFloor(y);
    if (u < 0 || v < 0 || u + 1 >= out.cols || v + 1 >= out.rows) return 1e9;  // no line ends at the edge
    const double a = x - u, b = y - v;
    const auto of = [&](int i, int j) { return std::abs(double{r.strength.at<float>(v + j, u + i)}); };
    return (1 - b) * ((1 - a) * of(0, 0) + a * of(1, 0)) + b * ((1 - a) * of(0, 1) + a * of(1, 1));
  };
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) {
      const float value = r.strength.at<float>(y, x);
      if (!(std::abs(value) > limit)) continue;
      const double angle = angle_of(r.angle.at<std::uint8_t>(y, x), angles);
      bool crest = true;
      for (int d = 1; d <= kLinesApart && crest; ++d)
        for (const int side : {-d, d})
          crest = crest && std::abs(value) >= size_at(x - side * std::sin(angle), y + side * std::cos(angle));
      if (crest) out.at<std::uint8_t>(y, x) = value < 0 ? 1 : 2;
    }
  return out;
}

// Length, straight line and kind from a line's pixels.
void measure_line(Line& line, const LinePicture& p, int angles) {
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  std::array<int, 256> kinds{};
  std::set<std::pair<int, int>> all;
  for (const cv::Point& q : line.pixels) all.emplace(q.x, q.y);
  for (std::size_t i = 0; i < line.pixels.size(); ++i) {
    const cv::Point& q = line.pixels[i];
    const double angle = angle_of(line.angle[i], angles);
    // Where the line is two pixels wide, they count once.
    const bool flat = std::abs(std::cos(angle)) > std::abs(std::sin(angle));
    if (!all.contains(flat ? std::pair(q.x, q.y - 1) : std::pair(q.x - 1, q.y)))
      line.length += static_cast<float>(1 / std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle))));
    x += q.x;
    y += q.y;
    if (p.known.at<float>(q) > 0) ++kinds[p.kind.at<std::uint8_t>(q)];
  }
  const double n = line.pixels.size();
  for (const cv::Point& q : line.pixels) {
    const double u = q.x - x / n, v = q.y - y / n;
    xx += u * u;
    xy += u * v;
    yy += v * v;
  }
  const double turn = std::atan2(2 * xy, xx - yy) / 2, c = std::cos(turn), s = std::sin(turn);
  line.center = {static_cast<float>(x / n), static_cast<float>(y / n)};
  line.direction = {static_cast<float>(c), static_cast<float>(s)};
  line.bend = static_cast<float>(std::sqrt(std::max(0.0, xx * s * s - 2 * xy * s * c + yy * c * c) / n));
  line.kind = static_cast<int>(std::max_element(kinds.begin(), kinds.end()) - kinds.begin());
}

// A line ends where the filter has half the strength that it has along most of the line.
void trim_line(Line& line, const Ridges& r) {
  std::vector<float> strength;
  for (const cv::Point& q : line.pixels) strength.push_back(std::abs(r.strength.at<float>(q)));
  const float least = median(strength) / 2;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < strength.size(); ++i)
    if (strength[i] >= least) {
      line.pixels[kept] = line.pixels[i];
      line.angle[kept++] = line.angle[i];
    }
  line.pixels.resize(kept);
  line.angle.resize(kept);
}

// Straight lines that cross remain two.
bool continues_at(int a, int b, const LineOptions& o) {
  const int apart = std::abs(a - b);
  return o.bend > o.along || std::min(apart, o.angles - apart) <= 2;
}

std::vector<Line> join_crests(const Ridges& r, float limit, const LinePicture& p, const LineOptions& o) {
  cv::Mat left = crests_of(r, limit, o.angles);
  std::vector<Line> out;
  for (int y = 0; y < left.rows; ++y)
    for (int x = 0; x < left.cols; ++x) {
      const std::uint8_t kind = left.at<std::uint8_t>(y, x);
      if (kind == 0) continue;
      Line line;
      line.dark = kind == 1;
      line.pixels.emplace_back(x, y);
      left.at<std::uint8_t>(y, x) = 0;
      for (std::size_t i = 0; i < line.pixels.size(); ++i) {
        const cv::Point q = line.pixels[i];
        line.angle.push_back(r.angle.at<std::uint8_t>(q));
        line.score += std::abs(r.strength.at<float>(q)) - limit;
        for (int v = std::max(0, q.y - 1); v <= std::min(left.rows - 1, q.y + 1); ++v)
          for (int u = std::max(0, q.x - 1); u <= std::min(left.cols - 1, q.x + 1); ++u)
            if (left.at<std::uint8_t>(v, u) == kind &&
                continues_at(line.angle[i], r.angle.at<std::uint8_t>(v, u), o)) {
              left.at<std::uint8_t>(v, u) = 0;
              line.pixels.emplace_back(u, v);
            }
      }
      trim_line(line, r);
      measure_line(line, p, o.angles);
      out.push_back(std::move(line));
    }
  return out;
}

}  // namespace

std::vector<Line> find_lines(const LinePicture& p, const LineOptions& o, std::uint64_t seed,
                             const Work& work) {
  const std::vector<Ridges> ridges = find_ridges({p.value, without_lines(p, seed, work)}, p, o, work);
  std::vector<float> values;
  for (int y = 0; y < p.value.rows; ++y)
    for (int x = 0; x < p.value.cols; ++x)
      if (const float value = ridges[1].strength.at<float>(y, x); value != 0)
        values.push_back(std::abs(value));
  if (values.empty()) return {};
  const float limit = at_rank(values, static_cast<std::size_t>(kBelowLimit * (values.size() - 1)));
  float most = 0;
  for (const Line& line : join_crests(ridges[1], limit, p, o)) most = std::max(most, line.score);
  std::vector<Line> lines = join_crests(ridges[0], limit, p, o);
  std::erase_if(lines, [&](const Line& line) {
    return line.score <= o.clear * most || line.bend > o.bend || line.length < o.length;
  });
  std::map<std::pair<int, bool>, int> clear;
  for (const Line& line : lines) clear[{line.kind, line.dark}] += line.score > kClear * most;
  std::erase_if(lines, [&](const Line& line) { return clear[{line.kind, line.dark}] < kFewestClear; });
  return lines;
}

}  // namespace terrazzo::detail_solid
