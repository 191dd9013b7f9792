#include "nodes/sizes/kmatrix/stencil_slicer.h"

#include <GL/glcorearb.h>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/gl/gl_program.h"

namespace terrazzo::kmatrix {
namespace {

struct Instance {
  float rotation[4], depth;
};

}  // namespace

// OpenGL functions and objects. All are released with the context.
struct StencilSlicer::Gl {
  EglContext context;
  GLuint program = 0, instances = 0;
  GLsizei indices = 0;

  explicit Gl(GlDevice device) : context(device) {}
#define TERRAZZO_GL(name, type) type name = context.function<type>("gl" #name)
  TERRAZZO_GL(BindBuffer, PFNGLBINDBUFFERPROC);
  TERRAZZO_GL(BindFramebuffer, PFNGLBINDFRAMEBUFFERPROC);
  TERRAZZO_GL(BindRenderbuffer, PFNGLBINDRENDERBUFFERPROC);
  TERRAZZO_GL(BindVertexArray, PFNGLBINDVERTEXARRAYPROC);
  TERRAZZO_GL(BufferData, PFNGLBUFFERDATAPROC);
  TERRAZZO_GL(CheckFramebufferStatus, PFNGLCHECKFRAMEBUFFERSTATUSPROC);
  TERRAZZO_GL(Clear, PFNGLCLEARPROC);
  TERRAZZO_GL(DrawBuffer, PFNGLDRAWBUFFERPROC);
  TERRAZZO_GL(DrawElementsInstanced, PFNGLDRAWELEMENTSINSTANCEDPROC);
  TERRAZZO_GL(Enable, PFNGLENABLEPROC);
  TERRAZZO_GL(EnableVertexAttribArray, PFNGLENABLEVERTEXATTRIBARRAYPROC);
  TERRAZZO_GL(FramebufferRenderbuffer, PFNGLFRAMEBUFFERRENDERBUFFERPROC);
  TERRAZZO_GL(GenBuffers, PFNGLGENBUFFERSPROC);
  TERRAZZO_GL(GenFramebuffers, PFNGLGENFRAMEBUFFERSPROC);
  TERRAZZO_GL(GenRenderbuffers, PFNGLGENRENDERBUFFERSPROC);
  TERRAZZO_GL(GenVertexArrays, PFNGLGENVERTEXARRAYSPROC);
  TERRAZZO_GL(GetError, PFNGLGETERRORPROC);
  TERRAZZO_GL(GetUniformLocation, PFNGLGETUNIFORMLOCATIONPROC);
  TERRAZZO_GL(PixelStorei, PFNGLPIXELSTOREIPROC);
  TERRAZZO_GL(ReadBuffer, PFNGLREADBUFFERPROC);
  TERRAZZO_GL(ReadPixels, PFNGLREADPIXELSPROC);
  TERRAZZO_GL(RenderbufferStorage, PFNGLRENDERBUFFERSTORAGEPROC);
  TERRAZZO_GL(StencilFunc, PFNGLSTENCILFUNCPROC);
  TERRAZZO_GL(StencilOp, PFNGLSTENCILOPPROC);
  TERRAZZO_GL(Uniform1f, PFNGLUNIFORM1FPROC);
  TERRAZZO_GL(Uniform1i, PFNGLUNIFORM1IPROC);
  TERRAZZO_GL(UseProgram, PFNGLUSEPROGRAMPROC);
  TERRAZZO_GL(VertexAttribDivisor, PFNGLVERTEXATTRIBDIVISORPROC);
  TERRAZZO_GL(VertexAttribPointer, PFNGLVERTEXATTRIBPOINTERPROC);
  TERRAZZO_GL(Viewport, PFNGLVIEWPORTPROC);
#undef TERRAZZO_GL
};

StencilSlicer::StencilSlicer(const Mesh& mesh, GlDevice device)
    : gl_(std::make_unique<Gl>(device)), stencil_(static_cast<std::size_t>(kSlices) * kTile * kTile) {
  Gl& gl = *gl_;
  gl.program = make_gl_program(gl.context, "stencil_slice.vert", "stencil_slice.frag",
                               "use method: slice, or a newer driver");
  gl.UseProgram(gl.program);
  // Two pixels of margin on each side, so that no body reaches into the next tile.
  const double radius = mesh_bounding_radius(mesh) * kTile / (kTile - 4);
  pixel_area_ = 4 * radius * radius / (static_cast<double>(kTile) * kTile);
  gl.Uniform1f(gl.GetUniformLocation(gl.program, "radius"), static_cast<float>(radius));
  gl.Uniform1i(gl.GetUniformLocation(gl.program, "columns"), kColumns);

  GLuint array = 0, buffers[3] = {}, frame = 0, stencil = 0;
  gl.GenVertexArrays(1, &array);
  gl.BindVertexArray(array);
  gl.GenBuffers(3, buffers);
  std::vector<float> positions;
  for (const Vec3& v : mesh.vertices)
    for (int k = 0; k < 3; ++k) positions.push_back(v[k]);
  gl.BindBuffer(GL_ARRAY_BUFFER, buffers[0]);
  gl.BufferData(GL_ARRAY_BUFFER, positions.size() * sizeof(float), positions.data(), GL_STATIC_DRAW);
  gl.EnableVertexAttribArray(0);
  gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  gl.indices = 3 * mesh.triangles.size();
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, mesh.triangles.size() * sizeof(Triangle), mesh.triangles.data(),
                GL_STATIC_DRAW);
  gl.instances = buffers[2];
  gl.BindBuffer(GL_ARRAY_BUFFER, gl.instances);
  for (const GLuint at : {1u, 2u}) {
    gl.EnableVertexAttribArray(at);
    gl.VertexAttribPointer(
        at, at == 1 ? 4 : 1, GL_FLOAT, GL_FALSE, sizeof(Instance),
        reinterpret_cast<const void*>(at == 1 ? offsetof(Instance, rotation) : offsetof(Instance, depth)));
    gl.VertexAttribDivisor(at, 1);
  }

