#include "nodes/cooccurrence/load_strokes/svg_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"

namespace terrazzo::load_strokes {
namespace {

class Scanner {
 public:
  explicit Scanner(const std::string& text) : at_(text.data()), begin_(at_), end_(at_ + text.size()) {}

  void skip() {
    while (at_ < end_ && std::strchr(" \t\r\n,", *at_)) ++at_;
  }
  bool done() {
    skip();
    return at_ >= end_;
  }
  std::size_t position() const { return at_ - begin_; }
  // The next letter, or 0 if a number follows.
  char letter() {
    skip();
    return at_ < end_ && std::isalpha(static_cast<unsigned char>(*at_)) ? *at_++ : '\0';
  }
  bool number(double& out) {
    skip();
    const char* from = at_ < end_ && *at_ == '+' ? at_ + 1 : at_;
    const auto r = std::from_chars(from, end_, out);
    if (r.ec != std::errc() || !std::isfinite(out)) return false;
    at_ = r.ptr;
    return true;
  }
  bool flag(bool& out) {  // needs no separator from the next number
    skip();
    if (at_ >= end_ || (*at_ != '0' && *at_ != '1')) return false;
    out = *at_++ == '1';
    return true;
  }

 private:
  const char *at_, *begin_, *end_;
};

// At least 1 and at most `most`, even if huge coordinates make `wanted` infinite or NaN.
int steps(double wanted, int most) { return wanted > 1 ? round_up(std::min<double>(wanted, most)) : 1; }

void cubic(std::vector<Vec2>& out, const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d,
           double tolerance) {
  // n chords of a curve with |second derivative| ≤ m deviate by at most m / (8 n²).
  const double m = 6 * std::max((a - 2 * b + c).norm(), (b - 2 * c + d).norm());
  const int n = steps(std::sqrt(m / (8 * tolerance)), 1000);
  for (int i = 1; i <= n; ++i) {
    const double t = static_cast<double>(i) / n, s = 1 - t;
    out.push_back(s * s * s * a + 3 * s * s * t * b + 3 * s * t * t * c + t * t * t * d);
  }
}

// Follows the commands of a path.
class PathReader {
 public:
  PathReader(const std::string& data, double tolerance) : in_(data), tolerance_(tolerance) {}

  std::vector<std::vector<Vec2>> lines;

  // Reads the whole path, of at most this many points. Returns what is wrong, or null.
  const char* read(std::size_t most) {
    while (!in_.done()) {
      check_points(most);
      if (const char next = in_.letter())
        command_ = next;
      else if (command_ == 0 || command_ == 'Z' || command_ == 'z')
        return "a number without a command";
      else if (command_ == 'M' || command_ == 'm')
        command_ = command_ == 'M' ? 'L' : 'l';
      const char kind = std::toupper(static_cast<unsigned char>(command_));
      if (before_ == 0 && kind != 'M') return "the path does not begin with M";
      origin_ = std::islower(static_cast<unsigned char>(command_)) ? at_ : Vec2::Zero();
      if (const char* what = read_segment(kind)) return what;
      before_ = kind;
    }
    return nullptr;
  }
  std::size_t position() const { return in_.position(); }

 private:
  void check_points(std::size_t most) {
    for (; counted_ + 1 < lines.size(); ++counted_) finished_ += lines[counted_].size();
    if (finished_ + (lines.empty() ? 0 : lines.back().size()) > most)
      throw Error("too-large", fmt::format("a path has more than {} points", most),
                  "simplify the drawing, or raise --memory if the machine has more");
  }

  std::vector<Vec2>& line() {
    if (!open_) {
      lines.push_back({at_});
      first_ = at_;
      open_ = true;
    }
    return lines.back();
  }

  bool point(Vec2& p) {
    if (!in_.number(p.x()) || !in_.number(p.y())) return false;
    p += origin_;
    return true;
  }

  // Each reads one segment, and returns what is wrong or null.
  const char* read_segment(char kind) {
    switch (kind) {
      case 'M':
        return read_move();
      case 'L':
      case 'H':
      case 'V':
        return read_straight(kind);
      case 'C':
      case 'S':
        return read_cubic(kind);
      case 'Q':
      case 'T':
        return read_quadratic(kind);
      case 'A':
        return read_arc();
      case 'Z':
        line().push_back(first_);
        at_ = first_;
        open_ = false;
        return nullptr;
      default:
        return "an unknown command";
    }
  }

  const char* read_move() {
    Vec2 a;
    if (!point(a)) return "a point is missing";
    at_ = a;
    first_ = a;
    open_ = false;
    line();
    return nullptr;
  }

