#include "nodes/common/texture/block_fft.h"

#include <algorithm>

#include "nodes/common/texture/lane_fft.h"
#include "nodes/data/indices.h"

namespace terrazzo {

using Complex = std::complex<float>;

namespace {

// Lines that are transformed together: kLanes in the lanes of a register, kInner registers.
constexpr std::size_t kInner = 4, kLanes = 4, kLines = kInner * kLanes;

// The lines of a block along one axis.
struct Lines {
  std::size_t length, step, count;  // numbers of a line, their distance in memory, and lines

  Lines(const Vec3i& size, int axis)
      : length(size[axis]),
        step(axis == 0   ? 1
             : axis == 1 ? size.x()
                         : pixels_in(size.x(), size.y())),
        count(voxels_in(size) / length) {}

  // The first number of a line: lines next to each other in memory come next to each other.
  std::size_t start(std::size_t line) const { return line / step * step * length + line % step; }
  // Whether kLines lines lie side by side.
  bool adjacent(std::size_t first) const {
    return step > 1 && first % step + kLines <= step && first + kLines <= count;
  }
};

// Copies a number of kLines adjacent lines into registers, or back.
void gather(const Complex* from, LaneComplex* to) {
  const float* f = reinterpret_cast<const float*>(from);
  for (std::size_t q = 0; q < kInner; ++q)
    for (std::size_t l = 0; l < kLanes; ++l) {
      to[q].re[l] = f[2 * (q * kLanes + l)];
      to[q].im[l] = f[2 * (q * kLanes + l) + 1];
    }
}
void scatter(const LaneComplex* from, Complex* to) {
  float* f = reinterpret_cast<float*>(to);
  for (std::size_t q = 0; q < kInner; ++q)
    for (std::size_t l = 0; l < kLanes; ++l) {
      f[2 * (q * kLanes + l)] = from[q].re[l];
      f[2 * (q * kLanes + l) + 1] = from[q].im[l];
    }
}

void transform_lines(std::vector<Complex>& data, const Lines& lines, const LaneFft& fft, std::size_t first,
                     bool inverse, std::vector<LaneComplex>& block, std::vector<LaneComplex>& scratch) {
  const std::size_t n = lines.length, count = std::min(kLines, lines.count - first);
  Complex* adjacent = lines.adjacent(first) ? data.data() + lines.start(first) : nullptr;
  for (std::size_t i = 0; adjacent && i < n; ++i)
    gather(adjacent + i * lines.step, block.data() + i * kInner);
  for (std::size_t l = 0; !adjacent && l < kLines; ++l) {
    const Complex* from = l < count ? data.data() + lines.start(first + l) : nullptr;
    for (std::size_t i = 0; i < n; ++i) {
      const Complex v = from ? from[i * lines.step] : Complex(0);
      block[i * kInner + l / kLanes].re[l % kLanes] = v.real();
      block[i * kInner + l / kLanes].im[l % kLanes] = v.imag();
    }
  }
  fft.run(block.data(), scratch.data(), kInner, inverse);
  for (std::size_t i = 0; adjacent && i < n; ++i)
    scatter(block.data() + i * kInner, adjacent + i * lines.step);
  for (std::size_t l = 0; !adjacent && l < count; ++l) {
    Complex* to = data.data() + lines.start(first + l);
    for (std::size_t i = 0; i < n; ++i)
      to[i * lines.step] = {block[i * kInner + l / kLanes].re[l % kLanes],
                            block[i * kInner + l / kLanes].im[l % kLanes]};
  }
}

}  // namespace

void transform_block(std::vector<Complex>& data, const Vec3i& size, bool inverse, const Work& work) {
  for (int axis = 0; axis < 3; ++axis) {
    const Lines lines(size, axis);
    const LaneFft fft(size[axis]);
    work.part(axis / 3.0, (axis + 1) / 3.0)
        .parallel((lines.count + kLines - 1) / kLines, 16, [&](std::size_t begin, std::size_t end) {
          std::vector<LaneComplex> block(lines.length * kInner), scratch(lines.length * kInner);
          for (std::size_t b = begin; b < end; ++b)
            transform_lines(data, lines, fft, b * kLines, inverse, block, scratch);
        });
  }
}

}  // namespace terrazzo
