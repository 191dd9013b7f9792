#include "nodes/detail/detail_solid/lines.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kLineWindow = 1024;  // pixels
constexpr int kLeastLineWindow = 64;
constexpr double kBroaderThanLines = 8;  // pixels: standard deviation of what is broader than lines
constexpr float kMostDeviations = 4;     // deviations: single specks do not make lines
constexpr float kLeastContrastOfLines = 1.5f / 255;
constexpr float kRimWidth = 8;  // pixels from an outline
constexpr int kBesideLine = 2;  // pixels on each side of a line that show it
constexpr int kAcross = Detail::Scratch::kReach;
constexpr int kFewestSheets = 12;  // fewer do not tell a density
constexpr LineOptions kScratches{12, 1, 24, 1, 24}, kSheets{3, 0.8, 16, 1e9, 8, 0.5f};

class LineFinder {
 public:
  LineFinder(Phases& phases, const Labels& labels, const std::vector<float>& noise)
      : p_(phases),
        labels_(labels),
        noise_(noise),
        area_((phases.width - side(phases.width)) / 2, (phases.height - side(phases.height)) / 2,
              side(phases.width), side(phases.height)),
        flat_(area_.size(), CV_32F) {}

  void find(Detail& detail, std::uint64_t seed, const Work& work) {
    prepare(work);
    std::vector<Line> scratches = find_lines(with_kinds(false), kScratches, seed, work.part(0, 0.5));
    std::erase_if(scratches, [](const Line& line) { return line.kind > 0; });  // cracks run straight, too
    measure_scratches(scratches, detail);
    take_out(scratches);
    const std::vector<Line> lines = find_lines(with_kinds(true), kSheets, seed + 1, work.part(0.5, 1));
    p_.sheets.assign(labels_.count(), 1);
    const bool veins = scratches.empty() && p_.zone.empty();
    for (int phase = veins ? 0 : 1; phase < count_of(p_.pixels); ++phase) {
      const bool dark = mostly_dark(lines, phase);
      std::vector<Line> own;
      for (const Line& line : lines)
        if (line.kind == phase && line.dark == dark) own.push_back(line);
      if (count_of(own) < kFewestSheets) continue;
      detail.phases[phase].sheets = sheets_of(own, phase);
      if (phase > 0) measure_profiles(own, phase, detail.phases[phase].sheets);
      take_out(own);
    }
  }

 private:
  static int side(int length) { return std::min(length, kLineWindow); }
  std::size_t index(const cv::Point& q) const { return pixel_at(q.x + area_.x, q.y + area_.y, p_.width); }
  int phase(const cv::Point& q) const { return p_.phase[index(q)]; }
  // What particles show is multiplied by this.
  float unit(const cv::Point& q) const {
    const std::int32_t label = labels_.ids[index(q)];
    return phase(q) > 0 ? Detail::particle_scale(linear_to_srgb(p_.profile_color[label - 1])) : 1;
  }
  float lightness(const cv::Point& q) const {
    return p_.offset[index(q)].mean() + (noise_.empty() ? 0 : noise_[index(q)] / unit(q));
  }

  template <class Use>
  void each(Use&& use) const {
    for (int y = 0; y < area_.height; ++y)
      for (int x = 0; x < area_.width; ++x) use(cv::Point(x, y));
  }

  // Lightness without what is broader than lines, and relative to the deviation of the profile or binder.
  void prepare(const Work& work) {
    picture_.value = cv::Mat::zeros(area_.size(), CV_32F);
    picture_.known = cv::Mat::zeros(area_.size(), CV_32F);
    picture_.rim = cv::Mat::zeros(area_.size(), CV_32FC3);
    flat_.setTo(0);
    for (int k = 0; k < count_of(p_.pixels); ++k) {
      work.check();
      cv::Mat own = cv::Mat::zeros(area_.size(), CV_32F), value = own.clone(), share;
      each([&](const cv::Point& q) {
        if (phase(q) != k) return;
        own.at<float>(q) = 1;
        value.at<float>(q) = std::clamp(lightness(q), -0.1f, 0.1f);
      });
      cv::GaussianBlur(value, value, {0, 0}, kBroaderThanLines, kBroaderThanLines, cv::BORDER_REFLECT);
      cv::GaussianBlur(own, share, {0, 0}, kBroaderThanLines, kBroaderThanLines, cv::BORDER_REFLECT);
      each([&](const cv::Point& q) {
        if (phase(q) == k) flat_.at<float>(q) = lightness(q) - value.at<float>(q) / share.at<float>(q);
      });
    }
    std::vector<std::vector<float>> sizes(labels_.count() + 1);
    each([&](const cv::Point& q) {
      if (phase(q) >= 0) sizes[labels_.ids[index(q)]].push_back(std::abs(flat_.at<float>(q)));
    });
    std::vector<float> deviation;
    for (auto& of : sizes)
      deviation.push_back(std::max(kLeastContrastOfLines, of.empty() ? 0 : 1.4826f * median(std::move(of))));
    const residual::Outlines outlines =
        residual::nearest_outlines(labels_.ids.data(), p_.width, p_.height, false);
    each([&](const cv::Point& q) {
      if (phase(q) < 0) return;
      picture_.known.at<float>(q) = 1;
      picture_.value.at<float>(q) = std::clamp(flat_.at<float>(q) / deviation[labels_.ids[index(q)]],
                                               -kMostDeviations, kMostDeviations);
    });
    each([&](const cv::Point& q) {
      const Eigen::Vector2f& normal = outlines.normal[index(q)];
      if (outlines.depth[index(q)] >= kRimWidth) return;
      picture_.rim.at<cv::Vec3f>(q) =
          phase(q) > 0 ? cv::Vec3f(normal.x(), -normal.y(), normal.norm() > 0.5f) : cv::Vec3f(0, 0, 1);
    });
  }