  const char* read_straight(char kind) {
    Vec2 a = at_;
    double d = 0;
    if (kind == 'L' ? !point(a) : !in_.number(d)) return "a coordinate is missing";
    if (kind == 'H') a.x() = origin_.x() + d;
    if (kind == 'V') a.y() = origin_.y() + d;
    line().push_back(a);
    at_ = a;
    return nullptr;
  }

  const char* read_cubic(char kind) {
    Vec2 a = kind == 'S' && (before_ == 'C' || before_ == 'S') ? Vec2(2 * at_ - control_) : at_;
    Vec2 b, c;
    if ((kind == 'C' && !point(a)) || !point(b) || !point(c)) return "a point is missing";
    cubic(line(), at_, a, b, c, tolerance_);
    control_ = b;
    at_ = c;
    return nullptr;
  }

  const char* read_quadratic(char kind) {
    Vec2 a = kind == 'T' && (before_ == 'Q' || before_ == 'T') ? Vec2(2 * at_ - control_) : at_;
    Vec2 c;
    if ((kind == 'Q' && !point(a)) || !point(c)) return "a point is missing";
    cubic(line(), at_, at_ + 2.0 / 3 * (a - at_), c + 2.0 / 3 * (a - c), c, tolerance_);
    control_ = a;
    at_ = c;
    return nullptr;
  }

  const char* read_arc() {
    Vec2 radii, c;
    double turn = 0;
    bool large = false, sweep = false;
    if (!in_.number(radii.x()) || !in_.number(radii.y()) || !in_.number(turn) || !in_.flag(large) ||
        !in_.flag(sweep) || !point(c))
      return "an arc is incomplete";
    auto& points = line();
    for (const auto& p : arc_points(at_, radii, turn, large, sweep, c, tolerance_)) points.push_back(p);
    at_ = c;
    return nullptr;
  }

  Scanner in_;
  double tolerance_;
  Vec2 at_ = Vec2::Zero(), first_ = Vec2::Zero(), control_ = Vec2::Zero();
  Vec2 origin_ = Vec2::Zero();  // of the coordinates of this command
  char command_ = 0, before_ = 0;
  bool open_ = false;
  std::size_t finished_ = 0, counted_ = 0;  // points of the subpaths before the last
};

}  // namespace

std::vector<Vec2> arc_points(const Vec2& from, Vec2 radii, double turn_degrees, bool large, bool sweep,
                             const Vec2& to, double tolerance) {
  radii = radii.cwiseAbs();
  if (radii.minCoeff() <= 0 || from == to) return {to};
  const Eigen::Rotation2Dd turn(turn_degrees * std::numbers::pi / 180);
  const Vec2 half = turn.inverse() * ((from - to) / 2);
  const double over = half.cwiseQuotient(radii).squaredNorm();
  if (over > 1) radii *= std::sqrt(over);
  const Vec2 unit = half.cwiseQuotient(radii);
  const double rest = std::max(0.0, 1 / std::max(unit.squaredNorm(), 1e-300) - 1);
  const Vec2 center = (large == sweep ? -1 : 1) * std::sqrt(rest) * Vec2(unit.y(), -unit.x());
  const Vec2 u = unit - center, v = -unit - center;
  double angle = std::atan2(v.y(), v.x()) - std::atan2(u.y(), u.x());
  if (sweep && angle < 0) angle += 2 * std::numbers::pi;
  if (!sweep && angle > 0) angle -= 2 * std::numbers::pi;
  const double start = std::atan2(u.y(), u.x());
  const double step = 2 * std::acos(std::clamp(1 - tolerance / radii.maxCoeff(), 0.0, 1.0));
  const int n = steps(std::abs(angle) / std::max(step, 1e-3), 4000);
  const Vec2 middle = turn * center.cwiseProduct(radii) + (from + to) / 2;
  std::vector<Vec2> out;
  for (int i = 1; i < n; ++i) {
    const double a = start + angle * i / n;
    out.push_back(middle + turn * Vec2(radii.x() * std::cos(a), radii.y() * std::sin(a)));
  }
  out.push_back(to);
  return out;
}

std::vector<std::vector<Vec2>> read_path(const std::string& data, double tolerance, std::string& broken,
                                         std::size_t most) {
  PathReader reader(data, tolerance);
  if (const char* what = reader.read(most))
    broken = fmt::format("{} at character {} of the path", what, reader.position() + 1);
  return std::move(reader.lines);
}

}  // namespace terrazzo::load_strokes
