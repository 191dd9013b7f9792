#include "graph/node_type.h"
#include "nodes/data/table.h"
#include "nodes/photograph/instance_score/instance_score.h"
#include "runtime/context.h"

namespace terrazzo::instance_score {
namespace {

void compute(Context& c) {
  const Score s = compare_instances(c.input<Labels>("labels"), c.input<Labels>("masks"));
  Table t;
  t.columns = {"found",           "masks",         "matched",
               "ap_50",           "ap_75",         "recall",
               "false_positives", "area_fraction", "area_fraction_of_masks"};
  const std::vector<double> row{static_cast<double>(s.found),
                                static_cast<double>(s.masks),
                                static_cast<double>(s.matched(0.5)),
                                s.average_precision(0.5),
                                s.average_precision(0.75),
                                s.recall(0.5),
                                static_cast<double>(s.found - s.matched(0.5)),
                                s.found_area,
                                s.mask_area};
  for (std::size_t k = 0; k < row.size(); ++k) c.metric(t.columns[k], row[k]);
  t.rows.emplace_back(row.begin(), row.end());
  c.output("table", std::move(t));
  Table each;
  each.columns = {"label", "mask", "overlap"};
  for (const Match& m : s.matches)
    each.rows.push_back({static_cast<double>(m.found), static_cast<double>(m.mask), m.overlap});
  c.output("matches", std::move(each));
}

}  // namespace
}  // namespace terrazzo::instance_score

namespace terrazzo {

NodeType instance_score_node() {
  using namespace instance_score;
  return NodeType("InstanceScore", 1)
      .doc_(
          "Compares found particles with masks, drawn by hand or known from a synthetic photograph: how many "
          "masks are found, how many particles have no mask, and how well the areas agree.")
      .source_("Average precision of instances: Stringer et al. 2021 (Cellpose)")
      .input("labels", "Labels", "Particles to judge")
      .input("masks", "Labels", "True particles of the same image")
      .output("table", "Table",
              "One row: found, masks, matched (overlap, intersection over union, of at least 0.5), ap_50 and "
              "ap_75 "
              "(matched / (matched + false positives + missed) at an overlap of 0.5 and 0.75), recall, "
              "false_positives, area_fraction, area_fraction_of_masks")
      .output("matches", "Table", "One row per match: label, mask (their ids) and overlap, at least 0.5")
      .compute_(compute);
}

}  // namespace terrazzo
