#include "nodes/solids/synthesis/blockwise/gl.h"

#include <GL/glcorearb.h>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/common/gl/gl_program.h"
#include "nodes/solids/synthesis/matching/weights.h"

namespace terrazzo::solids {
namespace {

constexpr int kGroup = 8;  // work group size along columns and rows, as in the shaders
constexpr const char* kHint = "set device: cpu, or install a newer driver";

}  // namespace

// Functions by name, and programs; all are released with the context.
struct BlockGl::Gl {
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
      DispatchCompute(static_cast<GLuint>((size.x() + kGroup - 1) / kGroup),
                      static_cast<GLuint>((size.y() + kGroup - 1) / kGroup),
                      static_cast<GLuint>(std::min(batch, size.z() - z)));
      if (software) Finish();
      work.progress(static_cast<double>(z) / size.z());
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

namespace {

// An array on the device, freed with this object.
template <class Gl>
struct Buffer {
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
    gl.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(n), data, GL_DYNAMIC_COPY);
    gl.check();
  }
  template <class Vector>
  void fill(const Vector& v) {
    resize(v.size() * sizeof(v[0]), v.data());
  }
  template <class T>
  void write(std::size_t at, const std::vector<T>& v) const {
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, name);
    gl.BufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(at),
                     static_cast<GLsizeiptr>(v.size() * sizeof(T)), v.data());
  }
  template <class T>
  void read(std::size_t at, std::vector<T>& v) const {
    gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, name);
    gl.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(at),
                        static_cast<GLsizeiptr>(v.size() * sizeof(T)), v.data());
  }
  void bind(unsigned to) const { gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, to, name); }
  void copy(std::size_t from, const Buffer& to, std::size_t at, std::size_t n) const {
    gl.BindBuffer(GL_COPY_READ_BUFFER, name), gl.BindBuffer(GL_COPY_WRITE_BUFFER, to.name);
    gl.CopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(from),
                         static_cast<GLintptr>(at), static_cast<GLsizeiptr>(n));
  }
};

// All tables of the three lines in one buffer, and where each begins.
struct LineTables {
  std::vector<int> numbers;
  std::array<int, 3> starts{}, covers{}, voxels{}, patches{};

  explicit LineTables(const TorusLines& lines) {
    for (std::size_t a = 0; a < 3; ++a) {
      const TorusLine& l = lines[a];
      const auto here = [&] { return static_cast<int>(numbers.size()); };
      starts[a] = here();
      numbers.insert(numbers.end(), l.start.begin(), l.start.end());
      covers[a] = here();
      for (const PatchCover& c : l.cover) numbers.push_back(c.patch[0]), numbers.push_back(c.count);
      voxels[a] = here();
      for (int k = 0; k < l.to - l.from; ++k) numbers.push_back(l.original_voxel(k));
      patches[a] = here();
      for (int k = 0; k < l.patches(); ++k) numbers.push_back(l.original_patch(k));
    }
  }
};

// The search's tables for one exemplar.
template <class Gl>
struct ExemplarBuffers {
  Buffer<Gl> features, similar, model;
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

}  // namespace

BlockGl::BlockGl(GlDevice device) : gl_(std::make_unique<Gl>(device)) {
  gl_->search = make_gl_program(gl_->context, "solid_search.comp", kHint);
  gl_->weigh = make_gl_program(gl_->context, "solid_weigh.comp", kHint);
  gl_->blend = make_gl_program(gl_->context, "solid_blend.comp", kHint);
  gl_->map = make_gl_program(gl_->context, "solid_map.comp", kHint);
  gl_->copy = make_gl_program(gl_->context, "solid_copy.comp", kHint);
}

BlockGl::~BlockGl() = default;

const std::string& BlockGl::renderer() const { return gl_->context.renderer(); }

