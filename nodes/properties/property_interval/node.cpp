#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "graph/node_type.h"
#include "nodes/common/plot/plot.h"
#include "nodes/data/table.h"
#include "nodes/properties/property_interval/interval.h"
#include "runtime/context.h"

namespace terrazzo::property_interval {
namespace {

constexpr double kPrecision = 0.05;  // two standard deviations of a representative volume, relative
// Share of the extrapolation that may be wrong. In packings at 48³ voxels, the error left was 0.02 to 0.15 of
// changes above 9 % (docs/results/properties.md).
constexpr double kLeftError = 0.5;

// Values of a measure, and how much each differs from that at half the resolution, where that is known.
struct Values {
  std::vector<double> value, change;
  int unknown = 0;  // changes that are not known, or would change the value's sign: they are 0
};

// A row's number in a column, if it has one.
std::optional<double> number_at(const Table& table, std::size_t row, const std::string& column) {
  const int at = table.column(column);
  if (at < 0) return {};
  const auto* number = std::get_if<double>(&table.rows[row][at]);
  return number && std::isfinite(*number) ? std::optional(*number) : std::nullopt;
}

void add_value(const Table& table, const std::string& measure, const std::string& where, Values& to) {
  const auto error = [&](const std::string& what, const std::string& hint) {
    return Error("no-measure", where + what, hint).parameter("measure");
  };
  const int names = table.column("measure");
  for (std::size_t row = 0; names >= 0 && row < table.rows.size(); ++row) {
    const auto* name = std::get_if<std::string>(&table.rows[row][names]);
    if (!name || *name != measure) continue;
    const auto value = number_at(table, row, "value");
    if (!value)
      throw error(fmt::format(" has no number for '{}'", measure), "leave out what was not computed");
    to.value.push_back(*value);
    const auto half = number_at(table, row, "half_resolution");
    const bool known = half && *value * (2 * *value - *half) >= 0;
    to.unknown += !known;
    to.change.push_back(known ? *value - *half : 0);
    return;
  }
  throw error(fmt::format(" has no measure '{}'", measure),
              "connect tables of Homogenize, and name one of their measures");
}

Values values_of(const Context& c, const std::string& port, const std::string& measure) {
  Values out;
  for (const Value& v : c.list(port))
    add_value(v.as<Table>(), measure, fmt::format("table {} of {}", out.value.size() + 1, port), out);
  return out;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? 0 : sum / count_of(values);
}

// The values for infinitely small voxels, if the error is proportional to their edge (Richardson 1911).
std::vector<double> extrapolated(const Values& v) {
  std::vector<double> out = v.value;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] += v.change[i];
  return out;
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
  Values found = values_of(c, "blocks", measure), drawn = values_of(c, "draws", measure);
  if (const int unknown = found.unknown + drawn.unknown; unknown > 0) {
    c.warn(fmt::format(
        "{} of {} tables have no usable value at half the resolution, so none is extrapolated to smaller "
        "voxels",
        unknown, found.value.size() + drawn.value.size()));
    for (Values* v : {&found, &drawn}) std::fill(v->change.begin(), v->change.end(), 0);
  }
  const auto blocks = extrapolated(found), draws = extrapolated(drawn);
  const Interval i = interval_of(blocks, draws, kLeftError * mean_of(found.change), c.number("confidence"));
  Table table;
  table.columns = {"measure", "value"};
  const auto add = [&](const std::string& name, const std::string& metric, double value) {
    table.rows.push_back({name, value});
    if (!metric.empty()) c.metric(metric, value);
  };
  add("estimate", "estimate", i.estimate);
  add("mean at the blocks' resolution", "", mean_of(found.value));
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
  return NodeType("PropertyInterval", 2)
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
              "The estimate for infinitely small voxels with its interval, and what it comes from: the "
              "photograph, the block, the voxels. Blocks in a "
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
