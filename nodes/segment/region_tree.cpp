#include "nodes/segment/region_tree.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <queue>
#include <tuple>

#include "nodes/segment/region_graph.h"
#include "nodes/segment/watershed.h"

namespace terrazzo::segment {
namespace {

struct Contact {
  float length = 0, gradient = 0, closed = 0, light = 0;
  void operator+=(const Contact& o) {
    length += o.length, gradient += o.gradient, closed += o.closed, light += o.light;
  }
};

Eigen::Vector3d mean_color(const Candidate& c) { return c.color / c.area; }

Candidate united(const Candidate& a, const Candidate& b, const Contact& contact) {
  Candidate u;
  u.area = a.area + b.area, u.x = a.x + b.x, u.y = a.y + b.y;
  u.xx = a.xx + b.xx, u.yy = a.yy + b.yy, u.xy = a.xy + b.xy;
  u.gradient = a.gradient + b.gradient, u.color = a.color + b.color,
  u.color_square = a.color_square + b.color_square;
  u.border = a.border + b.border - 2 * contact.length;
  u.border_gradient = a.border_gradient + b.border_gradient - 2 * contact.gradient;
  u.border_closed = a.border_closed + b.border_closed - 2 * contact.closed;
  u.border_light = a.border_light + b.border_light - 2 * contact.light;
  return u;
}

double cost_of(const Candidate& a, const Candidate& b, const Contact& contact) {
  const double joint = a.area * b.area / (a.area + b.area);
  const double squares = joint * (mean_color(a) - mean_color(b)).squaredNorm() / contact.length;
  const double edge = contact.gradient / contact.length * std::pow(joint, 0.25) + 0.3 * std::sqrt(squares);
  const double neck = contact.length / std::sqrt(std::min(a.area, b.area));
  return edge * (1.3 - united(a, b, contact).ellipticity()) / std::min(1.5, 0.3 + neck);
}

// A current region while the tree grows: its candidate, and the slots of its neighbors.
struct Slot {
  int candidate = -1;  // −1 after merging into another
  std::map<int, Contact> contacts;
};

double difference_around(const std::vector<Slot>& slots, const std::vector<Candidate>& all, const Slot& s,
                         const Candidate& c) {
  double length = 0, sum = 0;
  for (const auto& [other, contact] : s.contacts) {
    length += contact.length;
    sum += contact.length * (mean_color(all[slots[other].candidate]) - mean_color(c)).norm();
  }
  return length > 0 ? sum / length : 0;
}

}  // namespace

double Candidate::ellipticity() const {
  const double mx = x / area, my = y / area;
  const double a = xx / area - mx * mx + 1 / 12.0, b = yy / area - my * my + 1 / 12.0,
               c = xy / area - mx * my;
  const double d = a * b - c * c;
  return d > 0 ? std::min(1.0, area / (4 * std::numbers::pi * std::sqrt(d))) : 1;
}

RegionTree build_region_tree(const Mosaic& m, const Work& work) {
  const LabImage soft = blur(m.smooth, 0.5f, work);
  const std::vector<float> gradient = gradient_of(soft);
  RegionTree tree;
  {
    auto sorted = gradient;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    tree.usual_gradient = *middle;
    RegionGraph graph(m.smooth, watershed(gradient, m.width, m.height, work),
                      std::vector<float>(gradient.size(), 1.0f));
    graph.merge(4.0 * m.contrast * m.contrast, work);
    tree.leaf = graph.labels();
  }
  for (auto& l : tree.leaf) --l;
  auto& all = tree.candidates;
  all.resize(*std::max_element(tree.leaf.begin(), tree.leaf.end()) + 1);
  std::vector<Slot> slots(all.size());
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x) {
      const std::size_t i = m.index(x, y);
      Candidate& c = all[tree.leaf[i]];
      c.area += 1, c.x += x, c.y += y, c.xx += x * x, c.yy += y * y, c.xy += static_cast<double>(x) * y;
      c.gradient += gradient[i];
      c.color += m.smooth.pixels[i].cast<double>();
      c.color_square += m.smooth.pixels[i].squaredNorm();
      auto edge = [&](std::size_t j) {
        const int a = tree.leaf[i], b = tree.leaf[j];
        if (a == b) return;
        const float g = std::max(gradient[i], gradient[j]);
        const Contact contact{1, g, g > 2 * tree.usual_gradient ? 1.0f : 0.0f,
                              std::min(m.smooth.pixels[i][0], m.smooth.pixels[j][0])};
        slots[a].contacts[b] += contact;
        slots[b].contacts[a] += contact;
        for (const int k : {a, b}) {
          all[k].border += 1, all[k].border_gradient += g;
          all[k].border_closed += contact.closed, all[k].border_light += contact.light;
        }
      };
      if (x + 1 < m.width) edge(i + 1);
      if (y + 1 < m.height) edge(i + m.width);
    }
  using Entry = std::tuple<double, int, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto cost = [&](int a, int b, const Contact& contact) {
    return cost_of(all[slots[a].candidate], all[slots[b].candidate], contact);
  };
  for (int k = 0; k < static_cast<int>(slots.size()); ++k) slots[k].candidate = k;
  for (int k = 0; k < static_cast<int>(slots.size()); ++k) {
    all[k].around = difference_around(slots, all, slots[k], all[k]);
    for (const auto& [other, contact] : slots[k].contacts)
      if (k < other) queue.emplace(cost(k, other, contact), k, other);
  }
  for (std::size_t step = 0; !queue.empty(); ++step) {
    if (step % 512 == 0) work.check();
    auto [stored, a, b] = queue.top();
    queue.pop();
    if (slots[a].candidate < 0 || slots[b].candidate < 0) continue;
    const auto found = slots[a].contacts.find(b);
    if (found == slots[a].contacts.end()) continue;
    const double now = cost(a, b, found->second);
    if (now > stored * (1 + 1e-9)) {
      queue.emplace(now, a, b);
      continue;
    }
    if (slots[a].contacts.size() < slots[b].contacts.size()) std::swap(a, b);
    const Contact contact = found->second;
    const int whole = static_cast<int>(all.size()), ca = slots[a].candidate, cb = slots[b].candidate;
    Candidate u = united(all[ca], all[cb], contact);
    u.left = ca, u.right = cb;
    all[ca].parent = all[cb].parent = whole;
    slots[a].contacts.erase(b);
    slots[b].contacts.erase(a);
    all.push_back(u);
    slots[a].candidate = whole;
    slots[b].candidate = -1;
    for (const auto& [c, part] : slots[b].contacts) {
      slots[c].contacts.erase(b);
      slots[c].contacts[a] += part;
      slots[a].contacts[c] += part;
    }
    for (const auto& [c, part] : slots[b].contacts) {
      const Contact& joint = slots[a].contacts[c];
      queue.emplace(cost(a, c, joint), std::min(a, c), std::max(a, c));
    }
    // A region that fills half of the image is not a particle, and visiting its many neighbors every time
    // would be slow.
    if (u.area < 0.5 * static_cast<double>(m.patches.size()))
      all[whole].around = difference_around(slots, all, slots[a], u);
    slots[b].contacts.clear();
  }
  return tree;
}

