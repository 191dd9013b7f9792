// Exemplars for tests of solids, and the memory used to make the solids.
#pragma once

#include <malloc.h>

#include <cmath>
#include <fstream>
#include <string>

#include "nodes/data/image.h"
#include "nodes/solids/synthesis/exemplar/exemplar_levels.h"
#include "runtime/random.h"

namespace terrazzo::test {

// Blobs of two colors: value noise with cells of `cell` pixels and a soft threshold.
inline Image blobs(int w, int h, double cell, std::uint64_t seed) {
  Image image(w, h, 1, 0.1);
  const auto lattice = [&](int i, int j) {
    return Random(seed, static_cast<std::uint64_t>(i), static_cast<std::uint64_t>(j)).uniform();
  };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const double u = x / cell, v = y / cell, fu = u - std::floor(u), fv = v - std::floor(v);
      const int i = static_cast<int>(u), j = static_cast<int>(v);
      const double n = (1 - fv) * ((1 - fu) * lattice(i, j) + fu * lattice(i + 1, j)) +
                       fv * ((1 - fu) * lattice(i, j + 1) + fu * lattice(i + 1, j + 1));
      const auto t = static_cast<float>(1 / (1 + std::exp(-20 * (n - 0.5))));
      image.at(x, y) = (1 - t) * Vec3f(0.1f, 0.15f, 0.4f) + t * Vec3f(0.8f, 0.6f, 0.3f);
    }
  return image;
}

inline solids::SolidExemplar exemplar_of(const Image& image) {
  solids::SolidExemplar e;
  e.width = image.width;
  e.height = image.height;
  e.pixels = image.pixels;
  return e;
}

// Memory of this process in bytes; 0 if the system does not report it.
inline double memory_of(const char* which) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind(which, 0) == 0) return 1024 * std::stod(line.substr(line.find(':') + 1));
  return 0;
}

// Peak bytes that `run` uses beyond the memory used before; negative if the system does not report it.
template <class Run>
double peak_of(Run&& run) {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << 5 << std::flush;  // reset the peak
  const double before = memory_of("VmRSS");
  if (before == 0 || memory_of("VmHWM") > before + 4e6) return -1;
  run();
  return memory_of("VmHWM") - before;
}

}  // namespace terrazzo::test