void BlockGl::run(const BlockPasses& passes, bool to_blend, BlockProbe* probe, BlockRegion& region,
                  const Work& work) {
  Gl& gl = *gl_;
  const TorusLines& lines = region.lines;
  const Vec3i stored = region.field.size;
  const std::size_t channels = region.field.channel.size(), voxels = region.field.channel[0].size();
  const LineTables tables(lines);
  using Buffer = Buffer<Gl>;
  Buffer field(gl), matches(gl), next(gl), weight(gl), numbers(gl), texels(gl), maps(gl), table(gl);
  numbers.fill(tables.numbers);
  table.fill(WeightTable(passes.power).entries());
  field.resize(channels * voxels * sizeof(float));

  std::vector<ExemplarBuffers<Gl>> exemplars;
  std::vector<int> first_texel;
  {
    std::vector<float> all;
    for (std::size_t e = 0; e < passes.exemplars.size(); ++e) {
      exemplars.emplace_back(gl, *passes.exemplars[e], passes.statistics.penalty[e]);
      first_texel.push_back(static_cast<int>(all.size() / 4));
      all.insert(all.end(), passes.exemplars[e]->texels.begin(), passes.exemplars[e]->texels.end());
    }
    texels.fill(all);
  }
  std::vector<std::size_t> first_match;
  std::size_t all = 0, most = 0;
  for (const NeighborField& f : region.families) {
    first_match.push_back(all);
    all += f.at.size();
    most = std::max(most, f.at.size());
  }
  matches.resize(all * sizeof(std::uint32_t)), weight.resize(all * sizeof(float));
  next.resize(most * sizeof(std::uint32_t));
  for (std::size_t k = 0; k < region.families.size(); ++k) {
    const NeighborField& f = region.families[k];
    matches.write(first_match[k] * sizeof(std::uint32_t), f.at);
    weight.write(first_match[k] * sizeof(float), f.weight);
  }

  const bool closed = lines[0].closed || lines[1].closed || lines[2].closed;
  const auto copy_beyond = [&](const Buffer& what, std::size_t first, const Vec3i& size, const Vec3i& at) {
    if (!closed) return;
    gl.use(gl.copy);
    what.bind(0), numbers.bind(4);
    gl.set("size", size), gl.set("originals_at", at), gl.set("first_number", static_cast<int>(first));
    gl.dispatch(size, work.quiet(), [&](int z, int) { gl.set("first_slice", z); });
  };

  const auto blend = [&](std::size_t i, const Work& step) {
    const TorusBox& box = passes.plan.blend[i];
    gl.use(gl.blend);
    field.bind(0), matches.bind(1), weight.bind(3), numbers.bind(4), texels.bind(5);
    gl.set("channels", static_cast<int>(channels)), gl.set("voxels", static_cast<int>(voxels));
    gl.set("families", static_cast<int>(region.families.size()));
    gl.set("size", stored), gl.set("window", passes.windows[i]);
    for (std::size_t k = 0; k < region.families.size(); ++k) {
      const NeighborField& f = region.families[k];
      const std::size_t axis = f.axis;
      const auto put = [&](const char* name, int v) { gl.set(fmt::format("{}[{}]", name, k), v); };
      put("axis_u", kSliceColumns[axis]), put("axis_v", kSliceRows[axis]), put("axis_s", f.axis);
      put("first_match", static_cast<int>(first_match[k]));
      put("columns", f.columns), put("rows", f.rows);
      put("first_texel", first_texel[f.exemplar]);
      put("exemplar_width", passes.exemplars[f.exemplar]->width);
    }
    Vec3i first, last;
    for (std::size_t a = 0; a < 3; ++a) {
      const Eigen::Index k = a;
      gl.set(fmt::format("starts_at[{}]", a), tables.starts[a]);
      gl.set(fmt::format("covers_at[{}]", a), tables.covers[a]);
      gl.set(fmt::format("from[{}]", a), lines[a].from);
      first[k] = box.lo[k] - lines[a].from;
      last[k] = box.hi[k] - lines[a].from;
    }
    gl.dispatch(first, last, step);
    if (probe) {
      for (std::size_t c = 0; c < channels; ++c)
        field.read(c * voxels * sizeof(float), region.field.channel[c]);
      measure_values(*probe, region, work.quiet());
    }
    std::vector<Remap::Bin> bins;
    for (const ValueMap& m : passes.statistics.values[i])
      bins.insert(bins.end(), m.map().bins().begin(), m.map().bins().end());
    maps.fill(bins);
    gl.use(gl.map);
    field.bind(0), maps.bind(6);
    gl.set("voxels", static_cast<int>(voxels)), gl.set("size", stored);
    for (std::size_t c = 0; c < channels; ++c) {
      const Remap& map = passes.statistics.values[i][c].map();
      gl.set("channel", static_cast<int>(c));
      gl.set("map_low", map.low()), gl.set("map_scale", map.scale());
      gl.dispatch(first, last, work.quiet());
    }
    for (std::size_t c = 0; c < channels; ++c)
      copy_beyond(field, c * voxels, stored, Vec3i(tables.voxels[0], tables.voxels[1], tables.voxels[2]));
  };

  const auto search = [&](std::size_t i, std::size_t k, const Work& step) {
    const TorusBox& box = passes.plan.blend[i + 1];
    const NeighborField& f = region.families[k];
    const std::size_t of = f.exemplar, axis = f.axis;
    const int ua = kSliceColumns[axis], va = kSliceRows[axis];
    const TorusLine &u = lines[ua], &v = lines[va], &s = lines[axis];
    const ExemplarLevel& e = *passes.exemplars[of];
    const std::size_t bytes = f.at.size() * sizeof(std::uint32_t),
                      at = first_match[k] * sizeof(std::uint32_t);
    matches.copy(at, next, 0, bytes);
    gl.use(gl.search);
    field.bind(0), matches.bind(1), next.bind(2), weight.bind(3), numbers.bind(4);
    exemplars[of].features.bind(5), exemplars[of].similar.bind(6), exemplars[of].model.bind(7);
    gl.set("channels", static_cast<int>(channels)), gl.set("dims", e.space.dims);
    gl.set("exemplar_width", e.width), gl.set("exemplar_height", e.height);
    gl.set("bias_at", exemplars[of].bias_at), gl.set("penalty_at", exemplars[of].penalty_at);
    gl.set("first_match", static_cast<int>(first_match[k]));
    gl.set("columns", f.columns), gl.set("rows", f.rows), gl.set("voxels", static_cast<int>(voxels));
    const Vec3i steps(1, stored.x(), stored.x() * stored.y());
    gl.set("stride", Vec3i(steps[ua], steps[va], steps[f.axis]));
    gl.Uniform2i(gl.at("starts_at"), tables.starts[ua], tables.starts[va]);
    gl.Uniform2i(gl.at("from"), u.from, v.from);
    const Vec3i around(patches_around(u.period), patches_around(v.period), s.period);
    gl.set("number",
           Vec3i(wrapped(u.first, around.x()), wrapped(v.first, around.y()), wrapped(s.from, around.z())));
    gl.set("around", around);
    gl.Uniform1ui(gl.at("key"),
                  search_key(passes.search.seed, passes.search.iteration + static_cast<int>(i), f.axis));
    gl.set("copying", passes.search.copying);
    const auto columns = u.patches_over(box, ua), rows = v.patches_over(box, va);
    const Vec3i first(columns[0], rows[0], box.lo[f.axis] - s.from),
        last(columns[1], rows[1], box.hi[f.axis] - s.from);
    gl.dispatch(first, last, step);
    next.copy(0, matches, at, bytes);
  };

  // Turns squared distances into weights.
  const auto weigh = [&](std::size_t i, std::size_t k) {
    const TorusBox& box = passes.plan.blend[i + 1];
    const NeighborField& f = region.families[k];
    const std::size_t axis = f.axis;
    const int ua = kSliceColumns[axis], va = kSliceRows[axis];
    const auto columns = lines[ua].patches_over(box, ua), rows = lines[va].patches_over(box, va);
    gl.use(gl.weigh);
    weight.bind(3), table.bind(7);
    gl.set("first_match", static_cast<int>(first_match[k]));
    gl.set("columns", f.columns), gl.set("rows", f.rows);
    gl.set("inverse_floor", 1 / passes.statistics.floor[i][k]);
    const Vec3i first(columns[0], rows[0], box.lo[f.axis] - lines[axis].from),
        last(columns[1], rows[1], box.hi[f.axis] - lines[axis].from);
    gl.dispatch(first, last, work.quiet());
    const Vec3i size(f.columns, f.rows, f.slices),
        from(tables.patches[ua], tables.patches[va], tables.voxels[axis]);
    copy_beyond(matches, first_match[k], size, from);
    copy_beyond(weight, first_match[k], size, from);
  };

  const std::size_t rounds = passes.plan.blend.size() - 1;
  blend(0, work.part(0, 0.1));
  for (std::size_t i = 0; i < rounds; ++i) {
    const auto share = [&](double x) { return 0.1 + 0.9 * (i + x) / rounds; };
    const double families = region.families.size();
    for (std::size_t k = 0; k < region.families.size(); ++k)
      search(i, k, work.part(share(0.6 * k / families), share(0.6 * (k + 1) / families)));
    if (probe) {
      for (std::size_t k = 0; k < region.families.size(); ++k)
        weight.read(first_match[k] * sizeof(float), region.families[k].weight);
      measure_floors(*probe, region);
    }
    for (std::size_t k = 0; k < region.families.size(); ++k) weigh(i, k);
    if (i + 1 < rounds || to_blend) blend(i + 1, work.part(share(0.6), share(1)));
  }
  for (std::size_t k = 0; k < region.families.size(); ++k) {
    matches.read(first_match[k] * sizeof(std::uint32_t), region.families[k].at);
    weight.read(first_match[k] * sizeof(float), region.families[k].weight);
  }
  for (std::size_t c = 0; c < channels; ++c) field.read(c * voxels * sizeof(float), region.field.channel[c]);
  gl.check();
}

}  // namespace terrazzo::solids
