// Compute shaders and their arrays on the device.
#pragma once

#include <GL/glcorearb.h>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "graph/diagnostic.h"
#include "nodes/common/gl/gl_program.h"
#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo {

// A context with the functions that compute shaders need. All objects are released with it.
struct GlCompute {
  static constexpr int kGroup = 8;  // work group size along x and y, as in the shaders

  EglContext context;
  bool software;
  // For messages.
  struct Words {
    const char* what;       // the data on the device
    const char* smaller;    // what to do if it does not fit
    const char* otherwise;  // how to do without the device
  };
  Words words;
  GLuint program = 0;

  GlCompute(GlDevice device, const Words& w) : context(device), software(device == GlDevice::Cpu), words(w) {}
#define TERRAZZO_GL(name, type) type name = context.function<type>("gl" #name)
  TERRAZZO_GL(BindBuffer, PFNGLBINDBUFFERPROC);
  TERRAZZO_GL(BindBufferBase, PFNGLBINDBUFFERBASEPROC);
  TERRAZZO_GL(BufferData, PFNGLBUFFERDATAPROC);
  TERRAZZO_GL(BufferStorage, PFNGLBUFFERSTORAGEPROC);
  TERRAZZO_GL(BufferSubData, PFNGLBUFFERSUBDATAPROC);
  TERRAZZO_GL(ClearBufferData, PFNGLCLEARBUFFERDATAPROC);
  TERRAZZO_GL(CopyBufferSubData, PFNGLCOPYBUFFERSUBDATAPROC);
  TERRAZZO_GL(DeleteBuffers, PFNGLDELETEBUFFERSPROC);
  TERRAZZO_GL(DispatchCompute, PFNGLDISPATCHCOMPUTEPROC);
  TERRAZZO_GL(Finish, PFNGLFINISHPROC);
  TERRAZZO_GL(GenBuffers, PFNGLGENBUFFERSPROC);
  TERRAZZO_GL(GetInteger64v, PFNGLGETINTEGER64VPROC);
  TERRAZZO_GL(GetUniformLocation, PFNGLGETUNIFORMLOCATIONPROC);
  TERRAZZO_GL(MapBufferRange, PFNGLMAPBUFFERRANGEPROC);
  TERRAZZO_GL(MemoryBarrier, PFNGLMEMORYBARRIERPROC);
  TERRAZZO_GL(Uniform1f, PFNGLUNIFORM1FPROC);
  TERRAZZO_GL(Uniform1i, PFNGLUNIFORM1IPROC);
  TERRAZZO_GL(Uniform1ui, PFNGLUNIFORM1UIPROC);
  TERRAZZO_GL(Uniform2f, PFNGLUNIFORM2FPROC);
  TERRAZZO_GL(Uniform2i, PFNGLUNIFORM2IPROC);
  TERRAZZO_GL(Uniform3fv, PFNGLUNIFORM3FVPROC);
  TERRAZZO_GL(Uniform3i, PFNGLUNIFORM3IPROC);
  TERRAZZO_GL(UseProgram, PFNGLUSEPROGRAMPROC);
#undef TERRAZZO_GL

  void use(GLuint p) { UseProgram(program = p); }
  GLint at(const std::string& name) const { return GetUniformLocation(program, name.c_str()); }
  void set(const std::string& name, int v) const { Uniform1i(at(name), v); }
  void set(const std::string& name, float v) const { Uniform1f(at(name), v); }
  void set(const std::string& name, const Vec3i& v) const { Uniform3i(at(name), v.x(), v.y(), v.z()); }
  void set(const std::string& name, const Vec3f& v) const { Uniform3fv(at(name), 1, v.data()); }

  void check() const { check_gl(context, words.what, words.smaller, words.otherwise); }

  GLint64 largest_buffer() const {
    GLint64 most = 0;
    GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
    return std::min<GLint64>(most, std::numeric_limits<std::int32_t>::max());
  }

  // Copies part of a buffer to memory.
  void read(GLuint buffer, std::size_t from, std::size_t bytes, void* to);

  // Runs the program over a box, a few slices per dispatch so that cancelling does not wait for all of them.
  // `go` sets the slices of each dispatch; `group` is the program's work group size along x and y.
  template <class Go>
  void dispatch(const Vec3i& size, const Work& work, Go&& go, int group = kGroup) const {
    const int batch = software ? 4 : 64;
    for (int z = 0; z < size.z(); z += batch) {
      work.check();
      go(z, std::min(z + batch, size.z()));
      DispatchCompute((size.x() + group - 1) / group, (size.y() + group - 1) / group,
                      std::min(batch, size.z() - z));
      Finish();
      work.done(z, size.z());
    }
    MemoryBarrier(GL_ALL_BARRIER_BITS);
    check();
  }
  // The same over first … last − 1, for programs with those uniforms.
  void dispatch(const Vec3i& first, const Vec3i& last, const Work& work, int group = kGroup) const {
    const auto go = [&](int z, int end) {
      set("first", Vec3i(first + Vec3i(0, 0, z)));
      set("last", Vec3i(last.x(), last.y(), first.z() + end));
    };
    dispatch(last - first, work, go, group);
  }

 private:
  void stage(std::size_t bytes);

  GLuint staging_ = 0;
  std::size_t staging_bytes_ = 0;
  const char* staged_ = nullptr;
};

// An array on the device, freed with this object.
struct GlBuffer {
  GlCompute& gl;
  GLuint name = 0;
  std::size_t bytes = 0;

  explicit GlBuffer(GlCompute& g) : gl(g) { gl.GenBuffers(1, &name); }
  GlBuffer(GlBuffer&& o) noexcept : gl(o.gl), name(std::exchange(o.name, 0)), bytes(o.bytes) {}
  GlBuffer& operator=(GlBuffer&&) = delete;
  ~GlBuffer() {
    if (name) gl.DeleteBuffers(1, &name);
  }
  // Throws Error "too-large-for-gl".
  void resize(std::size_t n, const void* data = nullptr) {
    const GLint64 most = gl.largest_buffer();
    if (static_cast<GLint64>(n) > most)
      throw Error("too-large-for-gl",
                  fmt::format("{}: a buffer needs {} MB, more than the limit of {} MB on {}", gl.words.what,
                              n / 1000000, most / 1000000, gl.context.renderer()),
                  gl.words.smaller)
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
  void clear() const {
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, name);
    const GLuint zero = 0;
    gl.ClearBufferData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
  }
  template <class T>
  void write(std::size_t at, const std::vector<T>& v) const {
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, name);
    gl.BufferSubData(GL_SHADER_STORAGE_BUFFER, at, v.size() * sizeof(T), v.data());
  }
  template <class T>
  void read(std::size_t at, std::vector<T>& v) const {
    gl.read(name, at, v.size() * sizeof(T), v.data());
  }
  void bind(unsigned to) const { gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, to, name); }
  void copy(std::size_t from, const GlBuffer& to, std::size_t at, std::size_t n) const {
    gl.BindBuffer(GL_COPY_READ_BUFFER, name);
    gl.BindBuffer(GL_COPY_WRITE_BUFFER, to.name);
    gl.CopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, from, at, n);
  }
};

}  // namespace terrazzo
