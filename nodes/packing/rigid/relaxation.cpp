#include "nodes/packing/rigid/relaxation.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/periodic.h"
#include "runtime/random.h"

namespace terrazzo::packing {

namespace {

constexpr double kCandidateSlack = 0.015;  // motion for which candidates are collected, in sizes
constexpr float kRidge = 0.1f;             // keeps a body with one contact from rotating instead of moving

void add(Demand& sum, const Demand& d) {
  for (int k = 0; k < 21; ++k) sum.square[k] += d.square[k];
  for (int k = 0; k < 6; ++k) sum.side[k] += d.side[k];
}

// The displacement and rotation that best satisfy the demand; rotations are weighted by `arm`.
void solve(const Demand& demand, double arm, Vec3& dx, Vec3& dw) {
  Eigen::Matrix<float, 6, 6> m;
  Eigen::Matrix<float, 6, 1> r;
  const float inverse = 1 / arm;
  int at = 0;
  for (int i = 0; i < 6; ++i) {
    const float si = i < 3 ? 1 : inverse;
    r[i] = demand.side[i] * si;
    for (int j = i; j < 6; ++j) m(j, i) = demand.square[at++] * si * (j < 3 ? 1 : inverse);
    m(i, i) += kRidge;
  }
  const Eigen::Matrix<float, 6, 1> x = m.selfadjointView<Eigen::Lower>().llt().solve(r);
  dx = x.head<3>().cast<double>();
  dw = x.tail<3>().cast<double>() / arm;
}

Quat turned(const Quat& q, const Vec3& turn) {
  return (Quat(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * q).normalized();
}

}  // namespace

Relaxation::Relaxation(const std::vector<ContactShape>& shapes, Packing& packing, double binder_gap)
    : shapes_(shapes),
      packing_(packing),
      binder_gap_(binder_gap),
      bodies_(packing.count()),
      travel_(packing.count(), 0.0),
      drift_(packing.count(), Vec3::Zero()),
      velocity_(packing.count(), Vec3::Zero()),
      spin_(packing.count(), Vec3::Zero()),
      strain_(packing.count(), 0.0) {
  spheres_ = true;
  for (std::int32_t s : packing.shape)
    spheres_ = spheres_ && shapes[s].field.kind() == DistanceField::Kind::Sphere;
}

double Relaxation::required_margin(std::size_t pair) const {
  const Pair& p = pairs_[pair];
  return binder_gap_ + extra_[pair] +
         packing_.shrink * (shapes_[packing_.shape[p.a]].error * packing_.scale[p.a] +
                            shapes_[packing_.shape[p.b]].error * packing_.scale[p.b]);
}

void Relaxation::rebuild(const Work& work) {
  const std::size_t n = packing_.count();
  for (std::size_t i = 0; i < n; ++i) wrap(i);
  std::vector<double> radius(n);
  double mean = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const ContactShape& shape = shapes_[packing_.shape[i]];
    bodies_[i].shape = &shape;
    bodies_[i].scale = packing_.scale[i] * packing_.shrink;
    bodies_[i].rotation = packing_.orientation[i].toRotationMatrix().cast<float>();
    // Each body gets half of each pair's margin. A pair's surplus is relative to the smaller size, so that
    // the halves of both bodies suffice.
    radius[i] = shape.bounding_radius * packing_.scale[i] * packing_.shrink + 0.5 * binder_gap_ +
                shape.error * packing_.scale[i] + 0.5 * (surplus + extra.all) * packing_.size[i];
    mean += radius[i];
    drift_[i].setZero();
  }
  for (const auto& [pair, margin] : extra.of_pair) {
    radius[pair.first] += margin;
    radius[pair.second] += margin;
  }
  if (steps_since_ < 6) skin_ = std::min(0.35, 1.4 * skin_);
  if (steps_since_ > 25) skin_ = std::max(0.05, 0.8 * skin_);
  steps_since_ = 0;
  reach_ = skin_ * mean / (std::max<std::size_t>(n, 1));
  pairs_ = near_pairs(packing_.box, packing_.position, radius, 3 * reach_, work);
  listed_ = packing_.shrink;
  stale_ = false;
  if (spheres_ && extra.of_pair.empty()) {
    list_spheres();
    return;
  }
  neighbors_.clear();
  first_neighbor_.clear();
  incidence_ = incidence_of(n, pairs_);
  extra_.resize(pairs_.size());
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const Pair& p = pairs_[k];
    extra_[k] = extra.all * std::min(packing_.size[p.a], packing_.size[p.b]);
    if (extra.of_pair.empty()) continue;
    if (const auto at = extra.of_pair.find({p.a, p.b}); at != extra.of_pair.end()) extra_[k] += at->second;
  }
  contacts_.assign(pairs_.size(), Contact{});
  candidates_.resize(pairs_.size());
  for (auto& c : candidates_) c.known = false;
  noted_.assign(pairs_.size(), 0.0);
  slack_.assign(pairs_.size(), -1.f);
  stamp_.assign(pairs_.size(), 0.0);
}

