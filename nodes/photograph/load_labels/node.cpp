#include <algorithm>

#include "graph/node_type.h"
#include "nodes/photograph/load_labels/label_file.h"
#include "runtime/context.h"

namespace terrazzo::load_labels {
namespace {

// All masks stay in memory until the last one is read. `held`: bytes of those that were read before.
std::vector<RawMask> read_masks(Context& c, const char* parameter, std::uint64_t& held) {
  std::vector<RawMask> masks;
  for (const auto& file : c.files(parameter)) try {
      c.work().check();
      Reading reading = reading_of(c);
      reading.memory -= std::min(reading.memory, held);
      masks.push_back(read_mask(file, page_choice(c), reading));
      held += masks.back().values.size() * (sizeof(std::uint32_t) + sizeof(std::int32_t));
    } catch (Error& e) {
      if (e.diagnostic().parameter == "path") throw e.parameter(parameter);
      throw;
    }
  return masks;
}

void compute(Context& c) {
  std::uint64_t held = 0;
  const std::vector<RawMask> masks = read_masks(c, "path", held);
  const double pixel_size = c.number("pixel_size");
  Labels labels = c.choice<MaskKind>("kind") == MaskKind::Instances ? labels_from_instances(masks, pixel_size)
                                                                    : labels_from_classes(masks, pixel_size);
  if (c.keyword("classes").empty()) {
    if (c.choice<MaskKind>("kind") == MaskKind::Classes)
      throw Error("both-given", "with kind: classes, the mask itself has the classes", "remove `classes`")
          .parameter("classes");
    set_classes(labels, read_masks(c, "classes", held));
  }
  c.metric("profiles", labels.count());
  c.metric("sections", labels.sections);
  c.output("labels", std::move(labels));
}

}  // namespace
}  // namespace terrazzo::load_labels

namespace terrazzo {

NodeType load_labels_node() {
  using namespace load_labels;
  return NodeType("LoadLabels", 3)
      .doc_("Reads existing masks as labels, to be measured by Segment instead of its own segmentation.")
      .output("labels", "Labels", "One section per file, in file name order")
      .parameter(Parameter::input_path("path").doc_("Mask of whole numbers of 1 to 64 bits, of a palette's "
                                                    "indices, or with one 8-bit color per class. 0 and "
                                                    "black are background. A glob names a stack of sections. "
                                                    "JPEG is refused, because it changes numbers."))
      .parameter(Parameter::choice("kind", "instances", {"instances", "classes"})
                     .doc_("instances: each value is one profile. classes: each value is a class, and its "
                           "connected components are the profiles."))
      .parameter(
          Parameter::with_keyword(ParameterKind::InputPath, "classes", "none")
              .doc_("With kind: instances, a second mask of the same size, or a glob, that has the class "
                    "of each profile: the most frequent value at its pixels, from 1. none: all are "
                    "of one class."))
      .parameter(Parameter::optional_integer("page", "auto")
                     .range(1, 1e6)
                     .doc_("Page to read of a file with several, from 1. auto: the only one."))
      .parameter(Parameter::optional_integer("channel", "auto")
                     .range(1, 10000)
                     .doc_("Channel to read, from 1. auto: the only one, or colors."))
      .parameter(
          Parameter::number("pixel_size", 1).unit_("mm").range(1e-9, 1e9).doc_("Edge length of a pixel"))
      .compute_(compute);
}

}  // namespace terrazzo
