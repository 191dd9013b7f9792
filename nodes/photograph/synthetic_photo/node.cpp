#include "graph/node_type.h"
#include "nodes/photograph/synthetic_photo/synthetic_photo.h"
#include "runtime/context.h"

namespace terrazzo::synthetic_photo {
namespace {

void compute(Context& c) {
  PhotoOptions o;
  o.scene = c.choice<Scene>("scene");
  o.pictures = c.integer("pictures");
  o.width = c.integer("width");
  o.height = c.integer("height");
  o.pixel_size = c.number("pixel_size");
  o.fill = c.optional_number("fill");
  o.objects = c.boolean("objects");
  o.seed = c.seed();
  Photo photo = take_photo(o, c.work());
  c.metric("particles", photo.labels.count());
  c.output("image", std::move(photo.image));
  c.output("labels", std::move(photo.labels));
  c.output("not_material", std::move(photo.not_material));
  c.output("unclear", std::move(photo.unclear));
}

}  // namespace
}  // namespace terrazzo::synthetic_photo

namespace terrazzo {

NodeType synthetic_photo_node() {
  using namespace synthetic_photo;
  return NodeType("SyntheticPhoto", 7)
      .doc_(
          "Renders photographs of imaginary aggregates with exact labels of their particles, to train and "
          "test segmentation. Shapes, sizes, colors, textures, light and camera vary with the seed.")
      .source_("Wicksell 1925 for the sizes of profiles; JPEG: ITU-T T.81; see README")
      .output("image", "Image", "The photographs, one section each")
      .output("labels", "Labels", "Visible part of each particle that a person would outline")
      .output("not_material", "Labels",
              "1 where a ruler, frame, caption or another thing covers the material")
      .output("unclear", "Labels",
              "1 on particles without a label: too small, too faint or too hidden to say whether a person "
              "would outline them")
      .parameter(Parameter::choice("scene", "any", {"any", "bank", "heap", "section", "outcrop", "alloy"})
                     .doc_("bank: stones in and on soil. heap: loose stones on each other. section: a plane "
                           "section through particles in a binder. any: each picture draws one of these "
                           "three. outcrop: a bank whose stones have nearly the colors of the soil. alloy: a "
                           "section of lobed grains that grew together."))
      .parameter(Parameter::integer("pictures", 1).range(1, 4096).doc_("Number of pictures"))
      .parameter(Parameter::integer("width", 256).range(16, 4096).unit_("pixels").doc_("Width of a picture"))
      .parameter(
          Parameter::integer("height", 256).range(16, 4096).unit_("pixels").doc_("Height of a picture"))
      .parameter(Parameter::number("pixel_size", 1).range(1e-9, 1e9).unit_("mm").doc_("Edge of a pixel"))
      .parameter(
          Parameter::optional_number("fill", "auto")
              .range(0.01, 3)
              .doc_(
                  "Area of the particles relative to the picture's. Stones of a bank or heap that hide each "
                  "other count in full. auto: drawn for each picture."))
      .parameter(Parameter::boolean("objects", true)
                     .doc_("Adds rulers, folding rulers, tapes, scale cards, coins, pens, frames, color "
                           "charts or captions to some "
                           "pictures"))
      .parameter(Parameter::seed())
      .compute_(compute);
}

}  // namespace terrazzo
