#include "nodes/solids/synthesis/blockwise/gl.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/common/gl/gl_program.h"
#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/blockwise/gl_run.h"
#include "nodes/solids/synthesis/matching/weights.h"

namespace terrazzo::solids {
namespace {

constexpr const char* kHint = "set device: cpu, or install a newer driver";

}  // namespace

BlockGl::BlockGl(GlDevice device) : gl_(std::make_unique<Gl>(device)) {
  gl_->search = make_gl_program(gl_->context, "solid_search.comp", kHint);
  gl_->weigh = make_gl_program(gl_->context, "solid_weigh.comp", kHint);
  gl_->blend = make_gl_program(gl_->context, "solid_blend.comp", kHint);
  gl_->map = make_gl_program(gl_->context, "solid_map.comp", kHint);
  gl_->copy = make_gl_program(gl_->context, "solid_copy.comp", kHint);
  gl_->count = make_gl_program(gl_->context, "solid_count.comp", kHint);
  gl_->finish = make_gl_program(gl_->context, "solid_finish.comp", kHint);
}

BlockGl::~BlockGl() = default;

const std::string& BlockGl::renderer() const { return gl_->context.renderer(); }

BlockGl::Run::Run(Gl& gl, const BlockPasses& passes, BlockProbe* probe, BlockRegion& region, const Work& work)
    : gl_(gl),
      passes_(passes),
      probe_(probe),
      region_(region),
      work_(work),
      lines_(region.lines),
      channels_(region.field.channel.size()),
      voxels_(region.field.channel[0].size()),
      tables_(region.lines),
      field_(gl),
      matches_(gl),
      next_(gl),
      weight_(gl),
      numbers_(gl),
      texels_(gl),
      maps_(gl),
      table_(gl),
      counts_(gl),
      sum_(gl) {
  numbers_.fill(tables_.numbers);
  table_.fill(WeightTable(passes.power).entries());
  field_.resize(channels_ * voxels_ * sizeof(float));
  upload_exemplars();
  upload_matches();
}

void BlockGl::Run::upload_exemplars() {
  std::vector<float> all;
  for (std::size_t e = 0; e < passes_.exemplars.size(); ++e) {
    const ExemplarLevel& exemplar = *passes_.exemplars[e];
    exemplars_.emplace_back(gl_, exemplar, passes_.statistics.penalty[e]);
    first_texel_.push_back(all.size() / 4);
    all.insert(all.end(), exemplar.texels.begin(), exemplar.texels.end());
  }
  texels_.fill(all);
}

void BlockGl::Run::upload_matches() {
  std::size_t all = 0, most = 0;
  for (const NeighborField& f : region_.families) {
    first_match_.push_back(all);
    all += f.at.size();
    most = std::max(most, f.at.size());
  }
  matches_.resize(all * sizeof(std::uint32_t));
  weight_.resize(all * sizeof(float));
  next_.resize(most * sizeof(std::uint32_t));
  for (std::size_t k = 0; k < region_.families.size(); ++k) {
    const NeighborField& f = region_.families[k];
    matches_.write(first_match_[k] * sizeof(std::uint32_t), f.at);
    weight_.write(first_match_[k] * sizeof(float), f.weight);
  }
}

void BlockGl::Run::download_field() {
  for (std::size_t c = 0; c < channels_; ++c)
    field_.read(c * voxels_ * sizeof(float), region_.field.channel[c]);
}

void BlockGl::Run::download_weights() {
  for (std::size_t k = 0; k < region_.families.size(); ++k)
    weight_.read(first_match_[k] * sizeof(float), region_.families[k].weight);
}

void BlockGl::Run::download_matches() {
  for (std::size_t k = 0; k < region_.families.size(); ++k)
    matches_.read(first_match_[k] * sizeof(std::uint32_t), region_.families[k].at);
}

void BlockGl::Run::copy_beyond(const GlBuffer& what, std::size_t first, const Vec3i& size, const Vec3i& at) {
  if (!lines_[0].closed && !lines_[1].closed && !lines_[2].closed) return;
  gl_.use(gl_.copy);
  what.bind(0);
  numbers_.bind(4);
  gl_.set("size", size);
  gl_.set("originals_at", at);
  gl_.set("first_number", static_cast<int>(first));
  gl_.dispatch(size, work_.quiet(), [&](int z, int) { gl_.set("first_slice", z); });
}

void BlockGl::Run::blend(std::size_t i, const Work& work) {
  const TorusBox& box = passes_.plan.blend[i];
  Vec3i first, last;
  for (Eigen::Index k = 0; k < 3; ++k) {
    first[k] = box.lo[k] - lines_[k].from;
    last[k] = box.hi[k] - lines_[k].from;
  }
  blend_patches(i, first, last, work);
  if (probe_) {
    auto& maps = probe_->measured.values.emplace_back();
    for (std::size_t c = 0; c < channels_; ++c)
      maps.push_back(measured_values(c, probe_->box, probe_->values[c]));
  }
  for (std::size_t c = 0; c < channels_; ++c)
    map_values(c, passes_.statistics.values[i][c].map(), first, last);
}

void BlockGl::Run::blend_patches(std::size_t i, const Vec3i& first, const Vec3i& last, const Work& work) {
  gl_.use(gl_.blend);
  field_.bind(0);
  matches_.bind(1);
  weight_.bind(3);
  numbers_.bind(4);
  texels_.bind(5);
  gl_.set("channels", static_cast<int>(channels_));
  gl_.set("voxels", static_cast<int>(voxels_));
  gl_.set("families", count_of(region_.families));
  gl_.set("size", region_.field.size);
  gl_.set("window", passes_.windows[i]);
  for (std::size_t k = 0; k < region_.families.size(); ++k) {
    const NeighborField& f = region_.families[k];
    const std::size_t axis = f.axis;
    const auto put = [&](const char* name, int v) { gl_.set(fmt::format("{}[{}]", name, k), v); };
    put("axis_u", kSliceColumns[axis]);
    put("axis_v", kSliceRows[axis]);
    put("axis_s", f.axis);
    put("first_match", static_cast<int>(first_match_[k]));
    put("columns", f.columns);
    put("rows", f.rows);
    put("first_texel", first_texel_[f.exemplar]);
    put("exemplar_width", passes_.exemplars[f.exemplar]->width);
  }
  for (std::size_t a = 0; a < 3; ++a) {
    gl_.set(fmt::format("starts_at[{}]", a), tables_.starts[a]);
    gl_.set(fmt::format("covers_at[{}]", a), tables_.covers[a]);
    gl_.set(fmt::format("from[{}]", a), lines_[a].from);
  }
  gl_.dispatch(first, last, work);
}

BlockGl::Run::PatchBox BlockGl::Run::patches_over(const TorusBox& box, const NeighborField& f) const {
  const std::size_t axis = f.axis;
  const int ua = kSliceColumns[axis], va = kSliceRows[axis];
  const auto columns = lines_[ua].patches_over(box, ua), rows = lines_[va].patches_over(box, va);
  return {{columns[0], rows[0], box.lo[f.axis] - lines_[axis].from},
          {columns[1], rows[1], box.hi[f.axis] - lines_[axis].from}};
}

void BlockGl::Run::search(std::size_t i, std::size_t k, const Work& work) {
  const NeighborField& f = region_.families[k];
  const std::size_t axis = f.axis;
  const int ua = kSliceColumns[axis], va = kSliceRows[axis];
  const std::size_t bytes = f.at.size() * sizeof(std::uint32_t);
  const std::size_t at = first_match_[k] * sizeof(std::uint32_t);
  matches_.copy(at, next_, 0, bytes);
  gl_.use(gl_.search);
  field_.bind(0);
  matches_.bind(1);
  next_.bind(2);
  weight_.bind(3);
  numbers_.bind(4);
  set_exemplar(f);
  gl_.set("channels", static_cast<int>(channels_));
  gl_.set("first_match", static_cast<int>(first_match_[k]));
  gl_.set("columns", f.columns);
  gl_.set("rows", f.rows);
  gl_.set("voxels", static_cast<int>(voxels_));
  const Vec3i& stored = region_.field.size;
  const Vec3i steps(1, stored.x(), stored.x() * stored.y());
  gl_.set("stride", Vec3i(steps[ua], steps[va], steps[f.axis]));
  gl_.Uniform2i(gl_.at("starts_at"), tables_.starts[ua], tables_.starts[va]);
  gl_.Uniform2i(gl_.at("from"), lines_[ua].from, lines_[va].from);
  set_random_numbers(i, f);
  gl_.set("copying", passes_.search.copying);
  const PatchBox patches = patches_over(passes_.plan.blend[i + 1], f);
  gl_.dispatch(patches.first, patches.last, work);
  next_.copy(0, matches_, at, bytes);
}

void BlockGl::Run::set_exemplar(const NeighborField& f) {
  const ExemplarLevel& exemplar = *passes_.exemplars[f.exemplar];
  const ExemplarBuffers& buffers = exemplars_[f.exemplar];
  buffers.features.bind(5);
  buffers.similar.bind(6);
  buffers.model.bind(7);
  gl_.set("dims", exemplar.space.dims);
  gl_.set("exemplar_width", exemplar.width);
  gl_.set("exemplar_height", exemplar.height);
  gl_.set("bias_at", buffers.bias_at);
  gl_.set("penalty_at", buffers.penalty_at);
}

// Random numbers depend on the place in the whole solid, so a patch draws the same ones in every block.
void BlockGl::Run::set_random_numbers(std::size_t i, const NeighborField& f) {
  const std::size_t axis = f.axis;
  const TorusLine& u = lines_[kSliceColumns[axis]];
  const TorusLine& v = lines_[kSliceRows[axis]];
  const TorusLine& s = lines_[axis];
  const Vec3i around(patches_around(u.period), patches_around(v.period), s.period);
  gl_.set("number",
          Vec3i(wrapped(u.first, around.x()), wrapped(v.first, around.y()), wrapped(s.from, around.z())));
  gl_.set("around", around);
  const int iteration = passes_.search.iteration + static_cast<int>(i);
  gl_.Uniform1ui(gl_.at("key"), search_key(passes_.search.seed, iteration, f.axis));
}

void BlockGl::Run::weigh(std::size_t i, std::size_t k) {
  const NeighborField& f = region_.families[k];
  const std::size_t axis = f.axis;
  gl_.use(gl_.weigh);
  weight_.bind(3);
  table_.bind(7);
  gl_.set("first_match", static_cast<int>(first_match_[k]));
  gl_.set("columns", f.columns);
  gl_.set("rows", f.rows);
  gl_.set("inverse_floor", 1 / passes_.statistics.floor[i][k]);
  const PatchBox patches = patches_over(passes_.plan.blend[i + 1], f);
  gl_.dispatch(patches.first, patches.last, work_.quiet());
  const Vec3i size(f.columns, f.rows, f.slices);
  const Vec3i originals(tables_.patches[kSliceColumns[axis]], tables_.patches[kSliceRows[axis]],
                        tables_.voxels[axis]);
  copy_beyond(matches_, first_match_[k], size, originals);
  copy_beyond(weight_, first_match_[k], size, originals);
}

void BlockGl::Run::run(bool to_blend, const BlockFinish* finishing) {
  const std::size_t rounds = passes_.plan.blend.size() - 1;
  const double end = finishing ? 0.8 : 1;
  stage(0, "blend");
  blend(0, work_.part(0, 0.1 * end));
  for (std::size_t i = 0; i < rounds; ++i) {
    const auto share = [&](double x) { return end * (0.1 + 0.9 * (i + x) / rounds); };
    stage(share(0), "search");
    const double families = region_.families.size();
    for (std::size_t k = 0; k < region_.families.size(); ++k)
      search(i, k, work_.part(share(0.6 * k / families), share(0.6 * (k + 1) / families)));
    if (probe_) {
      download_weights();
      measure_floors(*probe_, region_);
    }
    for (std::size_t k = 0; k < region_.families.size(); ++k) weigh(i, k);
    stage(share(0.6), "blend");
    if (i + 1 < rounds || to_blend) blend(i + 1, work_.part(share(0.6), share(1)));
  }
  if (finishing) {
    stage(end, "finish");
    finish(*finishing, work_.part(end, 1));
  }
  stage(1, "read back");
  download_matches();
  if (to_blend) download_field();
  if (!finishing) download_weights();  // for the next level, or for a blend on the processor
  gl_.check();
}

void BlockGl::run(const BlockPasses& passes, bool to_blend, BlockProbe* probe, const BlockFinish* finish,
                  BlockRegion& region, const Work& work) {
  Run(*gl_, passes, probe, region, work).run(to_blend, finish);
}

}  // namespace terrazzo::solids
