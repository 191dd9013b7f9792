#include "nodes/cooccurrence/load_strokes/svg_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <numbers>

#include "graph/diagnostic.h"

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
int steps(double wanted, int most) {
  return wanted > 1 ? static_cast<int>(std::ceil(std::min<double>(wanted, most))) : 1;
}

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
  std::vector<std::vector<Vec2>> out;
  Scanner in(data);
  Vec2 at = Vec2::Zero(), first = Vec2::Zero(), control = Vec2::Zero();
  char command = 0, before = 0;
  bool open = false;
  const auto fail = [&](const char* what) {
    broken = fmt::format("{} at character {} of the path", what, in.position() + 1);
    return out;
  };
  const auto line = [&]() -> std::vector<Vec2>& {
    if (!open) {
      out.push_back({at});
      first = at;
      open = true;
    }
    return out.back();
  };
  std::size_t finished = 0, counted = 0;  // points of the subpaths before the last
  while (!in.done()) {
    for (; counted + 1 < out.size(); ++counted) finished += out[counted].size();
    if (finished + (out.empty() ? 0 : out.back().size()) > most)
      throw Error("too-large", fmt::format("a path has more than {} points", most),
                  "simplify the drawing, or raise --memory if the machine has more");
    if (const char next = in.letter())
      command = next;
    else if (command == 0 || command == 'Z' || command == 'z')
      return fail("a number without a command");
    else if (command == 'M' || command == 'm')
      command = command == 'M' ? 'L' : 'l';
    const char kind = std::toupper(static_cast<unsigned char>(command));
    if (before == 0 && kind != 'M') return fail("the path does not begin with M");
    const Vec2 origin = std::islower(static_cast<unsigned char>(command)) ? at : Vec2::Zero();
    const auto point = [&](Vec2& p) {
      if (!in.number(p.x()) || !in.number(p.y())) return false;
      p += origin;
      return true;
    };
    Vec2 a, b, c;
    switch (kind) {
      case 'M':
        if (!point(a)) return fail("a point is missing");
        at = first = a;
        open = false;
        line();
        break;
      case 'L':
      case 'H':
      case 'V': {
        a = at;
        double d = 0;
        if (kind == 'L' ? !point(a) : !in.number(d)) return fail("a coordinate is missing");
        if (kind == 'H') a.x() = origin.x() + d;
        if (kind == 'V') a.y() = origin.y() + d;
        line().push_back(a);
        at = a;
        break;
      }
      case 'C':
      case 'S':
        a = kind == 'S' && (before == 'C' || before == 'S') ? Vec2(2 * at - control) : at;
        if ((kind == 'C' && !point(a)) || !point(b) || !point(c)) return fail("a point is missing");
        cubic(line(), at, a, b, c, tolerance);
        control = b;
        at = c;
        break;
      case 'Q':
      case 'T':
        a = kind == 'T' && (before == 'Q' || before == 'T') ? Vec2(2 * at - control) : at;
        if ((kind == 'Q' && !point(a)) || !point(c)) return fail("a point is missing");
        cubic(line(), at, at + 2.0 / 3 * (a - at), c + 2.0 / 3 * (a - c), c, tolerance);
        control = a;
        at = c;
        break;
      case 'A': {
        Vec2 radii;
        double turn = 0;
        bool large = false, sweep = false;
        if (!in.number(radii.x()) || !in.number(radii.y()) || !in.number(turn) || !in.flag(large) ||
            !in.flag(sweep) || !point(c))
          return fail("an arc is incomplete");
        auto& points = line();
        for (const auto& p : arc_points(at, radii, turn, large, sweep, c, tolerance)) points.push_back(p);
        at = c;
        break;
      }
      case 'Z':
        line().push_back(first);
        at = first;
        open = false;
        break;
      default:
        return fail("an unknown command");
    }
    before = kind;
  }
  return out;
}

}  // namespace terrazzo::load_strokes
