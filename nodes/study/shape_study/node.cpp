#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/io/image_file.h"
#include "nodes/data/image.h"
#include "nodes/study/shape_study/screens.h"
#include "runtime/context.h"
#include "runtime/random.h"

namespace terrazzo::shape_study {
namespace {

std::string csv_of(const Table& t) {
  std::string out;
  for (std::size_t k = 0; k < t.columns.size(); ++k) out += (k ? "," : "") + t.columns[k];
  out += "\n";
  for (const auto& row : t.rows) {
    for (std::size_t k = 0; k < row.size(); ++k)
      out += (k ? "," : "") + (std::holds_alternative<double>(row[k])
                                   ? fmt::format("{}", std::get<double>(row[k]))
                                   : std::get<std::string>(row[k]));
    out += "\n";
  }
  return out;
}

void write_text(Context& c, const std::string& path, const std::string& text) {
  c.write_file(path, [&](const std::filesystem::path& to) {
    std::ofstream out(to, std::ios::binary);
    out << text;
    if (!out.flush()) throw Error("write-failed", "could not write " + path);
  });
}

// The stacks that are shown: originals and the chosen methods.
struct Stacks {
  std::vector<Stimulus> stimuli;
  std::vector<const Image*> images;
};

Stacks stacks_of(const Context& c) {
  const auto& wires = c.list("images");
  const auto names = c.texts("names");
  const bool all = !c.keyword("methods").empty();
  const auto methods = all ? std::vector<std::string>{} : c.texts("methods");
  if (names.size() != wires.size())
    throw Error("bad-names",
                fmt::format("there are {} names for {} stacks of images", names.size(), wires.size()),
                "set one name per wire, such as smooth/original or smooth/csg")
        .parameter("names");
  Stacks out;
  for (std::size_t i = 0; i < wires.size(); ++i) {
    const auto slash = names[i].find('/');
    const std::string method = names[i].substr(slash + 1);
    if (!all && method != "original" && std::find(methods.begin(), methods.end(), method) == methods.end())
      continue;
    const auto& image = wires[i].as<Image>();
    if (image.width <= 0 || image.height <= 0 || image.sections <= 0)
      throw Error("empty-image", fmt::format("the images of {} have no pixels", names[i]));
    out.stimuli.push_back({names[i].substr(0, slash), method, image.sections});
    out.images.push_back(&image);
  }
  return out;
}

void check(const NodeParameters& p) {
  for (const std::string& name : p.texts("names")) {
    const auto slash = name.find('/');
    if (slash == std::string::npos || slash == 0 || slash + 1 == name.size() ||
        name.find_first_of(",\"\n") != std::string::npos)
      throw Error("bad-names", fmt::format("names must have the form shape/method; one is '{}'", name),
                  "use names such as smooth/original or smooth/csg, without commas and quotes")
          .parameter("names");
  }
  if (!p.keyword("methods").empty()) return;
  for (const std::string& method : p.texts("methods")) {
    const auto names = p.texts("names");
    if (std::none_of(names.begin(), names.end(),
                     [&](const std::string& name) { return name.substr(name.find('/') + 1) == method; }))
      throw Error("unknown-method", fmt::format("no stack has the method '{}'", method),
                  "use methods that occur in names")
          .parameter("methods");
  }
}

void compute(Context& c) {
  const Stacks stacks = stacks_of(c);
  const auto& stimuli = stacks.stimuli;
  const auto seed = c.seed();
  const auto screens = make_screens(stimuli, c.integer("repeats"), seed);
  const auto training = make_training(stimuli, screens, c.integer("training"), seed);
  // Image names are shuffled numbers, so that they reveal nothing.
  std::vector<std::pair<int, int>> all;
  for (std::size_t i = 0; i < stimuli.size(); ++i)
    for (int s = 0; s < stimuli[i].sections; ++s) all.emplace_back(static_cast<int>(i), s);
  Random r(seed, 302);
  for (std::size_t i = all.size(); i > 1; --i) std::swap(all[i - 1], all[r.below(i)]);
  std::vector<std::vector<std::string>> names(stimuli.size());
  for (std::size_t i = 0; i < stimuli.size(); ++i) names[i].resize(stimuli[i].sections);
  const std::string folder = c.text("path");
  for (std::size_t k = 0; k < all.size(); ++k) {
    c.work().check();
    const auto [stimulus, section] = all[k];
    const std::string name = fmt::format("{:03}.png", k + 1);
    names[stimulus][section] = name;
    c.write_file(folder + "/images/" + name, [&](const std::filesystem::path& to) {
      write_image(to, *stacks.images[stimulus], section);
    });
    c.work().progress((static_cast<double>(k) + 1) / all.size());
  }
  const Table key = key_of(screens, names);
  write_text(c, folder + "/key.csv", csv_of(key));
  write_text(c, folder + "/index.html", page_of(screens, training, names));
  c.metric("screens", screens.size());
  c.metric("pictures", all.size());
  c.output("key", key);
}

}  // namespace
}  // namespace terrazzo::shape_study

namespace terrazzo {

NodeType shape_study_node() {
  using namespace shape_study;
  return NodeType("ShapeStudy", 5)
      .doc_(
          "Creates a user study that runs from a folder: a page with screens of three images, where the "
          "center and one side show the original and the other side a decoy, and the key to the answers.")
      .source_("Jagnow, Dorsey, Rushmeier 2008, section 4.2")
      .writes_files_()
      .input_list(
          "images", {"Image"},
          "Stacks of at least three sections, one per volume. Volumes and planes must differ in their "
          "seeds; otherwise a decoy may repeat its original's arrangement.")
      .output("key", "Table", "Key: screen, shape, method, decoy (left, right, none), image names")
      .parameter(Parameter::output_path("path").doc_(
          "Output folder, which will contain index.html, images/ and key.csv"))
      .parameter(Parameter::texts("names", {})
                     .count(1, 1000)
                     .required()
                     .doc_("Names of the stacks in their order, as shape/method. The method of the shape "
                           "itself is `original`."))
      .parameter(Parameter::with_keyword(ParameterKind::Texts, "methods", "all")
                     .doc_("Methods shown beside the originals. Other stacks are left out."))
      .parameter(Parameter::integer("repeats", 4)
                     .range(1, 100)
                     .doc_("Number of screens per shape and method, and per shape without a decoy"))
      .parameter(
          Parameter::integer("training", 10)
              .range(0, 1000)
              .doc_("Number of training screens before the test. None shows the images of a test screen; "
                    "answers to them are not saved."))
      .parameter(Parameter::seed().doc_("Random seed of the screens"))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
