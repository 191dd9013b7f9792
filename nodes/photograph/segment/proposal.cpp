#include "nodes/photograph/segment/proposal.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "nodes/data/indices.h"
#include "nodes/photograph/segment/color/mosaic.h"
#include "nodes/photograph/segment/color/two_materials.h"
#include "nodes/photograph/segment/outline/contacts.h"
#include "nodes/photograph/segment/outline/fill_gaps.h"
#include "nodes/photograph/segment/outline/smooth_outlines.h"

namespace terrazzo::segment {

std::vector<double> confidences_of(std::vector<double> scores) {
  for (double& s : scores) s = confidence_of_score(s);
  return scores;
}

void Proposal::add(Particles2D found, const std::vector<double>& judged) {
  const std::int32_t before = labels.count();
  for (const auto l : found.labels) labels.ids.push_back(l == 0 ? 0 : l + before);
  labels.classes.resize(before + judged.size(), 0);
  confidence.insert(confidence.end(), judged.begin(), judged.end());
  coverage.insert(coverage.end(), found.coverage.begin(), found.coverage.end());
  min_area = found.min_area;
  specks += found.specks;
  speck_pixels += found.speck_pixels;
  holes += found.holes;
}

void Proposal::add_chosen(NetworkView::Found chosen) {
  add(std::move(chosen.particles), confidences_of(chosen.scores));
}

void Proposal::fill(int section, const Image& image, const NetworkView* judge, const Work& work) {
  const std::size_t plane = pixels_in(image.width, image.height);
  if (section == 0) {
    filled_ = {};
    filled_confidence_ = {};
  }
  const auto begin = labels.ids.begin() + (section * plane);
  std::vector<std::int32_t> own(begin, begin + static_cast<std::ptrdiff_t>(plane));
  std::map<std::int32_t, std::int32_t> names;  // numbers of all sections → 1 to n
  for (auto& id : own)
    if (id > 0) id = names.try_emplace(id, static_cast<std::int32_t>(names.size()) + 1).first->second;
  const std::int32_t count = fill_gaps(own, image, section);
  std::vector<double> judged(count, 1);
  if (judge) judged = confidences_of(judge->scores(own, count, work.quiet()));
  const std::int32_t before = filled_confidence_.size();
  for (const auto id : own) filled_.push_back(id + before);
  filled_confidence_.insert(filled_confidence_.end(), judged.begin(), judged.end());
  if (section + 1 < image.sections) return;
  labels.ids = std::move(filled_);
  confidence = std::move(filled_confidence_);
  labels.classes.assign(confidence.size(), 0);
  coverage.assign(coverage.size(), 1);
}

void Proposal::refine(int section, const Image& image, const Work& work) {
  const auto plane = static_cast<std::ptrdiff_t>(image.width) * image.height, first = section * plane;
  std::vector<std::int32_t> ids(labels.ids.begin() + first, labels.ids.begin() + first + plane);
  std::vector<float> shares(coverage.begin() + first, coverage.begin() + first + plane);
  const LabImage colors = patch_section(image, section, work);
  for (const auto parent : split_two_materials(colors, ids, labels.count() + 1, work)) {
    labels.classes.push_back(0);
    confidence.push_back(confidence[parent - 1]);
  }
  open_contacts(image, section, colors, ids, shares, work);
  smooth_outlines(colors, ids, shares, work);
  std::copy(ids.begin(), ids.end(), labels.ids.begin() + first);
  std::copy(shares.begin(), shares.end(), coverage.begin() + first);
  if (section + 1 == image.sections) renumber(plane);
}

// Numbers the particles in the order of their sections, since splitting appends numbers.
void Proposal::renumber(std::size_t plane) {
  std::vector<std::int32_t> number(confidence.size() + 1, 0);
  std::vector<double> ordered;
  for (std::size_t first = 0; first < labels.ids.size(); first += plane) {
    std::vector<std::int32_t> here(labels.ids.begin() + first, labels.ids.begin() + (first + plane));
    std::sort(here.begin(), here.end());
    here.erase(std::unique(here.begin(), here.end()), here.end());
    for (const auto id : here) {
      if (id == 0) continue;
      ordered.push_back(confidence[id - 1]);
      number[id] = ordered.size();
    }
  }
  for (auto& id : labels.ids) id = number[id];
  confidence = std::move(ordered);
  labels.classes.assign(confidence.size(), 0);
}

double Proposal::left_out_by(const Proposal& other) const {
  double all = 0, out = 0;
  for (std::size_t i = 0; i < labels.ids.size(); ++i)
    if (const auto id = labels.ids[i]; id > 0) {
      const double sure = confidence[id - 1];
      all += sure;
      if (other.labels.ids[i] == 0) out += sure;
    }
  return all > 0 ? out / all : 0;
}

Proposal::Weight Proposal::weight() const {
  std::vector<double> area(confidence.size(), 0);
  for (const auto id : labels.ids)
    if (id > 0) ++area[id - 1];
  Weight w;
  for (std::size_t k = 0; k < area.size(); ++k) {
    w.right += std::sqrt(area[k]) * confidence[k];
    w.found += std::sqrt(area[k]);
  }
  return w;
}

}  // namespace terrazzo::segment
