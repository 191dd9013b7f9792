#include "nodes/media/micrograph/learn_phases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "graph/diagnostic.h"
#include "nodes/common/texture/pixel_forest.h"
#include "nodes/media/micrograph/gray_picture.h"
#include "nodes/media/micrograph/phase_field.h"

namespace terrazzo::media {
namespace {

constexpr int kDecisions = 10;        // as in find_phases(): hardly a pixel changes afterwards
constexpr double kNoVote = 0.5 / 60;  // probability of a phase that none of 60 trees says: half a vote
constexpr double kNever = 1e6;        // cost of another phase under a stroke

using Votes = std::vector<std::vector<float>>;  // [phase][pixel], 0 to 1

// The phase of each stroke's pixels, the last one's if strokes overlap; kUnobserved elsewhere.
std::vector<std::uint8_t> marked(const std::vector<const Strokes*>& strokes, const GrayPicture& picture) {
  std::vector<std::uint8_t> out(picture.in.size(), kUnobserved);
  for (std::size_t k = 0; k < strokes.size(); ++k)
    for (const std::uint32_t at : stroked_pixels(strokes[k], picture.width, picture.height))
      if (picture.in[at]) out[at] = static_cast<std::uint8_t>(k);
  return out;
}

std::vector<TaughtClass> taught_by(const std::vector<std::uint8_t>& marks, int phases) {
  std::vector<TaughtClass> out(phases);
  for (int k = 0; k < phases; ++k) out[k].number = k;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (marks[i] != kUnobserved) out[marks[i]].pixels.push_back(static_cast<std::uint32_t>(i));
  for (const TaughtClass& t : out)
    if (t.pixels.empty())
      throw Error("no-strokes", fmt::format("no pixel is marked as phase {}", t.number),
                  "draw strokes on each phase, inside the picture, off the mask, and not over one another");
  return out;
}

// Strokes need not have their levels in order.
double separation_of(const PhaseLevels& levels) {
  std::vector<std::pair<double, double>> sorted;
  for (std::size_t k = 0; k < levels.level.size(); ++k) sorted.emplace_back(levels.level[k], levels.noise[k]);
  std::sort(sorted.begin(), sorted.end());
  PhaseLevels in_order;
  for (const auto& [level, noise] : sorted) {
    in_order.level.push_back(level);
    in_order.noise.push_back(noise);
  }
  return separation(in_order);
}

}  // namespace

double learn_forecast(const Image& image) { return 420.0 * pixels_in(image.width, image.height); }

FoundPhases learn_phases(const Image& image, const std::vector<std::uint8_t>& unobserved,
                         const std::vector<const Strokes*>& strokes, double smoothing, std::uint64_t seed,
                         const Work& work) {
  const int phases = count_of(strokes);
  if (phases < 2 || phases > kMostPhases)
    throw Error("wrong-count",
                fmt::format("strokes mark {} {}; 2 to {} are possible", phases,
                            phases == 1 ? "phase" : "phases", kMostPhases),
                "draw on each phase: one node Strokes for each");
  const GrayPicture picture = gray_picture(image, unobserved);
  const auto marks = marked(strokes, picture);
  const Votes votes = PixelForest(image, 0, taught_by(marks, phases), seed, work.part(0, 0.3))
                          .classify(image, 0, phases, work.part(0.3, 0.8));
  const auto cost = [&](int x, int y) {
    const std::size_t at = pixel_at(x, y, image.width);
    Costs out{};
    if (!picture.in[at]) return out;
    for (int k = 0; k < phases; ++k)
      out[k] = marks[at] == kUnobserved ? -std::log(std::max<double>(kNoVote, votes[k][at]))
                                        : (marks[at] == k ? 0 : kNever);
    return out;
  };
  PhaseField field{image.width, image.height, phases, smoothing, {}};
  for (std::size_t i = 0; i < marks.size(); ++i) {
    int best = 0;
    for (int k = 1; k < phases; ++k)
      if (votes[k][i] > votes[best][i]) best = k;
    field.label.push_back(static_cast<std::uint8_t>(best));
  }
  for (int round = 0; round < kDecisions; ++round) {
    field.decide(cost, work);
    work.part(0.8, 1).done(round + 1, kDecisions);
  }
  PhaseLevels levels{std::vector<double>(phases, 0), std::vector<double>(phases, 0)};
  measure(picture, field.label, levels);
  FoundPhases out = summary(image, picture, field.label, levels);
  out.separation = separation_of(levels);
  out.uncertain = field.uncertain(picture.in, cost);
  return out;
}

}  // namespace terrazzo::media
