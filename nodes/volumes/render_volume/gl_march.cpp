#include "nodes/volumes/render_volume/gl_march.h"

#include <GL/glcorearb.h>
#include <fmt/format.h>

#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/gl/gl_program.h"
#include "nodes/data/indices.h"

namespace terrazzo::render_volume {
namespace {

constexpr int kTextures = 12;  // as in the shader

}  // namespace

// Functions by name, and the objects; all are released with the context.
struct GlMarcher::Gl {
  EglContext context;
  GLuint program = 0;
  int units = 0;  // texture units in use
  bool software;

  explicit Gl(GlDevice device) : context(device), software(device == GlDevice::Cpu) {}
#define TERRAZZO_GL(name, type) type name = context.function<type>("gl" #name)
  TERRAZZO_GL(ActiveTexture, PFNGLACTIVETEXTUREPROC);
  TERRAZZO_GL(BindFramebuffer, PFNGLBINDFRAMEBUFFERPROC);
  TERRAZZO_GL(BindRenderbuffer, PFNGLBINDRENDERBUFFERPROC);
  TERRAZZO_GL(BindTexture, PFNGLBINDTEXTUREPROC);
  TERRAZZO_GL(BindVertexArray, PFNGLBINDVERTEXARRAYPROC);
  TERRAZZO_GL(CheckFramebufferStatus, PFNGLCHECKFRAMEBUFFERSTATUSPROC);
  TERRAZZO_GL(DrawArrays, PFNGLDRAWARRAYSPROC);
  TERRAZZO_GL(DrawBuffers, PFNGLDRAWBUFFERSPROC);
  TERRAZZO_GL(Enable, PFNGLENABLEPROC);
  TERRAZZO_GL(Finish, PFNGLFINISHPROC);
  TERRAZZO_GL(FramebufferRenderbuffer, PFNGLFRAMEBUFFERRENDERBUFFERPROC);
  TERRAZZO_GL(GenFramebuffers, PFNGLGENFRAMEBUFFERSPROC);
  TERRAZZO_GL(GenRenderbuffers, PFNGLGENRENDERBUFFERSPROC);
  TERRAZZO_GL(GenTextures, PFNGLGENTEXTURESPROC);
  TERRAZZO_GL(GenVertexArrays, PFNGLGENVERTEXARRAYSPROC);
  TERRAZZO_GL(GetIntegerv, PFNGLGETINTEGERVPROC);
  TERRAZZO_GL(GetUniformLocation, PFNGLGETUNIFORMLOCATIONPROC);
  TERRAZZO_GL(PixelStorei, PFNGLPIXELSTOREIPROC);
  TERRAZZO_GL(ReadBuffer, PFNGLREADBUFFERPROC);
  TERRAZZO_GL(ReadPixels, PFNGLREADPIXELSPROC);
  TERRAZZO_GL(RenderbufferStorage, PFNGLRENDERBUFFERSTORAGEPROC);
  TERRAZZO_GL(Scissor, PFNGLSCISSORPROC);
  TERRAZZO_GL(TexImage3D, PFNGLTEXIMAGE3DPROC);
  TERRAZZO_GL(TexParameteri, PFNGLTEXPARAMETERIPROC);
  TERRAZZO_GL(Uniform1f, PFNGLUNIFORM1FPROC);
  TERRAZZO_GL(Uniform1i, PFNGLUNIFORM1IPROC);
  TERRAZZO_GL(Uniform1ui, PFNGLUNIFORM1UIPROC);
  TERRAZZO_GL(Uniform2f, PFNGLUNIFORM2FPROC);
  TERRAZZO_GL(Uniform2i, PFNGLUNIFORM2IPROC);
  TERRAZZO_GL(Uniform3fv, PFNGLUNIFORM3FVPROC);
  TERRAZZO_GL(UniformMatrix3fv, PFNGLUNIFORMMATRIX3FVPROC);
  TERRAZZO_GL(UseProgram, PFNGLUSEPROGRAMPROC);
  TERRAZZO_GL(Viewport, PFNGLVIEWPORTPROC);
#undef TERRAZZO_GL

  GLint at(const std::string& name) const { return GetUniformLocation(program, name.c_str()); }
  void set(const std::string& name, float v) const { Uniform1f(at(name), v); }
  void set(const std::string& name, int v) const { Uniform1i(at(name), v); }
  void set(const std::string& name, const Vec3f& v) const { Uniform3fv(at(name), 1, v.data()); }

