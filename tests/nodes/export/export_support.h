// A small packing with its shapes, and a simulated full disk.
#pragma once

#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/random.h"

namespace terrazzo::test {

inline Shape tetrahedron(const std::string& name, bool smooth) {
  Shape s;
  s.name = name;
  s.smooth = smooth;
  s.mesh.vertices = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  s.mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  s.volume = 8.0 / 3;
  return s;
}

// A smooth and a faceted shape, and a third one without particles.
inline Shapes two_shapes() {
  Shapes s;
  s.shapes = {tetrahedron("faceted", false), tetrahedron("smooth", true), tetrahedron("unused", false)};
  return s;
}

inline Particles some_particles(std::size_t count, std::uint64_t seed = 1) {
  Particles p;
  p.box = Vec3(20, 30, 40);
  p.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    Random r(seed, 5, i);
    p.shape[i] = static_cast<std::int32_t>(r.below(2));
    p.cls[i] = static_cast<std::int32_t>(r.below(3));
    p.position[i] = Vec3(20 * r.uniform(), 30 * r.uniform(), 40 * r.uniform());
    p.orientation[i] = Quat(r.normal(), r.normal(), r.normal(), r.normal()).normalized();
    p.scale[i] = r.uniform(0.1, 2);
    p.size[i] = 3 * p.scale[i];
    p.color[i] = Vec3f(float(r.uniform()), float(r.uniform()), float(r.uniform()));
  }
  return p;
}

inline std::string content_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline std::size_t files_in(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(folder)) return 0;
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

// During its lifetime, this process can write no file longer than `bytes`; longer writes fail as on a full
// disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    old_action_ = std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &old_);
    rlimit limit = old_;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_action_);
  }

 private:
  rlimit old_{};
  void (*old_action_)(int);
};

}  // namespace terrazzo::test