  const GLsizei side = kColumns * kTile;
  gl.GenRenderbuffers(1, &stencil);
  gl.BindRenderbuffer(GL_RENDERBUFFER, stencil);
  gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, side, side);
  gl.GenFramebuffers(1, &frame);
  gl.BindFramebuffer(GL_FRAMEBUFFER, frame);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, stencil);
  gl.DrawBuffer(GL_NONE);
  gl.ReadBuffer(GL_NONE);
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw Error("no-gl", "the driver " + gl.context.renderer() + " cannot render to a stencil buffer",
                "use method: slice");
  gl.Viewport(0, 0, side, side);
  gl.Enable(GL_STENCIL_TEST);
  gl.StencilFunc(GL_ALWAYS, 0, 0xff);
  gl.StencilOp(GL_INVERT, GL_INVERT, GL_INVERT);  // only the parity is needed
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
}

StencilSlicer::~StencilSlicer() = default;

const std::string& StencilSlicer::renderer() const { return gl_->context.renderer(); }

void StencilSlicer::draw(const std::vector<SlicePlane>& planes) {
  Gl& gl = *gl_;
  std::vector<Instance> instances;
  for (const SlicePlane& p : planes)
    instances.push_back({{static_cast<float>(p.rotation.x()), static_cast<float>(p.rotation.y()),
                          static_cast<float>(p.rotation.z()), static_cast<float>(p.rotation.w())},
                         static_cast<float>(p.depth)});
  gl.BindBuffer(GL_ARRAY_BUFFER, gl.instances);
  gl.BufferData(GL_ARRAY_BUFFER, instances.size() * sizeof(Instance), instances.data(), GL_STREAM_DRAW);
  gl.Clear(GL_STENCIL_BUFFER_BIT);
  gl.DrawElementsInstanced(GL_TRIANGLES, gl.indices, GL_UNSIGNED_INT, nullptr, instances.size());
  const GLsizei side = kColumns * kTile;
  gl.ReadPixels(0, 0, side, side, GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, stencil_.data());
  if (const GLenum code = gl.GetError(); code != GL_NO_ERROR)
    throw Error("no-gl",
                "the driver " + gl.context.renderer() + " failed with OpenGL error " + std::to_string(code),
                "use method: slice");
}

const std::uint8_t* StencilSlicer::row(int slice, int y) const {
  const std::size_t line = static_cast<std::size_t>(slice / kColumns) * kTile + y;
  return stencil_.data() + (line * kColumns + (slice % kColumns)) * kTile;
}

}  // namespace terrazzo::kmatrix