  // `phases`: each phase is a kind; else binder and particles are.
  LinePicture with_kinds(bool phases) {
    picture_.kind = cv::Mat::zeros(area_.size(), CV_8U);
    each([&](const cv::Point& q) {
      const int k = phase(q);
      picture_.kind.at<std::uint8_t>(q) = phases ? std::max(0, k) : k > 0;
    });
    return picture_;
  }

  static bool mostly_dark(const std::vector<Line>& lines, int kind) {
    double dark = 0;
    for (const Line& line : lines)
      if (line.kind == kind) dark += line.dark ? line.length : -line.length;
    return dark > 0;
  }

  // Mean lightness across a line, without what is broad. `across`: from the line's pixels to one side.
  struct Across {
    std::array<double, 2 * kAcross + 1> sum{}, count{};
    std::array<float, 2 * kAcross + 1> values() const {
      std::array<float, 2 * kAcross + 1> out{};
      const auto at = [&](int k) { return count[k] > 0 ? sum[k] / count[k] : 0; };
      const double ends = (at(0) + at(2 * kAcross)) / 2;
      for (int k = 0; k <= 2 * kAcross; ++k) out[k] = static_cast<float>(at(k) - ends);
      return out;
    }
  };
  // `scale`: of the offsets of particles, see Detail.
  void add_across(Across& sums, const cv::Point2f& at, const cv::Point2f& across, bool particles,
                  bool scale) const {
    for (int t = -kAcross; t <= kAcross; ++t) {
      const cv::Point q(cvRound(at.x + t * across.x), cvRound(at.y + t * across.y));
      if (!cv::Rect(cv::Point(), area_.size()).contains(q) || phase(q) < 0 || (phase(q) > 0) != particles)
        continue;
      sums.sum[t + kAcross] += (scale ? unit(q) : 1) * flat_.at<float>(q);
      ++sums.count[t + kAcross];
    }
  }

  // Whether two lines are parts of one scratch that something hides between them.
  static bool continues(const Line& a, const Line& b) {
    constexpr double kStraight = 0.05, kApart = 3;  // radians and pixels
    const cv::Point2f apart = b.center - a.center;
    return a.kind == b.kind && a.dark == b.dark && std::abs(a.direction.cross(b.direction)) < kStraight &&
           std::max(std::abs(a.direction.cross(apart)), std::abs(b.direction.cross(apart))) < kApart;
  }

