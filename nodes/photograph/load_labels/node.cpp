#include <fmt/format.h>

#include <algorithm>

#include "graph/node_type.h"
#include "nodes/common/io/outlines/outline_file.h"
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

Labels labels_of_outlines(Context& c, double pixel_size) {
  if (c.choice<MaskKind>("kind") == MaskKind::Classes)
    throw Error("bad-value", "outlines are instances, which have their classes in the file", "leave out kind")
        .parameter("kind");
  return labels_from_outlines(c.files("path"), c.optional<Image>("image"), pixel_size, reading_of(c),
                              c.work());
}

// Masks, or files of outlines: the first one tells which.
Labels labels_of_files(Context& c, std::uint64_t& held) {
  const Image* image = c.optional<Image>("image");
  double pixel_size = c.keyword("pixel_size").empty() ? c.number("pixel_size") : 0;
  if (pixel_size == 0 && image) pixel_size = image->pixel_size;
  if (is_outline_file(c.files("path").front())) return labels_of_outlines(c, pixel_size);
  const std::vector<RawMask> masks = read_masks(c, "path", held);
  if (pixel_size == 0) pixel_size = 1;
  Labels labels = c.choice<MaskKind>("kind") == MaskKind::Instances ? labels_from_instances(masks, pixel_size)
                                                                    : labels_from_classes(masks, pixel_size);
  if (image &&
      (labels.width != image->width || labels.height != image->height || labels.sections != image->sections))
    throw Error("size-mismatch",
                fmt::format("'{}' has {} × {} pixels and {} sections, but the picture {} × {} and {}",
                            c.files("path").front().string(), labels.width, labels.height, labels.sections,
                            image->width, image->height, image->sections),
                "use the mask of this picture")
        .parameter("path");
  return labels;
}

void compute(Context& c) {
  std::uint64_t held = 0;
  Labels labels = labels_of_files(c, held);
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
      .doc_(
          "Reads existing masks or outlines as labels, to be measured by Segment instead of its own "
          "segmentation.")
      .source_("RFC 7946 (GeoJSON); COCO, format for object detection; ImageJ, RoiDecoder")
      .optional_input("image", {"Image"},
                      "Picture that the masks or outlines belong to. Its size must be theirs")
      .output("labels", "Labels", "One section per file, in file name order")
      .parameter(
          Parameter::input_path("path").doc_("Mask of whole numbers of 1 to 64 bits, of a palette's "
                                             "indices, or with one 8-bit color per class. 0 and "
                                             "black are background. A glob names a stack of sections. "
                                             "JPEG is refused, because it changes numbers. Or outlines: "
                                             "GeoJSON, COCO (.json), ImageJ (.roi, .zip)."))
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
      .parameter(Parameter::optional_number("pixel_size", "auto")
                     .unit_("mm")
                     .range(1e-9, 1e9)
                     .doc_("Edge length of a pixel. auto: that of image, else what a file of outlines says, "
                           "else 1."))
      .compute_(compute);
}

}  // namespace terrazzo
