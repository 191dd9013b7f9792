#include <fmt/format.h>

#include <cmath>

#include "graph/node_type.h"
#include "nodes/common/plot/plot.h"
#include "nodes/data/table.h"
#include "nodes/properties/property_interval/interval.h"
#include "runtime/context.h"

namespace terrazzo::property_interval {
namespace {

constexpr double kPrecision = 0.05;  // two standard deviations of a representative volume, relative

// The value of a measure in a table with the columns measure and value.
double value_of(const Table& table, const std::string& measure, const std::string& where) {
  const int names = table.column("measure");
  for (std::size_t row = 0; names >= 0 && row < table.rows.size(); ++row)
    if (const auto* name = std::get_if<std::string>(&table.rows[row][names]); name && *name == measure)
      return table.number(row, "value");
  throw Error("no-measure", fmt::format("{} has no measure '{}'", where, measure),
              "connect tables of Homogenize, and name one of their measures")
      .parameter("measure");
}

std::vector<double> values_of(const Context& c, const std::string& port, const std::string& measure) {
  std::vector<double> out;
  for (const Value& v : c.list(port)) {
    out.push_back(value_of(v.as<Table>(), measure, fmt::format("table {} of {}", out.size() + 1, port)));
    if (!std::isfinite(out.back()))
      throw Error("no-measure",
                  fmt::format("table {} of {} has no number for '{}'", out.size(), port, measure),
                  "leave out what was not computed")
          .parameter("measure");
  }
  return out;
}

// The mean of the blocks' relative errors, as far as they are known.
double mean_voxel_error(const Context& c) {
  double sum = 0, count = 0;
  for (const Value& v : c.list("blocks")) {
    const Table& t = v.as<Table>();
    for (std::size_t row = 0; row < t.rows.size(); ++row)
      if (const auto* name = std::get_if<std::string>(&t.rows[row][0]);
          name && *name == "voxel error, relative") {
        sum += t.number(row, "value");
        ++count;
      }
  }
  return count > 0 ? sum / count : 0;
}

Image figure_of(const Interval& i, const std::vector<double>& blocks, const std::vector<double>& draws,
                const std::string& measure) {
  Plot plot;
  plot.title = "How sure it is";
  plot.y_label = measure;
  plot.x_words = {"interval", "blocks", "draws of profiles"};
  PlotSeries interval;
  interval.kind = PlotSeries::Kind::Points;
  interval.x = {0};
  interval.y = {i.estimate};
  interval.low = {i.low};
  interval.high = {i.high};
  plot.series.push_back(interval);
  for (const auto& [at, values] : {std::pair(1, &blocks), std::pair(2, &draws)}) {
    PlotSeries points;
    points.kind = PlotSeries::Kind::Points;
    points.color = at;
    for (std::size_t k = 0; k < values->size(); ++k) {  // side by side, so that equal ones are seen
      points.x.push_back(at + 0.3 * ((k + 0.5) / values->size() - 0.5));
      points.y.push_back((*values)[k]);
    }
    plot.series.push_back(points);
  }
  return draw(plot);
}

void compute(Context& c) {
  const std::string measure = c.text("measure");
  const auto blocks = values_of(c, "blocks", measure), draws = values_of(c, "draws", measure);
  double mean = 0;
  for (const double v : blocks) mean += v / blocks.size();
  const Interval i = interval_of(blocks, draws, mean_voxel_error(c) * mean, c.number("confidence"));
  Table table;
  table.columns = {"measure", "value"};
  const auto add = [&](const std::string& name, const std::string& metric, double value) {
    table.rows.push_back({name, value});
    if (!metric.empty()) c.metric(metric, value);
  };
  add("estimate", "estimate", i.estimate);
  add("lower end", "low", i.low);
  add("upper end", "high", i.high);
  add("standard deviation from the photograph", "photograph", i.photograph);
  add("standard deviation of a block", "block", i.block);
  add("standard error of the mean over blocks", "", i.block / std::sqrt(blocks.size()));
  add("error of the voxels", "voxels", i.voxels);
  if (i.estimate != 0)
    add("blocks in a representative volume", "representative_blocks",
        std::pow(2 * i.block / (kPrecision * i.estimate), 2));
  c.output("figure", figure_of(i, blocks, draws, measure));
  c.output("table", std::move(table));
}

}  // namespace
}  // namespace terrazzo::property_interval

namespace terrazzo {

NodeType property_interval_node() {
  using namespace property_interval;
  return NodeType("PropertyInterval", 1)
      .doc_(
          "Finds how sure a property is that comes from one photograph, from its values for several blocks "
          "and for "
          "several draws of the photograph's profiles.")
      .source_("Welch 1947; Kanit et al. 2003 (representative volume)")
      .input_list("blocks", {"Table"},
                  "Tables of Homogenize for blocks with the photograph's profiles and different seeds")
      .input_list("draws", {"Table"},
                  "The same for draws of the profiles by ResampleProfiles, each with another seed")
      .output("table", "Table",
              "The estimate with its interval, and what it comes from: the photograph, the block, the "
              "voxels. Blocks in a "
              "representative volume: how many times the block's volume two standard deviations are 5 %.")
      .output("figure", "Image", "The interval beside the values")
      .parameter(
          Parameter::text("measure", "effective, mean").doc_("Row of the tables, in the column measure"))
      .parameter(Parameter::number("confidence", 0.9)
                     .range(0.5, 0.999)
                     .doc_("Share of the intervals that should hold the true value"))
      .compute_(compute);
}

}  // namespace terrazzo