  void measure_scratches(const std::vector<Line>& lines, Detail& detail) const {
    double searched = 0;  // pixels of the binder
    each([&](const cv::Point& q) {
      searched += picture_.known.at<float>(q) > 0 && picture_.rim.at<cv::Vec3f>(q)[2] == 0 && phase(q) == 0;
    });
    std::vector<bool> done(lines.size(), false);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (done[i]) continue;
      std::vector<const Line*> parts;
      for (std::size_t j = i; j < lines.size(); ++j)
        if (!done[j] && continues(lines[i], lines[j])) {
          done[j] = true;
          parts.push_back(&lines[j]);
        }
      detail.scratches.push_back(scratch_of(parts, std::max(1.0, searched)));
    }
  }

  // `searched`: pixels of the binder.
  Detail::Scratch scratch_of(const std::vector<const Line*>& parts, double searched) const {
    Detail::Scratch out;
    float seen = 0, first = 1e9f, last = -1e9f;
    Across sums;
    for (const Line* line : parts) {
      const cv::Point2f d = line->direction, apart = line->center - parts[0]->center;
      const float at = apart.dot(parts[0]->direction);
      seen += line->length;
      first = std::min(first, at - line->length / 2);
      last = std::max(last, at + line->length / 2);
      double angle = std::atan2(-d.y, d.x);
      if (angle < 0) angle += std::numbers::pi;
      if (line == parts[0]) out.angle = static_cast<float>(angle);
      // To the left of the direction, which points upwards.
      const cv::Point2f across(-static_cast<float>(std::sin(angle)), -static_cast<float>(std::cos(angle)));
      for (float t = -line->length / 2; t <= line->length / 2; t += 0.5f)
        add_across(sums, line->center + t * d, across, false, true);
    }
    out.length = last - first;
    out.area = static_cast<float>(searched * out.length / seen);
    out.profile = sums.values();
    return out;
  }

  Detail::Sheets sheets_of(const std::vector<Line>& lines, int phase) const {
    Detail::Sheets out;
    double length = 0, bend = 0, pixels = 0, light = 0, squares = 0;
    Vec3 offset = Vec3::Zero();
    Across sums;
    for (const Line& line : lines) {
      length += line.length;
      bend += line.length * line.bend;
      for (std::size_t i = 0; i < line.pixels.size(); ++i) {
        const cv::Point& q = line.pixels[i];
        if (this->phase(q) != phase) continue;
        const double angle = std::numbers::pi * line.angle[i] / kSheets.angles;
        add_across(sums, q, {-static_cast<float>(std::sin(angle)), static_cast<float>(std::cos(angle))},
                   phase > 0, false);
        offset += p_.offset[index(q)].cast<double>();
        light += lightness(q);
        squares += lightness(q) * lightness(q);
        ++pixels;
      }
    }
    double area = 0;
    each([&](const cv::Point& q) { area += this->phase(q) == phase; });
    out.length = static_cast<float>(length / lines.size());
    out.density = static_cast<float>(std::min(1.0, length / std::max(area, 1.0)));
    out.bend = static_cast<float>(std::min(bend / length, length / lines.size() / 8));
    out.offset = (offset / std::max(pixels, 1.0)).cast<float>();
    out.spread =
        static_cast<float>(std::sqrt(std::max(0.0, squares / pixels - light * light / (pixels * pixels))));
    const auto profile = sums.values();
    double whole = 0;
    for (const float v : profile) whole += v;
    const double width = whole / (profile[kAcross] * std::sqrt(2 * std::numbers::pi));
    out.width = static_cast<float>(std::clamp(width, 0.4, 3.0));
    return out;
  }

  // The density of each profile relative to the phase's, as if it had one line more in the area that has one
  // on average.
  void measure_profiles(const std::vector<Line>& lines, int phase, const Detail::Sheets& all) {
    std::vector<double> length(p_.sheets.size(), 0), area(p_.sheets.size(), 0);
    each([&](const cv::Point& q) {
      if (this->phase(q) == phase) ++area[labels_.ids[index(q)] - 1];
    });
    for (const Line& line : lines)
      for (const cv::Point& q : line.pixels)
        if (this->phase(q) == phase) length[labels_.ids[index(q)] - 1] += line.length / line.pixels.size();
    for (std::size_t k = 0; k < area.size(); ++k)
      if (area[k] > 0)
        p_.sheets[k] = static_cast<float>((length[k] + all.length) / (all.density * area[k] + all.length));
  }

  // Neither tiles nor later measurements see lines.
  void take_out(const std::vector<Line>& lines) {
    for (const Line& line : lines)
      for (const cv::Point& at : line.pixels)
        for (int y = std::max(0, at.y - kBesideLine); y <= std::min(area_.height - 1, at.y + kBesideLine);
             ++y)
          for (int x = std::max(0, at.x - kBesideLine); x <= std::min(area_.width - 1, at.x + kBesideLine);
               ++x) {
            const cv::Point q(x, y);
            std::int8_t& own = p_.phase[index(q)];
            if (own < 0) continue;
            --p_.pixels[own];
            own = -1;
            p_.offset[index(q)].setZero();
            picture_.value.at<float>(q) = 0;
            picture_.known.at<float>(q) = 0;
          }
  }

  Phases& p_;
  const Labels& labels_;
  const std::vector<float>& noise_;
  cv::Rect area_;
  cv::Mat flat_;  // lightness without what is broader than lines
  LinePicture picture_;
};

}  // namespace

void split_lines(Phases& phases, const Labels& labels, const std::vector<float>& noise, Detail& detail,
                 std::uint64_t seed, const Work& work) {
  if (std::min(phases.width, phases.height) < kLeastLineWindow) return;
  LineFinder(phases, labels, noise).find(detail, seed, work);
}

}  // namespace terrazzo::detail_solid
