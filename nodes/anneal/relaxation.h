// Moves and turns overlapping bodies apart, all at once, in a periodic box.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "nodes/anneal/contact.h"
#include "nodes/anneal/neighbours.h"

namespace terrazzo::anneal {

// The bodies while they are packed. One entry a particle in every vector.
struct Packing {
  Vec3 box = Vec3::Zero();          // mm
  std::vector<std::int32_t> shape;  // index into the contact shapes
  std::vector<double> scale;        // of the mesh, as requested
  std::vector<double> size;         // mm, as requested: the unit in which overlaps are told
  std::vector<Vec3> position;       // [0, box)
  std::vector<Quat> orientation;
  double shrink = 1;  // all bodies are this much smaller than requested
  std::size_t count() const { return position.size(); }
};

// Penetrations as the contact code sees them, in units of the smaller body's size.
struct Overlap {
  double worst = 0;          // deepest; ≤ 0: free
  double energy = 0;         // Σ depth²
  std::size_t pairs = 0;     // that overlap
  std::size_t touching = 0;  // that are nearer than what is aimed for
};

// Further distance between surfaces, where contacts are known to be missed.
struct Margins {
  double all = 0;                                                   // of every pair, in the smaller size
  std::map<std::pair<std::int32_t, std::int32_t>, double> of_pair;  // mm; the lower index first
};

// A block Jacobi iteration on the contacts of all bodies with a memory of the last moves (Polyak's heavy
// ball): each body takes the displacement and turn that would meet all its contacts' demands best if only it
// moved, times `step_length`. About 0.5 comes to rest; towards 1 the bodies overshoot and are agitated as by
// a temperature. Every contact is found once, by one thread, and each body sums its own in a fixed order, so
// that the result has the same bits for any number of threads.
class Relaxation {
 public:
  Relaxation(const std::vector<ContactShape>& shapes, Packing& packing, double binder_gap);

  static constexpr double kCold = 0.5;  // a step length that comes to rest
  Detail detail = Detail::Fine;
  double surplus = 0.002;  // distance aimed for beyond what is asked, in sizes: makes the end finite
  double step_length = kCold, memory = 0.87;
  Margins extra;

  // One iteration. Returns the overlap found; moves nothing where it is no deeper than `enough`.
  Overlap step(double enough, const Work& work);
  // The overlap now, nothing moved; also fills strain().
  Overlap measure(const Work& work);
  // Whether all bodies are spheres.
  bool spheres() const { return spheres_; }
  // Deepest contact of each body, in its own size, as of the last step or measure.
  const std::vector<double>& strain() const { return strain_; }
  // Moves bodies at random by up to amplitude · size, and turns them by up to 2 · amplitude radians: all, or
  // those whose strain is above `above`.
  void shake(double amplitude, std::uint64_t seed, std::uint64_t round, double above, const Work& work);
  // Changes packing.shrink, keeping what is known of the neighbours.
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
  std::vector<double> extra_;  // of a pair, mm
  std::vector<ContactCandidates> candidates_;
  std::vector<double> noted_;   // travel of both bodies when the candidates were collected
  std::vector<float> slack_;    // of a pair, mm that both bodies may travel before they can touch
  std::vector<double> stamp_;   // travel of both bodies when slack was measured
  std::vector<double> travel_;  // of a body's surface, mm, summed
  std::vector<Vec3> drift_;     // displacement since pairs_ was made
  std::vector<Vec3> velocity_, spin_;
  std::vector<double> strain_;
  double skin_ = 0.1;  // reach_ in mean radii: wider the sooner neighbours had to be found anew
  int steps_since_ = 10;
  double reach_ = 0, listed_ = 1;  // travel allowed until neighbours are found anew; shrink when they were
  bool stale_ = true;

  // Packings of spheres alone need no contacts: each body looks at its neighbours itself.
  struct Neighbour {
    std::int32_t other;
    std::int32_t image;  // of 27, the middle one 13
  };
  bool spheres_ = false;
  std::vector<std::int32_t> first_neighbour_;  // n + 1
  std::vector<Neighbour> neighbours_;
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
  void displace(std::size_t i, const Vec3& by, const Vec3& turn);
};

}  // namespace terrazzo::anneal