Overlap Relaxation::find_contacts(const Work& work) {
  if (stale_) rebuild(work);
  if (!first_neighbor_.empty()) return find_sphere_contacts(work);
  Overlap none;
  none.worst = -1;
  return work.reduce<Overlap>(
      pairs_.size(), 256, none,
      [&](std::size_t begin, std::size_t end) {
        Overlap sum = none;
        sum.tests = end - begin;
        for (std::size_t k = begin; k < end; ++k) {
          const Pair& p = pairs_[k];
          const double travelled = travel_[p.a] + travel_[p.b];
          if (travelled - stamp_[k] < slack_[k]) continue;  // contacts_[k].depth is still 0
          const double required = required_margin(k);
          const double margin = required + surplus * std::min(packing_.size[p.a], packing_.size[p.b]);
          const Vec3 offset = offset_of(p, packing_.box, packing_.position);
          const double size = std::min(packing_.size[p.a], packing_.size[p.b]) * packing_.shrink;
          const double slack = kCandidateSlack * size;
          ContactCandidates& candidates = candidates_[k];
          if (candidates.known && travelled - noted_[k] > 0.99 * slack) candidates.known = false;
          if (!candidates.known) noted_[k] = travelled;
          contacts_[k] = find_contact(bodies_[p.a], bodies_[p.b], offset.cast<float>(), margin, detail,
                                      candidates, slack);
          sum.tests += contacts_[k].tests;
          // Other elements may come as close as the remaining slack.
          const double left = candidates.known ? slack - (travelled - noted_[k]) : 1e300;
          slack_[k] =
              contacts_[k].depth > 0 ? -1.f : static_cast<float>(std::min<double>(contacts_[k].gap, left));
          stamp_[k] = travelled;
          if (contacts_[k].depth > 0) {
            const double depth = (contacts_[k].depth - (margin - required)) / size;
            sum.worst = std::max(sum.worst, depth);
            ++sum.touching;
            if (depth > 0) {
              sum.energy += depth * depth;
              ++sum.pairs;
            }
          }
        }
        return sum;
      },
      combined);
}

// Turning back is always possible.
bool Relaxation::may_turn(std::size_t i, const Vec3& turn) const {
  if (packing_.home.empty() || turn.isZero(0)) return true;
  const Quat &home = packing_.home[i], &now = packing_.orientation[i];
  const double after = home.angularDistance(turned(now, turn));
  return after <= kMostTurn || after <= home.angularDistance(now);
}

void Relaxation::displace(std::size_t i, const Vec3& by, const Vec3& turn) {
  Vec3& p = packing_.position[i];
  p += by;
  drift_[i] += by;
  double moved = by.norm();
  const double angle = turn.norm();
  if (angle > 1e-12) {
    Quat& q = packing_.orientation[i];
    q = turned(q, turn);
    bodies_[i].rotation = q.toRotationMatrix().cast<float>();
    moved += angle * bodies_[i].shape->bounding_radius * bodies_[i].scale;
  }
  travel_[i] += moved * 1.0001;
}

