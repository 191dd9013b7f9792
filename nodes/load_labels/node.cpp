#include <algorithm>

#include "graph/node_type.h"
#include "nodes/load_labels/label_file.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {
using namespace load_labels;

void compute(Context& c) {
  std::vector<RawMask> masks;
  std::uint64_t held = 0;
  for (const auto& file : c.files("path")) {
    c.work().check();
    // All masks stay in memory until the last one is read.
    Reading reading = reading_of(c);
    reading.memory -= std::min(reading.memory, held);
    masks.push_back(read_mask(file, reading));
    held += masks.back().values.size() * (sizeof(std::uint32_t) + sizeof(std::int32_t));
  }
  const double pixel_size = c.number("pixel_size");
  Labels labels = c.choice<MaskKind>("kind") == MaskKind::Instances ? labels_from_instances(masks, pixel_size)
                                                                    : labels_from_classes(masks, pixel_size);
  c.metric("profiles", labels.count());
  c.metric("sections", labels.sections);
  c.output("labels", std::move(labels));
}

}  // namespace

NodeType load_labels_node() {
  return NodeType("LoadLabels", 2)
      .doc_("Reads existing masks as labels, to be measured by Segment instead of its own segmentation.")
      .output("labels", "Labels", "One section per file, in file name order")
      .parameter(Parameter::input_path("path").doc_(
          "Mask of 8, 16 or 32 bit numbers, or with one 8-bit color per class. 0 and black are background. A "
          "glob names a stack of sections."))
      .parameter(Parameter::choice("kind", "instances", {"instances", "classes"})
                     .doc_("instances: each value is one profile. classes: each value is a class, and its "
                           "connected components are the profiles."))
      .parameter(Parameter::number("pixel_size", 1).unit_("mm").above(0).doc_("Edge length of a pixel"))
      .compute_(compute);
}

}  // namespace terrazzo
