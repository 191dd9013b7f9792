#include "nodes/sizes/kmatrix/stencil_slicer.h"

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/gl/gl_compute.h"

namespace terrazzo::kmatrix {
namespace {

constexpr int kSide = StencilSlicer::kColumns * StencilSlicer::kTile;  // of the stencil buffer, pixels
constexpr int kWords = StencilSlicer::kTile / 32;                      // of a tile's row

struct Instance {
  float rotation[4], depth;
};

}  // namespace

// The programs, and the stencil buffer with its packed copy. All are released with the context.
struct StencilSlicer::Gl : GlCompute {
  GLuint slice = 0, pack = 0, instances = 0;
  GLsizei indices = 0;
  GlBuffer bits;

  explicit Gl(GlDevice device)
      : GlCompute(device, {"the stencil buffer", "use method: slice", "use method: slice"}), bits(*this) {}
#define TERRAZZO_GL(name, type) type name = context.function<type>("gl" #name)
  TERRAZZO_GL(BindFramebuffer, PFNGLBINDFRAMEBUFFERPROC);
  TERRAZZO_GL(BindTexture, PFNGLBINDTEXTUREPROC);
  TERRAZZO_GL(BindVertexArray, PFNGLBINDVERTEXARRAYPROC);
  TERRAZZO_GL(CheckFramebufferStatus, PFNGLCHECKFRAMEBUFFERSTATUSPROC);
  TERRAZZO_GL(Clear, PFNGLCLEARPROC);
  TERRAZZO_GL(DrawBuffer, PFNGLDRAWBUFFERPROC);
  TERRAZZO_GL(DrawElementsInstanced, PFNGLDRAWELEMENTSINSTANCEDPROC);
  TERRAZZO_GL(Enable, PFNGLENABLEPROC);
  TERRAZZO_GL(EnableVertexAttribArray, PFNGLENABLEVERTEXATTRIBARRAYPROC);
  TERRAZZO_GL(FramebufferTexture, PFNGLFRAMEBUFFERTEXTUREPROC);
  TERRAZZO_GL(GenFramebuffers, PFNGLGENFRAMEBUFFERSPROC);
  TERRAZZO_GL(GenTextures, PFNGLGENTEXTURESPROC);
  TERRAZZO_GL(GenVertexArrays, PFNGLGENVERTEXARRAYSPROC);
  TERRAZZO_GL(ReadBuffer, PFNGLREADBUFFERPROC);
  TERRAZZO_GL(StencilFunc, PFNGLSTENCILFUNCPROC);
  TERRAZZO_GL(StencilOp, PFNGLSTENCILOPPROC);
  TERRAZZO_GL(TexParameteri, PFNGLTEXPARAMETERIPROC);
  TERRAZZO_GL(TexStorage2D, PFNGLTEXSTORAGE2DPROC);
  TERRAZZO_GL(VertexAttribDivisor, PFNGLVERTEXATTRIBDIVISORPROC);
  TERRAZZO_GL(VertexAttribPointer, PFNGLVERTEXATTRIBPOINTERPROC);
  TERRAZZO_GL(Viewport, PFNGLVIEWPORTPROC);
#undef TERRAZZO_GL
};

StencilSlicer::StencilSlicer(const Mesh& mesh, GlDevice device)
    : gl_(std::make_unique<Gl>(device)), bits_(static_cast<std::size_t>(kSlices) * kTile * kWords) {
  Gl& gl = *gl_;
  constexpr const char* kHint = "use method: slice, or a newer driver";
  gl.pack = make_gl_program(gl.context, "stencil_pack.comp", kHint);
  gl.slice = make_gl_program(gl.context, "stencil_slice.vert", "stencil_slice.frag", kHint);
  gl.use(gl.slice);
  // Two pixels of margin on each side, so that no body reaches into the next tile.
  const double radius = mesh_bounding_radius(mesh) * kTile / (kTile - 4);
  pixel_area_ = 4 * radius * radius / (static_cast<double>(kTile) * kTile);
  gl.set("radius", static_cast<float>(radius));
  gl.set("columns", kColumns);

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

  gl.GenTextures(1, &stencil);
  gl.BindTexture(GL_TEXTURE_2D, stencil);
  gl.TexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH24_STENCIL8, kSide, kSide);
  gl.TexParameteri(GL_TEXTURE_2D, GL_DEPTH_STENCIL_TEXTURE_MODE, GL_STENCIL_INDEX);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.GenFramebuffers(1, &frame);
  gl.BindFramebuffer(GL_FRAMEBUFFER, frame);
  gl.FramebufferTexture(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, stencil, 0);
  gl.DrawBuffer(GL_NONE);
  gl.ReadBuffer(GL_NONE);
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw Error("no-gl", "the driver " + gl.context.renderer() + " cannot render to a stencil buffer",
                "use method: slice");
  gl.Viewport(0, 0, kSide, kSide);
  gl.Enable(GL_STENCIL_TEST);
  gl.StencilFunc(GL_ALWAYS, 0, 0xff);
  gl.StencilOp(GL_INVERT, GL_INVERT, GL_INVERT);  // only the parity is needed
  gl.bits.resize(bits_.size() * sizeof(bits_[0]));
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
  gl.use(gl.slice);
  gl.Clear(GL_STENCIL_BUFFER_BIT);
  gl.DrawElementsInstanced(GL_TRIANGLES, gl.indices, GL_UNSIGNED_INT, nullptr, instances.size());
  // The buffer itself takes eight times as long to read back, and drivers convert it first.
  gl.use(gl.pack);
  gl.bits.bind(0);
  gl.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
  gl.DispatchCompute(kColumns * kWords / GlCompute::kGroup, kSide / GlCompute::kGroup, 1);
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl.bits.read(0, bits_);
  gl.check();
}

const std::uint32_t* StencilSlicer::row(int slice, int y) const {
  const std::size_t line = static_cast<std::size_t>(slice / kColumns) * kTile + y;
  return bits_.data() + (line * kColumns + (slice % kColumns)) * kWords;
}

}  // namespace terrazzo::kmatrix
