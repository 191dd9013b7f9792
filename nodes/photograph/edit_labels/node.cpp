#include "graph/node_type.h"
#include "nodes/photograph/edit_labels/edit_labels.h"
#include "runtime/context.h"

namespace terrazzo::edit_labels {
namespace {

std::vector<Edit> edits_of(const NodeParameters& p) {
  std::vector<Edit> edits;
  if (!p.keyword("edits").empty()) return edits;
  const auto texts = p.texts("edits");
  for (std::size_t k = 0; k < texts.size(); ++k) try {
      edits.push_back(read_edit(texts[k]));
    } catch (Error& e) {
      throw e.item(k);
    }
  return edits;
}

void check(const NodeParameters& p) { edits_of(p); }

void compute(Context& c) {
  Edited edited = apply_edits(c.input<Labels>("labels"), edits_of(c), c.work());
  for (const auto& warning : edited.warnings) c.warn(warning);
  c.metric("particles", edited.labels.count());
  c.metric("edits_not_applied", edited.warnings.size());
  c.output("labels", std::move(edited.labels));
  c.output("not_material", std::move(edited.not_material));
}

}  // namespace
}  // namespace terrazzo::edit_labels

namespace terrazzo {

NodeType edit_labels_node() {
  using namespace edit_labels;
  return NodeType("EditLabels", 1)
      .doc_(
          "Corrects labels by a list of edits. Edits address particles by points in the picture and not by "
          "number, so "
          "they survive a new segmentation; those that no longer apply are warnings.")
      .source_("Manual corrections as data: see README")
      .input("labels", "Labels", "Labels to correct, for example from Segment")
      .output("labels", "Labels", "Corrected labels; connect them to a second Segment to measure them")
      .output("not_material", "Labels", "1 where edits ignore the picture; connect it to Segment's mask")
      .parameter(Parameter::with_keyword(ParameterKind::Texts, "edits", "none")
                     .unit_("pixels")
                     .doc_("Edits in order, with points from the upper left corner, y down: \"merge x y x y "
                           "…\" joins the "
                           "particles at the points, \"split x y x y …\" cuts the particle that the line "
                           "crosses most, "
                           "\"delete x y …\" makes particles binder, \"outline x y x y x y …\" adds a "
                           "particle, \"ignore x0 y0 "
                           "x1 y1\" or a polygon shows no material. In a stack, \"2: delete 5 7\" edits "
                           "section 2, from 0."))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
