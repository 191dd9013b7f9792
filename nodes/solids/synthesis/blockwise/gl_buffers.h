// The functions of OpenGL that the blockwise passes call, and their arrays on the device.
#pragma once

#include <GL/glcorearb.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/common/gl/gl_program.h"
#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/blockwise/gl.h"

namespace terrazzo::solids {

// Functions by name, and programs; all are released with the context.
struct BlockGl::Gl {
  static constexpr int kGroup = 8;  // work group size along columns and rows, as in the shaders

  EglContext context;
  bool software;
  GLuint search = 0, weigh = 0, blend = 0, map = 0, copy = 0, program = 0;

  explicit Gl(GlDevice device) : context(device), software(device == GlDevice::Cpu) {}
#define TERRAZZO_GL(name, type) type name = context.function<type>("gl" #name)
  TERRAZZO_GL(BindBuffer, PFNGLBINDBUFFERPROC);
  TERRAZZO_GL(BindBufferBase, PFNGLBINDBUFFERBASEPROC);
  TERRAZZO_GL(BufferData, PFNGLBUFFERDATAPROC);
  TERRAZZO_GL(BufferSubData, PFNGLBUFFERSUBDATAPROC);
  TERRAZZO_GL(CopyBufferSubData, PFNGLCOPYBUFFERSUBDATAPROC);
  TERRAZZO_GL(DeleteBuffers, PFNGLDELETEBUFFERSPROC);
  TERRAZZO_GL(DispatchCompute, PFNGLDISPATCHCOMPUTEPROC);
  TERRAZZO_GL(Finish, PFNGLFINISHPROC);
  TERRAZZO_GL(GenBuffers, PFNGLGENBUFFERSPROC);
  TERRAZZO_GL(GetBufferSubData, PFNGLGETBUFFERSUBDATAPROC);
  TERRAZZO_GL(GetInteger64v, PFNGLGETINTEGER64VPROC);
  TERRAZZO_GL(GetUniformLocation, PFNGLGETUNIFORMLOCATIONPROC);
  TERRAZZO_GL(MemoryBarrier, PFNGLMEMORYBARRIERPROC);
  TERRAZZO_GL(Uniform1f, PFNGLUNIFORM1FPROC);
  TERRAZZO_GL(Uniform1i, PFNGLUNIFORM1IPROC);
  TERRAZZO_GL(Uniform1ui, PFNGLUNIFORM1UIPROC);
  TERRAZZO_GL(Uniform2i, PFNGLUNIFORM2IPROC);
  TERRAZZO_GL(Uniform3i, PFNGLUNIFORM3IPROC);
  TERRAZZO_GL(UseProgram, PFNGLUSEPROGRAMPROC);
#undef TERRAZZO_GL

  void use(GLuint p) { UseProgram(program = p); }
  GLint at(const std::string& name) const { return GetUniformLocation(program, name.c_str()); }
  void set(const std::string& name, int v) const { Uniform1i(at(name), v); }
  void set(const std::string& name, float v) const { Uniform1f(at(name), v); }
  void set(const std::string& name, const Vec3i& v) const { Uniform3i(at(name), v.x(), v.y(), v.z()); }

  void check() const { check_gl(context, "the part", "cut the solid into more blocks, or set device: cpu"); }

  // Runs the program over a box, a few slices per dispatch so that cancelling does not wait for all of them.
  // `go` sets the slices of each dispatch.
  template <class Go>
  void dispatch(const Vec3i& size, const Work& work, Go&& go) const {
    const int batch = software ? 4 : 64;
    for (int z = 0; z < size.z(); z += batch) {
      work.check();
      go(z, std::min(z + batch, size.z()));
      DispatchCompute((size.x() + kGroup - 1) / kGroup, (size.y() + kGroup - 1) / kGroup,
                      std::min(batch, size.z() - z));
      if (software) Finish();
      work.done(z, size.z());
    }
    MemoryBarrier(GL_ALL_BARRIER_BITS);
    check();
  }
  // The same over first … last − 1, for programs with those uniforms.
  void dispatch(const Vec3i& first, const Vec3i& last, const Work& work) const {
    dispatch(last - first, work, [&](int z, int end) {
      set("first", Vec3i(first + Vec3i(0, 0, z)));
      set("last", Vec3i(last.x(), last.y(), first.z() + end));
    });
  }
};

// An array on the device, freed with this object.
struct BlockGl::Buffer {
  const Gl& gl;
  GLuint name = 0;
  std::size_t bytes = 0;