  // Creates a 3D texture on the next unit and binds it to the sampler `name`.
  void start_texture(const std::string& name, GLint filter, GLint small_filter, GLint wrap, int levels) {
    GLuint texture = 0;
    GenTextures(1, &texture);
    ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(units));
    BindTexture(GL_TEXTURE_3D, texture);
    TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, filter);
    TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, small_filter);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
      TexParameteri(GL_TEXTURE_3D, axis, wrap);
    TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAX_LEVEL, levels - 1);
    set(name, units++);
  }
  void level(int index, GLint stored, const Vec3i& size, GLenum format, GLenum type, const void* data) const {
    GLint most = 0;
    GetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &most);
    if (size.maxCoeff() > most)
      throw Error("too-large-for-gl",
                  fmt::format("{} voxels along an edge exceed the limit of {} on {}", size.maxCoeff(), most,
                              context.renderer()),
                  "set device: cpu")
          .parameter("device");
    TexImage3D(GL_TEXTURE_3D, index, stored, size.x(), size.y(), size.z(), 0, format, type, data);
  }
  void check() const { check_gl(context, "the scene", "set device: cpu"); }
};

GlMarcher::GlMarcher(const Scene& scene, const Bricks& bricks, GlDevice device)
    : scene_(scene), gl_(std::make_unique<Gl>(device)) {
  Gl& gl = *gl_;
  if (scene.textures.size() > kTextures)
    throw Error("too-large-for-gl",
                fmt::format("{} textures exceed the shader's limit of {}", scene.textures.size(), kTextures),
                "set device: cpu")
        .parameter("device");
  gl.program = make_gl_program(gl.context, "march_volume.vert", "march_volume.frag",
                               "set device: cpu, or install a newer driver");
  gl.UseProgram(gl.program);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);

  gl.start_texture("scan", GL_LINEAR, GL_LINEAR, GL_CLAMP_TO_EDGE, 1);
  gl.level(0, GL_R16, scene.scan.size, GL_RED, GL_UNSIGNED_SHORT, scene.scan.voxels.data());
  gl.start_texture("bricks", GL_NEAREST, GL_NEAREST, GL_CLAMP_TO_EDGE, 1);
  std::vector<std::uint8_t> distances = bricks.distances();
  if (!scene.look.skip_empty) std::fill(distances.begin(), distances.end(), std::uint8_t{0});
  gl.level(0, GL_R8UI, bricks.count(), GL_RED_INTEGER, GL_UNSIGNED_BYTE, distances.data());
  for (std::size_t i = 0; i < kTextures; ++i) {
    const std::string name = fmt::format("textures[{}]", i);
    if (i >= scene.textures.size()) {  // never read, but samplers of different types may not share a unit
      gl.set(name, 0);
      continue;
    }
    const auto& levels = scene.textures[i].levels;
    gl.start_texture(name, GL_LINEAR, GL_LINEAR_MIPMAP_NEAREST, GL_REPEAT, levels.size());
    for (std::size_t l = 0; l < levels.size(); ++l)
      gl.level(l, GL_RGBA16, levels[l].size, GL_RGBA, GL_UNSIGNED_SHORT, levels[l].texels.data());
  }
  gl.check();

  GLuint frame = 0, array = 0, buffers[2] = {};
  gl.GenVertexArrays(1, &array);
  gl.BindVertexArray(array);
  gl.GenFramebuffers(1, &frame);
  gl.BindFramebuffer(GL_FRAMEBUFFER, frame);
  gl.GenRenderbuffers(2, buffers);
  for (unsigned i = 0; i < 2; ++i) {
    gl.BindRenderbuffer(GL_RENDERBUFFER, buffers[i]);
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA32F, scene.look.width, scene.look.height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0 + i, GL_RENDERBUFFER, buffers[i]);
  }
  const GLenum both[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  gl.DrawBuffers(2, both);
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw Error("no-gl",
                fmt::format("the driver {} cannot render to a picture of {} × {} floats",
                            gl.context.renderer(), scene.look.width, scene.look.height),
                "set device: cpu")
        .parameter("device");
  gl.Viewport(0, 0, scene.look.width, scene.look.height);
  gl.Enable(GL_SCISSOR_TEST);

  const Look& look = scene.look;
  gl.Uniform2i(gl.at("picture"), look.width, look.height);
  gl.set("samples", look.samples);
  gl.set("size", Vec3f(scene.scan.size.cast<float>()));
  gl.set("opacity", float(look.opacity));
  gl.set("skin_noise", float(look.skin_noise));
  gl.set("skin_scale", float(look.skin_scale));
  gl.Uniform1ui(gl.at("skin_seed"), look.seed);
  gl.set("background", look.background);
  gl.set("edge_count", count_of(scene.intervals.edges));
  for (std::size_t i = 0; i < scene.intervals.edges.size(); ++i)
    gl.set(fmt::format("edges[{}]", i), scene.scan.stored(scene.intervals.edges[i]));
  for (std::size_t i = 0; i < scene.intervals.tissue.size(); ++i)
    gl.set(fmt::format("tissue_of[{}]", i), scene.intervals.tissue[i]);
  gl.check();
}