void Relaxation::move(const Work& work) {
  const std::size_t n = packing_.count();
  const double farthest = work.reduce<double>(
      n, 512, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double far = 0;
        for (std::size_t i = begin; i < end; ++i) {
          Demand demand;
          float deepest = 0;
          int touching = 0;
          bool overlaps = !local;
          for (std::int32_t e = incidence_.begin[i]; e < incidence_.begin[i + 1]; ++e) {
            const Contact& c = contacts_[incidence_.entry[e] >> 1];
            if (!(c.depth > 0)) continue;
            const Pair& p = pairs_[incidence_.entry[e] >> 1];
            overlaps = overlaps || c.depth > surplus * std::min(packing_.size[p.a], packing_.size[p.b]);
            add(demand, (incidence_.entry[e] & 1) == 0 ? c.a : c.b);
            deepest = std::max(deepest, c.depth);
            ++touching;
          }
          strain_[i] = deepest / packing_.size[i];
          Vec3 v = Vec3::Zero(), w = Vec3::Zero();
          if (touching > 0 && overlaps) {
            const double arm = bodies_[i].shape->gyration * bodies_[i].scale;
            Vec3 dx, dw;
            solve(demand, arm, dx, dw);
            dx *= step_length;
            dw *= step_length;
            const bool on = velocity_[i].dot(dx) + spin_[i].dot(dw) * arm * arm > 0;
            v = dx + (on ? memory : 0.0) * velocity_[i];
            w = dw + (on ? memory : 0.0) * spin_[i];
            const double limit = 0.1 * packing_.size[i], turn_limit = 0.2;
            if (v.norm() > limit) v *= limit / v.norm();
            if (w.norm() > turn_limit) w *= turn_limit / w.norm();
          } else {
            v = 0.5 * velocity_[i];
            w = 0.5 * spin_[i];
            if (v.norm() < 1e-4 * packing_.size[i]) v.setZero();
            if (w.norm() < 1e-4) w.setZero();
          }
          if (!may_turn(i, w)) w.setZero();
          velocity_[i] = v;
          spin_[i] = w;
          if (v.isZero(0) && w.isZero(0)) continue;
          displace(i, v, w);
          far = std::max(far, drift_[i].norm());
        }
        return far;
      },
      [](double x, double y) { return std::max(x, y); });
  end_move(farthest);
}

// Between rebuilds, positions may leave the box slightly, so that the images of the pairs stay valid.
void Relaxation::end_move(double farthest) {
  if (farthest <= reach_) return;
  for (std::size_t i = 0; i < packing_.count(); ++i) wrap(i);
  stale_ = true;
}

void Relaxation::resize(double shrink) {
  if (shrink == packing_.shrink) return;
  const double change = std::abs(shrink - packing_.shrink);
  packing_.shrink = shrink;
  if (stale_) return;
  double largest = 0;
  for (std::size_t i = 0; i < packing_.count(); ++i) {
    Body& body = bodies_[i];
    const double radius = body.shape->bounding_radius * packing_.scale[i];
    body.scale = packing_.scale[i] * shrink;
    travel_[i] += radius * change;
    largest = std::max(largest, radius);
  }
  if (largest * (shrink - listed_) > 0.5 * reach_) stale_ = true;
}

void Relaxation::wrap(std::size_t i) {
  packing_.position[i] = wrap_point(packing_.position[i], packing_.box);
}

Overlap Relaxation::step(double enough, const Work& work) {
  const Overlap found = find_contacts(work);
  ++steps_since_;
  if (found.worst > enough) {
    if (first_neighbor_.empty())
      move(work);
    else
      move_spheres(work);
  }
  return found;
}

Overlap Relaxation::measure(const Work& work) {
  const Overlap found = find_contacts(work);
  if (!first_neighbor_.empty()) return found;
  for (std::size_t i = 0; i < packing_.count(); ++i) {
    float deepest = 0;
    for (std::int32_t e = incidence_.begin[i]; e < incidence_.begin[i + 1]; ++e)
      deepest = std::max(deepest, contacts_[incidence_.entry[e] >> 1].depth);
    strain_[i] = deepest / packing_.size[i];
  }
  return found;
}

void Relaxation::shake(double amplitude, std::uint64_t seed, std::uint64_t round, double above,
                       const Work& work) {
  rest();
  work.parallel(packing_.count(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (strain_[i] <= above) continue;
      Random random(seed, mix64(0x7368616b65 + round), i);
      const auto direction = [&] {
        return Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      };
      packing_.position[i] += amplitude * packing_.size[i] * direction();
      const Vec3 turn = 2 * amplitude * direction();
      if (turn.norm() > 0 && may_turn(i, turn))
        packing_.orientation[i] = turned(packing_.orientation[i], turn);
      wrap(i);
    }
  });
}

void Relaxation::rest() {
  for (std::size_t i = 0; i < packing_.count(); ++i) {
    velocity_[i].setZero();
    spin_[i].setZero();
    wrap(i);
  }
  stale_ = true;
}

}  // namespace terrazzo::packing
