#include "nodes/common/texture/lane_fft.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/data/indices.h"

namespace terrazzo {
namespace {

LaneComplex operator+(const LaneComplex& a, const LaneComplex& b) { return {a.re + b.re, a.im + b.im}; }
LaneComplex operator-(const LaneComplex& a, const LaneComplex& b) { return {a.re - b.re, a.im - b.im}; }
LaneComplex times(const LaneComplex& a, float c, float s) {
  return {a.re * c - a.im * s, a.re * s + a.im * c};
}
LaneComplex times_i(const LaneComplex& a) { return {-a.im, a.re}; }
LaneComplex scaled(const LaneComplex& a, float c) { return {a.re * c, a.im * c}; }

// Transforms `radix` values in place; `sign` is −1 forward, +1 inverse.
void small(LaneComplex* a, int radix, float sign) {
  const auto turn = [sign](const LaneComplex& v) { return sign > 0 ? times_i(v) : LaneComplex{v.im, -v.re}; };
  if (radix == 2) {
    const LaneComplex t = a[1];
    a[1] = a[0] - t;
    a[0] = a[0] + t;
  } else if (radix == 3) {
    const LaneComplex s = a[1] + a[2], d = turn(scaled(a[1] - a[2], 0.866025403784438647f));
    const LaneComplex c = a[0] - scaled(s, 0.5f);
    a[0] = a[0] + s;
    a[1] = c + d;
    a[2] = c - d;
  } else if (radix == 4) {
    const LaneComplex s = a[0] + a[2], d = a[0] - a[2], t = a[1] + a[3], u = turn(a[1] - a[3]);
    a[0] = s + t;
    a[1] = d + u;
    a[2] = s - t;
    a[3] = d - u;
  } else {  // radix 5
    constexpr float kC1 = 0.309016994374947424f, kC2 = -0.809016994374947424f;
    constexpr float kS1 = 0.951056516295153572f, kS2 = 0.587785252292473129f;
    const LaneComplex p = a[1] + a[4], q = a[2] + a[3], d = a[1] - a[4], e = a[2] - a[3];
    const LaneComplex x = a[0] + scaled(p, kC1) + scaled(q, kC2), y = a[0] + scaled(p, kC2) + scaled(q, kC1);
    const LaneComplex u = turn(scaled(d, kS1) + scaled(e, kS2)), v = turn(scaled(d, kS2) - scaled(e, kS1));
    a[0] = a[0] + p + q;
    a[1] = x + u;
    a[4] = x - u;
    a[2] = y + v;
    a[3] = y - v;
  }
}

bool fast(int n) {
  for (const int p : {2, 3, 5})
    while (n % p == 0) n /= p;
  return n == 1;
}

}  // namespace

LaneFft::LaneFft(int n) : n_(n) {
  for (int left = n; left > 1;) {
    int radix = 0;
    for (const int p : {4, 2, 3, 5})
      if (radix == 0 && left % p == 0) radix = p;
    for (int p = 7; radix == 0; p += 2)
      if (left % p == 0 || p * p > left) radix = left % p == 0 ? p : left;
    Stage s{radix, left / radix, {}, {}};
    for (int p = 0; p < s.m; ++p)
      for (int k = 1; k < radix; ++k) {
        const double angle = 2 * std::numbers::pi * (static_cast<double>(p) * k / left);
        s.cos.push_back(static_cast<float>(std::cos(angle))),
            s.sin.push_back(static_cast<float>(std::sin(angle)));
      }
    left = s.m;
    stages_.push_back(std::move(s));
  }
  if (!fast(n))
    for (int j = 0; j < n; ++j) {
      root_cos_.push_back(static_cast<float>(std::cos(2 * std::numbers::pi * j / n)));
      root_sin_.push_back(static_cast<float>(std::sin(2 * std::numbers::pi * j / n)));
    }
}

// Stockham's autosort FFT, decimation in frequency: no bit reversal, unit strides (Van Loan 1992, 1.7).
void LaneFft::run(LaneComplex* data, LaneComplex* scratch, int inner, bool inverse) const {
  const float sign = inverse ? 1.0f : -1.0f;
  LaneComplex *from = data, *to = scratch;
  std::size_t stride = inner;
  std::vector<LaneComplex> wide;
  for (const Stage& st : stages_) {
    const int radix = st.radix, m = st.m;
    for (int p = 0; p < m; ++p) {
      const float* c = &st.cos[static_cast<std::size_t>(p) * (radix - 1)];
      const float* s = &st.sin[static_cast<std::size_t>(p) * (radix - 1)];
      const LaneComplex* in = from + stride * p;
      LaneComplex* out = to + stride * radix * p;
      const std::size_t step = stride * m;
      const auto pass = [&]<int R>() {
        for (std::size_t q = 0; q < stride; ++q) {
          LaneComplex a[R];
          for (int j = 0; j < R; ++j) a[j] = in[q + step * j];
          small(a, R, sign);
          out[q] = a[0];
          for (int k = 1; k < R; ++k) out[q + stride * k] = times(a[k], c[k - 1], sign * s[k - 1]);
        }
      };
      if (radix == 4) {
        pass.template operator()<4>();
      } else if (radix == 2) {
        pass.template operator()<2>();
      } else if (radix == 3) {
        pass.template operator()<3>();
      } else if (radix == 5) {
        pass.template operator()<5>();
      } else {
        wide.resize(radix);
        for (std::size_t q = 0; q < stride; ++q) {
          for (int j = 0; j < radix; ++j) wide[j] = in[q + step * j];
          for (int k = 0; k < radix; ++k) {
            LaneComplex sum = wide[0];
            for (int j = 1; j < radix; ++j) {
              const std::size_t r = static_cast<std::size_t>(j) * k % radix * (n_ / radix);
              sum = sum + times(wide[j], root_cos_[r], sign * root_sin_[r]);
            }
            out[q + stride * k] = k == 0 ? sum : times(sum, c[k - 1], sign * s[k - 1]);
          }
        }
      }
    }
    stride *= radix;
    std::swap(from, to);
  }
  if (from != data) std::copy(from, from + static_cast<std::size_t>(n_) * inner, data);
}

void LaneFft2::run(LaneComplex* data, bool inverse, std::vector<LaneComplex>& scratch) const {
  constexpr int kBlock = 4;  // columns at a time: two cache lines of each row
  const int w = width(), h = height();
  scratch.resize(std::max<std::size_t>(w, 2 * static_cast<std::size_t>(kBlock) * h));
  for (int y = 0; y < h; ++y) x_.run(data + static_cast<std::size_t>(y) * w, scratch.data(), 1, inverse);
  for (int x = 0; x < w; x += kBlock) {
    const int n = std::min(kBlock, w - x);
    LaneComplex* columns = scratch.data();
    for (int y = 0; y < h; ++y)
      std::copy_n(data + pixel_at(x, y, w), n, columns + static_cast<std::size_t>(y) * n);
    y_.run(columns, columns + static_cast<std::size_t>(kBlock) * h, n, inverse);
    for (int y = 0; y < h; ++y)
      std::copy_n(columns + static_cast<std::size_t>(y) * n, n, data + pixel_at(x, y, w));
  }
}

int fast_size_below(int n) {
  while (!fast(n)) --n;
  return n;
}

int fast_even_size_above(int n) {
  n += n % 2;
  while (!fast(n)) n += 2;
  return n;
}

}  // namespace terrazzo
