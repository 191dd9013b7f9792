// Separates overlapping bodies by simultaneous translations and rotations in a periodic box.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "nodes/packing/rigid/contact/contact.h"
#include "nodes/packing/rigid/neighbors.h"

namespace terrazzo::packing {

// Radians: stones turn until their sides lean on others, but don't roll over.
inline constexpr double kMostTurn = 0.15;

// The bodies while they are packed, one entry per particle in every vector.
struct Packing {
  Vec3 box = Vec3::Zero();          // mm
  std::vector<std::int32_t> shape;  // index into the contact shapes
  std::vector<double> scale;        // of the mesh, as requested
  std::vector<double> size;         // mm, as requested: the unit of overlaps
  std::vector<Vec3> position;       // [0, box)
  std::vector<Quat> orientation;
  std::vector<Quat>
      home;           // orientations from which bodies turn by kMostTurn at most; empty: they turn freely
  double shrink = 1;  // actual size relative to the requested size, for all bodies
  // Deepest overlap found last, relative to the smaller body's size; 0: free. Infinite before any iteration.
  double overlap = std::numeric_limits<double>::infinity();
  std::size_t count() const { return position.size(); }
};

// Penetrations found by the contact code, relative to the smaller body's size.
struct Overlap {
  double worst = 0;          // deepest; ≤ 0: free
  double energy = 0;         // Σ depth²
  std::size_t pairs = 0;     // number of pairs that overlap
  std::size_t touching = 0;  // number of pairs closer than the target distance
  std::size_t tests = 0;     // work done to find the contacts; see Budget
};

// Of the pairs of both.
inline Overlap combined(Overlap x, const Overlap& y) {
  x.worst = std::max(x.worst, y.worst);
  x.energy += y.energy;
  x.pairs += y.pairs;
  x.touching += y.touching;
  x.tests += y.tests;
  return x;
}

// Additional distance between surfaces, for contacts that are known to be missed.
struct Margins {
  double all = 0;  // for every pair, relative to the smaller size
  std::map<std::pair<std::int32_t, std::int32_t>, double> of_pair;  // mm; lower index first
};

// Block Jacobi iteration on the contacts of all bodies with momentum (Polyak's heavy ball). Each body takes
// the displacement and rotation that would best satisfy the demands of all its contacts if only it moved,
// times `step_length`. With about 0.5 the bodies come to rest; towards 1 they overshoot, which agitates them
// like a temperature. Every contact is computed once, by one thread, and each body sums its contacts in a
// fixed order, so that the result has the same bits for any number of threads.
class Relaxation {
 public:
  Relaxation(const std::vector<ContactShape>& shapes, Packing& packing, double binder_gap);

  static constexpr double kCold = 0.5;  // a step length with which bodies come to rest
  ContactDetail detail = ContactDetail::Fine;
  double surplus = 0.002;  // target distance beyond the required one, in sizes; ensures termination
  double step_length = kCold, memory = 0.87;
  // Moves only bodies that overlap, and not those closer than the surplus. The others stay where they are, so
  // that the audit need not test them again.
  bool local = false;
  Margins extra;

  // One iteration. Returns the overlap found. Moves nothing if it is at most `enough`.
  Overlap step(double enough, const Work& work);
  // Returns the current overlap without moving anything; also updates strain().
  Overlap measure(const Work& work);
  // Whether all bodies are spheres.
  bool spheres() const { return spheres_; }
  // Deepest contact of each body, relative to its own size, as of the last step or measure.
  const std::vector<double>& strain() const { return strain_; }
  // Moves bodies randomly by up to amplitude · size and rotates them by up to 2 · amplitude radians per axis.
  // Only bodies whose strain exceeds `above` move.
  void shake(double amplitude, std::uint64_t seed, std::uint64_t round, double above, const Work& work);
  // Changes packing.shrink and keeps the lists of neighbors.
  void resize(double shrink);
  // Call after changing detail, surplus or extra from outside.
  void forget() { stale_ = true; }
  // Call after changing positions or orientations from outside.
  void rest();

 private:
  const std::vector<ContactShape>& shapes_;
  Packing& packing_;
  double binder_gap_;
  std::vector<Body> bodies_;
  std::vector<Pair> pairs_;
  Incidence incidence_;
  std::vector<Contact> contacts_;
  std::vector<double> extra_;  // per pair, mm
  std::vector<ContactCandidates> candidates_;
  std::vector<double> noted_;   // travel of both bodies when the candidates were collected
  std::vector<float> slack_;    // per pair, mm that both bodies may travel before they can touch
  std::vector<double> stamp_;   // travel of both bodies when slack_ was measured
  std::vector<double> travel_;  // accumulated travel of a body's surface, mm
  std::vector<Vec3> drift_;     // displacement since pairs_ was computed
  std::vector<Vec3> velocity_, spin_;
  std::vector<double> strain_;
  double skin_ = 0.1;  // reach_ in mean radii; grows if the neighbors had to be updated soon
  int steps_since_ = 10;
  double reach_ = 0, listed_ = 1;  // travel until the next update of neighbors; shrink at the last
  bool stale_ = true;

  // Packings of only spheres need no contacts: each body visits its neighbors directly.
  struct Neighbor {
    std::int32_t other;
    std::int32_t image;  // of 27; the central one is 13
  };
  bool spheres_ = false;
  std::vector<std::int32_t> first_neighbor_;  // n + 1
  std::vector<Neighbor> neighbors_;
  std::vector<double> radius_;  // at shrink 1
  std::vector<Vec3> wish_;

  void list_spheres();
  Overlap find_sphere_contacts(const Work& work);
  void move_spheres(const Work& work);

  double required_margin(std::size_t pair) const;
  void rebuild(const Work& work);
  Overlap find_contacts(const Work& work);
  void move(const Work& work);
  void end_move(double farthest);
  void wrap(std::size_t i);
  bool may_turn(std::size_t i, const Vec3& turn) const;
  void displace(std::size_t i, const Vec3& by, const Vec3& turn);
};

}  // namespace terrazzo::packing