double particle_likeness(const Candidate& c, const RegionTree& tree) {
  if (c.border < 1) return 0;
  const double usual = tree.usual_gradient + 1e-5, at_border = c.border_gradient / c.border;
  const double inside = c.gradient / c.area;
  const Eigen::Vector3d mean = mean_color(c);
  const double z = -20.5 + 12 * c.ellipticity() + 4.9 * std::log((at_border + 1e-5) / (inside + 1e-5)) +
                   2.6 * c.border_closed / c.border + 0.4 * std::log(c.around / usual + 0.1) -
                   0.12 * (c.border_light / c.border - mean[0]) / usual;
  return 1 / (1 + std::exp(-z));
}

std::vector<std::int32_t> choose_particles(const RegionTree& tree, const Choice& choice) {
  const auto& all = tree.candidates;
  std::vector<double> best(all.size(), 0);
  std::vector<bool> taken(all.size(), false);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Candidate& c = all[k];
    if (c.left >= 0) best[k] = best[c.left] + best[c.right];
    if (c.area < choice.min_area || c.area > choice.max_area) continue;
    double likeness = particle_likeness(c, tree);
    if (choice.binder) {
      const double d2 = (mean_color(c).cast<float>() - *choice.binder).squaredNorm();
      likeness *= 1 - std::exp(-d2 / (2 * static_cast<double>(choice.tolerance) * choice.tolerance));
    }
    const double score = likeness - choice.threshold;
    if (score > 0 && score > best[k]) best[k] = score, taken[k] = true;
  }
  std::vector<std::int32_t> label(all.size(), 0), out(tree.leaf.size());
  std::int32_t count = 0;
  for (std::size_t k = all.size(); k-- > 0;) {
    if (all[k].parent >= 0) label[k] = label[all[k].parent];
    if (label[k] == 0 && taken[k]) label[k] = ++count;
  }
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = label[tree.leaf[i]];
  return out;
}

}  // namespace terrazzo::segment
