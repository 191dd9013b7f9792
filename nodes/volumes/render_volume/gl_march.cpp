#include "nodes/volumes/render_volume/gl_march.h"

#include <array>
#include <cmath>

#include "nodes/common/gl/gl_compute.h"
#include "nodes/data/indices.h"

namespace terrazzo::render_volume {
namespace {

constexpr int kTextures = 12;  // as in the shader

using GroupCounts = std::array<std::uint32_t, 4>;  // rays, samples, pieces, lookups of a work group

// Work groups along an edge of the picture.
int groups(int pixels) { return (pixels + GlCompute::kGroup - 1) / GlCompute::kGroup; }

}  // namespace

// The context, the scene's textures and the picture; all are released with the context.
struct GlMarcher::Gl : GlCompute {
  int units = 0;  // texture units in use
  int rows = 0;   // of the picture that the buffers hold, whole work groups
  GlBuffer colors, counts;

  explicit Gl(GlDevice device)
      : GlCompute(device, {"the scene", "set device: cpu", "set device: cpu"}),
        colors(*this),
        counts(*this) {}
#define TERRAZZO_GL(name, type) type name = context.function<type>("gl" #name)
  TERRAZZO_GL(ActiveTexture, PFNGLACTIVETEXTUREPROC);
  TERRAZZO_GL(BindTexture, PFNGLBINDTEXTUREPROC);
  TERRAZZO_GL(GenTextures, PFNGLGENTEXTURESPROC);
  TERRAZZO_GL(GetIntegerv, PFNGLGETINTEGERVPROC);
  TERRAZZO_GL(PixelStorei, PFNGLPIXELSTOREIPROC);
  TERRAZZO_GL(TexImage3D, PFNGLTEXIMAGE3DPROC);
  TERRAZZO_GL(TexParameteri, PFNGLTEXPARAMETERIPROC);
  TERRAZZO_GL(UniformMatrix3fv, PFNGLUNIFORMMATRIX3FVPROC);
#undef TERRAZZO_GL

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
};

GlMarcher::GlMarcher(const Scene& scene, const Bricks& bricks, GlDevice device)
    : scene_(scene), gl_(std::make_unique<Gl>(device)) {
  Gl& gl = *gl_;
  if (scene.textures.size() > kTextures)
    throw Error("too-large-for-gl",
                fmt::format("{} textures exceed the shader's limit of {}", scene.textures.size(), kTextures),
                "set device: cpu")
        .parameter("device");
  gl.use(make_gl_program(gl.context, "march_volume.comp", "set device: cpu, or install a newer driver"));
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);

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

  const Look& look = scene.look;
  constexpr int kGroup = GlCompute::kGroup;
  const double group_bytes = static_cast<double>(look.width) * kGroup * sizeof(Vec3f);
  const int fitting = static_cast<int>(std::min(1e6, static_cast<double>(gl.largest_buffer()) / group_bytes));
  gl.rows = std::clamp(fitting, 1, groups(look.height)) * kGroup;
  gl.colors.resize(pixels_in(look.width, gl.rows) * sizeof(Vec3f));
  gl.counts.resize(pixels_in(groups(look.width), groups(gl.rows)) * sizeof(GroupCounts));
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

// Draws the rows from `top` that the buffers hold. In bands, so that cancelling does not wait for all of
// them, and no driver takes the device for hung.
void GlMarcher::draw_rows(int top, const Work& work) {
  Gl& gl = *gl_;
  const int width = scene_.look.width, height = scene_.look.height, end = std::min(top + gl.rows, height);
  constexpr double kSoftwareRows = 32, kRays = 1 << 22;
  const double rays_per_row = static_cast<double>(width) * scene_.look.samples * scene_.look.samples;
  const double rows = gl.software ? kSoftwareRows : std::clamp(kRays / rays_per_row, 1.0, 1.0 * gl.rows);
  const int band = groups(static_cast<int>(rows)) * GlCompute::kGroup;
  gl.colors.bind(0);
  gl.counts.bind(1);
  gl.set("top", top);
  for (int y = top; y < end; y += band) {
    work.check();
    gl.set("first", Vec3i(0, y, 0));
    gl.set("last", Vec3i(width, std::min(y + band, end), 1));
    gl.DispatchCompute(groups(width), groups(std::min(band, end - y)), 1);
    gl.Finish();
    work.done(y, height);
  }
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl.check();
}

void GlMarcher::draw(const Frame& f, const Work& work) {
  set(f);
  for (int top = 0; top < scene_.look.height; top += gl_->rows) draw_rows(top, work);
}

std::vector<Vec3f> GlMarcher::march(const Frame& f, FrameCounts& counts, const Work& work) {
  set(f);
  const int width = scene_.look.width, height = scene_.look.height;
  std::vector<Vec3f> picture(pixels_in(width, height));
  for (int top = 0; top < height; top += gl_->rows) {
    draw_rows(top, work);
    const int rows = std::min(gl_->rows, height - top);
    gl_->read(gl_->colors.name, 0, pixels_in(width, rows) * sizeof(Vec3f), &picture[pixel_at(0, top, width)]);
    std::vector<GroupCounts> counted(pixels_in(groups(width), groups(rows)));
    gl_->counts.read(0, counted);
    for (const auto& [rays, samples, pieces, lookups] : counted)
      counts += FrameCounts{rays, samples, pieces, lookups};
  }
  gl_->check();
  return picture;
}

}  // namespace terrazzo::render_volume
