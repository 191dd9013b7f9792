#include "nodes/common/texture/quantiles.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace terrazzo {

float Quantiles::of(double u) const {
  const double x = std::clamp(u, 0.0, 1.0) * (at.size() - 1);
  const std::size_t i = std::min<std::size_t>(x, at.size() - 2);
  return at[i] + static_cast<float>(x - i) * (at[i + 1] - at[i]);
}

void Quantiles::widen(double factor) {
  const auto move = [&](float& v) { v = mean + (v - mean) * factor; };
  for (float& v : at) move(v);
  move(least);
  move(most);
  deviation *= factor;
}

Quantiles quantiles_of(const std::vector<float>& values) {
  Quantiles q;
  double sum = 0, squares = 0;
  for (const float v : values) sum += v;
  q.mean = sum / values.size();
  for (const float v : values) squares += (v - q.mean) * (v - q.mean);
  q.deviation = std::sqrt(squares / values.size());
  std::vector<float> picked;
  const std::size_t most = std::min<std::size_t>(values.size(), 65536);
  for (std::size_t i = 0; i < most; ++i) picked.push_back(values[i * values.size() / most]);
  std::sort(picked.begin(), picked.end());
  q.least = picked.front();
  q.most = picked.back();
  // Entry i represents the middle of its share of the samples.
  constexpr std::size_t kEntries = 2049;
  for (std::size_t i = 0; i < kEntries; ++i) {
    const double x = static_cast<double>(i) / (kEntries - 1) * most - 0.5;
    const double c = std::clamp<double>(x, 0.0, most - 1);
    const std::size_t lo = static_cast<std::size_t>(c), hi = std::min(lo + 1, most - 1);
    q.at.push_back(picked[lo] + static_cast<float>(c - lo) * (picked[hi] - picked[lo]));
  }
  // Set the outermost entries so that the outermost cells have the mean of their samples, instead of to the
  // extremes. A straight line to a single outlier would widen the distribution by several percent.
  const std::size_t cell = most / (kEntries - 1);
  if (cell >= 2) {
    double low = 0, high = 0;
    for (std::size_t i = 0; i < cell; ++i) {
      low += picked[i];
      high += picked[most - 1 - i];
    }
    const auto end = [&](double mean_of_cell, float inner) {
      return static_cast<float>(2 * mean_of_cell / cell - inner);
    };
    q.at.front() = std::clamp(end(low, q.at[1]), picked.front(), q.at[1]);
    q.at.back() = std::clamp(end(high, q.at[kEntries - 2]), q.at[kEntries - 2], picked.back());
  }
  return q;
}

Quantiles mixture(const std::vector<const Quantiles*>& parts) {
  if (parts.size() == 1) return *parts[0];
  std::vector<float> values;
  for (const Quantiles* q : parts) values.insert(values.end(), q->at.begin(), q->at.end());
  Quantiles out = quantiles_of(values);
  double mean = 0, square = 0;
  for (const Quantiles* q : parts) {
    mean += q->mean;
    square += q->deviation * q->deviation + q->mean * q->mean;
  }
  for (const Quantiles* q : parts) {
    out.least = std::min(out.least, q->least);
    out.most = std::max(out.most, q->most);
  }
  const double n = parts.size();
  out.mean = mean / n;
  out.deviation = std::sqrt(std::max(0.0, square / n - out.mean * out.mean));
  return out;
}

Remap::Remap(const Quantiles& target) : target_(&target) {
  const float width = std::max(target.most - target.least, 1e-12f);
  lo_ = target.least - width / 2;
  scale_ = kBins / (2 * width);
}

namespace {

// Bins of four values, as whole and fractional parts.
using Four = float __attribute__((vector_size(16)));
using FourInts = std::int32_t __attribute__((vector_size(16)));

struct BinPlace {
  FourInts bin;
  Four part;
};

inline BinPlace place(const float* v, float lo, float scale) {
  Four x;
  std::memcpy(&x, v, sizeof x);
  x = (x - lo) * scale;
  constexpr float kTop = Remap::kBins - 0.001f;
  x = x > 0.0f ? x : Four{};  // NaN also becomes the first bin
  x = x < kTop ? x : Four{kTop, kTop, kTop, kTop};
  BinPlace p;
  p.bin = __builtin_convertvector(x, FourInts);
  p.part = x - __builtin_convertvector(p.bin, Four);
  return p;
}

// Calls `use` with the bins of every four values; the last values are padded.
template <class Use>
void each_four(const float* values, std::size_t n, float lo, float scale, Use&& use) {
  std::size_t i = 0;
  for (; i + 4 <= n; i += 4) use(i, 4, place(values + i, lo, scale));
  if (i == n) return;
  float rest[4] = {};
  std::copy(values + i, values + n, rest);
  use(i, static_cast<int>(n - i), place(rest, lo, scale));
}

}  // namespace

void Remap::count(const float* values, std::size_t n, Counts& counts) const {
  each_four(values, n, lo_, scale_, [&](std::size_t, int used, const BinPlace& p) {
    for (int l = 0; l < used; ++l) ++counts[p.bin[l]];
  });
}

void Remap::apply(float* values, std::size_t n) const {
  each_four(values, n, lo_, scale_, [&](std::size_t i, int used, const BinPlace& p) {
    for (int l = 0; l < used; ++l) {
      const Bin& b = base_[p.bin[l]];
      values[i + l] = b.value + p.part[l] * b.rise;
    }
  });
}

void Remap::finish(const Counts& counts) {
  double total = 0, below = 0;
  for (const auto c : counts) total += c;
  float at = target_->of(0);
  for (const auto c : counts) {
    const float next = target_->of((below += c) / total);
    base_.push_back({at, next - at});
    at = next;
  }
}

void match_values(std::vector<float>& values, const Quantiles& target, const Work& work) {
  const Work quiet = work.part(0, 0);
  Remap remap(target);
  remap.finish(quiet.reduce<Remap::Counts>(
      values.size(), std::max<std::size_t>(1 << 16, values.size() / 64 + 1), Remap::Counts(Remap::kBins, 0),
      [&](std::size_t b, std::size_t e) {
        Remap::Counts c(Remap::kBins, 0);
        remap.count(values.data() + b, e - b, c);
        return c;
      },
      [](Remap::Counts a, const Remap::Counts& b) {
        for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
        return a;
      }));
  quiet.parallel(values.size(), 1 << 16,
                 [&](std::size_t b, std::size_t e) { remap.apply(values.data() + b, e - b); });
}

}  // namespace terrazzo
