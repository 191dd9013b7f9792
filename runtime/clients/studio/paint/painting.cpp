#include "runtime/clients/studio/paint/painting.h"

#include <fmt/format.h>

#include <algorithm>

#include "nodes/common/io/image_file.h"
#include "nodes/common/io/stroke_text.h"
#include "nodes/cooccurrence/texture_nib/region.h"
#include "runtime/hash.h"

namespace terrazzo::studio {
namespace fs = std::filesystem;
namespace {

using texture_nib::Finish;
using texture_nib::Rectangle;

constexpr const char* kFinishes[] = {"levels", "colors", "patches"};

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + '"';
}

}  // namespace

Painting::Painting(const fs::path& picture) : file_(fs::absolute(picture)), original_(read_image(picture)) {}

const Image& Painting::picture() const { return nib_ ? nib_->picture() : original_; }

std::size_t Painting::strokes() const {
  std::size_t n = 0;
  for (const auto& l : layers_) n += l.strokes.size();
  return n;
}

texture_nib::Nib Painting::nib_of(const Layer& layer, const Work& work) const {
  const NibOptions& c = layer.choice;
  const auto within = [](const char* name, double v, double lo, double hi) {
    if (!(v >= lo && v <= hi))
      throw Error("bad-value", fmt::format("{} must be between {} and {}; it is {}", name, lo, hi, v))
          .parameter(name);
  };
  within("levels", c.levels, 2, kMostLevels);
  within("extent", c.extent, 1, 16);
  within("scales", c.scales, 1, 8);
  within("passes", c.passes, 1, 1000);
  if (c.threshold) within("threshold", *c.threshold, 0, 10);
  const auto finish = std::find(std::begin(kFinishes), std::end(kFinishes), c.finish);
  if (finish == std::end(kFinishes))
    throw Error("bad-value", fmt::format("'{}' is not a finish", c.finish),
                "choose levels, colors or patches")
        .parameter("finish");
  texture_nib::NibOptions s;
  s.levels = c.levels;
  s.extent = c.extent;
  s.scales = c.scales;
  s.seed = c.seed;
  if (c.threshold) s.threshold = *c.threshold;
  const auto region = texture_nib::region_mask(c.region, layer.base.width, layer.base.height);
  return {
      layer.base,
      texture_nib::learn(layer.base, region, s, work),
      {.passes = c.passes, .finish = static_cast<Finish>(finish - std::begin(kFinishes)), .seed = c.seed}};
}

void Painting::choose(const NibOptions& choice, const Work& work) {
  end_stroke();
  Layer layer{choice, picture(), {}};
  auto nib = nib_of(layer, work);  // throws before anything changes
  if (!layers_.empty() && layers_.back().strokes.empty()) layers_.pop_back();
  layers_.push_back(std::move(layer));
  nib_ = std::move(nib);
}

void Painting::check_nib(double radius) const {
  if (!nib_) throw Error("no-nib", "there is no nib yet", "pick a region of the image first");
  if (2 * radius > std::max(original_.width, original_.height))
    throw Error("nib-too-large",
                fmt::format("the nib is {} pixels wide, larger than the image ({} × {} pixels)", 2 * radius,
                            original_.width, original_.height),
                "reduce its size");
  check_stroke({{{Vec2::Zero()}}, radius, false});
}

void Painting::begin_stroke(double radius) {
  check_nib(radius);
  end_stroke();
  nib_->begin_stroke(radius);
  stroke_ = Stroke{{{}}, radius, false};
  met_ = false;
}

Rectangle Painting::extend_stroke(const Vec2& point, const Work& work) {
  work.check();
  if (!stroke_) throw Error("no-stroke", "no stroke has begun");
  const Rectangle changed = nib_->extend_stroke(point, work);
  stroke_->parts[0].push_back(point);
  met_ |= changed.x1 > changed.x0;
  return changed;
}

void Painting::end_stroke() {
  if (!stroke_) return;
  if (met_) layers_.back().strokes.push_back(std::move(*stroke_));
  stroke_.reset();
}

void Painting::repaint(const Work& work) {
  nib_.reset();
  if (layers_.empty()) return;
  nib_ = nib_of(layers_.back(), work);
  for (const auto& s : layers_.back().strokes) nib_->paint(s, work);
}

bool Painting::drop_stroke(const Work& work) {
  if (!stroke_) return false;
  stroke_.reset();
  repaint(work);
  return true;
}

bool Painting::undo(const Work& work) {
  end_stroke();
  if (layers_.empty()) return false;
  if (layers_.back().strokes.empty())
    layers_.pop_back();
  else
    layers_.back().strokes.pop_back();
  repaint(work);
  return true;
}

std::string Painting::graph(const fs::path& file) const {
  std::error_code error;
  fs::path path = fs::relative(file_, fs::absolute(file).parent_path(), error);
  if (error || path.empty()) path = file_;
  std::string out = fmt::format(
      "terrazzo: 1\nname: {}\nnodes:\n  picture:\n    type: LoadImage\n    params: {{path: {}}}\n",
      quoted(file_.stem().string() + ", painted"), quoted(path.string()));
  std::string last = "picture";
  std::size_t number = 0;
  for (const auto& l : layers_) {
    if (l.strokes.empty()) continue;
    ++number;
    out += fmt::format("  strokes_{}:\n    type: Strokes\n    params:\n      strokes:\n", number);
    for (const auto& s : l.strokes) out += fmt::format("        - {}\n", quoted(strokes::write_stroke(s)));
    const NibOptions& c = l.choice;
    out += fmt::format(
        "  nib_{0}:\n    type: TextureNib\n    inputs: {{image: {1}.image, strokes: strokes_{0}.strokes}}\n"
        "    params: {{region: [{2}], levels: {3}, extent: {4}, scales: {5}, passes: {6}, finish: {7}{8}, "
        "seed: {9}}}\n",
        number, last, fmt::join(c.region, ", "), c.levels, c.extent, c.scales, c.passes, c.finish,
        c.threshold ? fmt::format(", threshold: {}", *c.threshold) : "", c.seed);
    last = fmt::format("nib_{}", number);
  }
  out += fmt::format(
      "  painted:\n    type: Export\n    inputs: {{image: {}.image}}\n    params: {{path: {}}}\noutputs: "
      "{{image: {}.image}}\n",
      last, quoted(file_.stem().string() + "_painted.png"), last);
  return out;
}

std::string Painting::content() const {
  HashWriter w;
  const ValueType& type = value_type<Image>();
  w.text(type.name);
  type.encode(&picture(), w);
  return w.hash().text();
}

}  // namespace terrazzo::studio