  explicit Buffer(const Gl& g) : gl(g) { gl.GenBuffers(1, &name); }
  Buffer(Buffer&& o) noexcept : gl(o.gl), name(std::exchange(o.name, 0)), bytes(o.bytes) {}
  Buffer& operator=(Buffer&&) = delete;
  ~Buffer() {
    if (name) gl.DeleteBuffers(1, &name);
  }
  // Throws Error "too-large-for-gl".
  void resize(std::size_t n, const void* data = nullptr) {
    GLint64 most = 0;
    gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
    most = std::min<GLint64>(most, std::numeric_limits<std::int32_t>::max());
    if (static_cast<GLint64>(n) > most)
      throw Error("too-large-for-gl",
                  fmt::format("a buffer needs {} MB, more than the limit of {} MB on {}", n / 1000000,
                              most / 1000000, gl.context.renderer()),
                  "cut the solid into more blocks, or set device: cpu")
          .parameter("device");
    bytes = n;
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, name);
    gl.BufferData(GL_SHADER_STORAGE_BUFFER, n, data, GL_DYNAMIC_COPY);
    gl.check();
  }
  template <class Vector>
  void fill(const Vector& v) {
    resize(v.size() * sizeof(v[0]), v.data());
  }
  template <class T>
  void write(std::size_t at, const std::vector<T>& v) const {
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, name);
    gl.BufferSubData(GL_SHADER_STORAGE_BUFFER, at, v.size() * sizeof(T), v.data());
  }
  template <class T>
  void read(std::size_t at, std::vector<T>& v) const {
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, name);
    gl.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, at, v.size() * sizeof(T), v.data());
  }
  void bind(unsigned to) const { gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, to, name); }
  void copy(std::size_t from, const Buffer& to, std::size_t at, std::size_t n) const {
    gl.BindBuffer(GL_COPY_READ_BUFFER, name);
    gl.BindBuffer(GL_COPY_WRITE_BUFFER, to.name);
    gl.CopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, from, at, n);
  }
};

// All tables of the three lines in one buffer, and where each begins.
struct BlockGl::LineTables {
  std::vector<int> numbers;
  std::array<int, 3> starts{}, covers{}, voxels{}, patches{};

  explicit LineTables(const TorusLines& lines) {
    for (std::size_t a = 0; a < 3; ++a) {
      const TorusLine& l = lines[a];
      const auto here = [&] { return count_of(numbers); };
      starts[a] = here();
      numbers.insert(numbers.end(), l.start.begin(), l.start.end());
      covers[a] = here();
      for (const PatchCover& c : l.cover) {
        numbers.push_back(c.patch[0]);
        numbers.push_back(c.count);
      }
      voxels[a] = here();
      for (int k = 0; k < l.to - l.from; ++k) numbers.push_back(l.original_voxel(k));
      patches[a] = here();
      for (int k = 0; k < l.patches(); ++k) numbers.push_back(l.original_patch(k));
    }
  }
};

// The search's tables for one exemplar.
struct BlockGl::ExemplarBuffers {
  Buffer features, similar, model;
  int bias_at, penalty_at;

  ExemplarBuffers(const Gl& gl, const ExemplarLevel& e, const std::vector<float>& penalty)
      : features(gl), similar(gl), model(gl) {
    features.fill(e.features);
    similar.fill(e.similar);
    std::vector<float> m(e.space.basis.begin(), e.space.basis.end());
    bias_at = m.size();
    for (const float b : e.space.bias) m.push_back(-b);
    penalty_at = m.size();
    for (std::size_t i = 0; i < penalty.size(); ++i) m.push_back(e.usable[i] ? penalty[i] : 0.0f);
    model.fill(m);
  }
};

}  // namespace terrazzo::solids