GlMarcher::~GlMarcher() = default;

const std::string& GlMarcher::renderer() const { return gl_->context.renderer(); }

void GlMarcher::set(const Frame& f) {
  Gl& gl = *gl_;
  gl.set("camera", f.camera.position);
  gl.set("forward", f.camera.forward);
  gl.set("right", f.camera.right);
  gl.set("up", f.camera.up);
  gl.Uniform2f(gl.at("half_size"), f.camera.half_width, f.camera.half_height);
  gl.set("low", f.low);
  gl.set("high", f.high);
  gl.set("per_mm", f.per_mm);
  gl.set("middle", f.middle);
  gl.set("light", f.light);
  gl.set("ambient", static_cast<float>(scene_.look.ambient));
  gl.set("step_length", f.step);
  gl.set("soft_gradient", f.soft_gradient);
  gl.set("int_scale", f.int_scale);
  gl.set("int_offset", f.int_offset);
  gl.set("reference_step", f.reference_step);
  for (std::size_t i = 0; i < f.tissues.size(); ++i) {
    const TissueLook& t = f.tissues[i];
    gl.set(fmt::format("tissue_color[{}]", i), t.color);
    gl.set(fmt::format("tissue_texture[{}]", i), t.texture);
    gl.set(fmt::format("tissue_noise[{}]", i), int(t.noise));
    gl.set(fmt::format("tissue_fixed[{}]", i), t.by_density ? -1.0f : t.fixed);
    gl.set(fmt::format("tissue_threshold[{}]", i), t.threshold);
    gl.set(fmt::format("tissue_modulation[{}]", i), t.modulation);
    if (t.texture < 0) continue;
    for (int s = 0; s < kScales; ++s) {
      const Placement& p = t.at[s];
      const Vec3f inverse = scene_.textures[t.texture].levels[p.level].size.cast<float>().cwiseInverse();
      const Eigen::Matrix3f linear = inverse.asDiagonal() * p.linear;
      const std::size_t k = i * kScales + s;
      gl.UniformMatrix3fv(gl.at(fmt::format("place_linear[{}]", k)), 1, GL_FALSE, linear.data());
      // Placement counts from a texel's center, GL from its corner.
      gl.set(fmt::format("place_offset[{}]", k),
             Vec3f(inverse.cwiseProduct(p.offset + Vec3f::Constant(0.5f))));
      gl.set(fmt::format("place_level[{}]", k), static_cast<float>(p.level));
      gl.set(fmt::format("place_weight[{}]", k), t.weight[s] * 65535);
    }
  }
}

void GlMarcher::draw(const Frame& f, const Work& work) {
  set(f);
  Gl& gl = *gl_;
  const int width = scene_.look.width, height = scene_.look.height;
  // A software renderer draws in bands, so that cancelling does not wait for a whole picture.
  const int band = gl.software ? 32 : height;
  for (int y = 0; y < height; y += band) {
    work.check();
    gl.Scissor(0, y, width, std::min(band, height - y));
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    if (gl.software) gl.Finish();
    work.done(y, height);
  }
  gl.check();
}

void GlMarcher::finish() { gl_->Finish(); }

std::vector<Vec3f> GlMarcher::march(const Frame& f, FrameCounts& counts, const Work& work) {
  draw(f, work);
  const Gl& gl = *gl_;
  const int width = scene_.look.width, height = scene_.look.height;
  const std::size_t pixels = pixels_in(width, height);
  std::vector<float> read(4 * pixels);
  std::vector<Vec3f> out(pixels);
  gl.ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, read.data());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float* p = &read[4 * (static_cast<std::size_t>(height - 1 - y) * width + x)];
      out[pixel_at(x, y, width)] = Vec3f(p[0], p[1], p[2]);
    }
  gl.ReadBuffer(GL_COLOR_ATTACHMENT1);
  gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, read.data());
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto count = [&](int k) { return static_cast<std::uint64_t>(read[4 * i + k]); };
    counts += FrameCounts{count(0), count(1), count(2), count(3)};
  }
  gl.check();
  return out;
}

}  // namespace terrazzo::render_volume
