#include <algorithm>

#include "graph/node_type.h"
#include "nodes/load_labels/label_file.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

void compute(Context& c) {
  std::vector<RawMask> masks;
  std::uint64_t held = 0;
  for (const auto& file : c.files("path")) {
    c.work().check();
    // Masks stay until the last is read.
    Reading reading = reading_of(c);
    reading.memory -= std::min(reading.memory, held);
    masks.push_back(read_mask(file, reading));
    held += masks.back().values.size() * (sizeof(std::uint32_t) + sizeof(std::int32_t));
  }
  const double pixel_size = c.number("pixel_size");
  Labels labels = c.text("kind") == "instances" ? labels_from_instances(masks, pixel_size)
                                                : labels_from_classes(masks, pixel_size);
  c.metric("profiles", labels.count());
  c.metric("sections", labels.sections);
  c.output("labels", std::move(labels));
}

}  // namespace

NodeType load_labels_node() {
  return NodeType("LoadLabels", 2)
      .doc_("Reads masks made elsewhere, in the place of Segment's own segmentation.")
      .output("labels", "Labels", "one section a file, in the order of the names")
      .parameter(
          Parameter::input_path("path").doc_("Mask: 8, 16 or 32 bit numbers, or one 8 bit colour a class; 0 "
                                             "and black are background. A glob names a stack"))
      .parameter(Parameter::choice("kind", "instances", {"instances", "classes"})
                     .doc_("instances: a value is a profile; classes: the connected parts of a class are its "
                           "profiles"))
      .parameter(Parameter::number("pixel_size", 1).unit_("mm").above(0).doc_("Edge of a pixel"))
      .compute_(compute);
}

}  // namespace terrazzo
