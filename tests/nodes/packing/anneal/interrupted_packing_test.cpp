// Packings that are canceled and continued.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "nodes/packing/rigid/audit.h"
#include "nodes/packing/rigid/packing.h"
#include "nodes/packing/rigid/shrunk_start.h"
#include "runtime/session.h"
#include "tests/nodes/packing/anneal/packing_support.h"
#include "tests/nodes/packing/load_particles/particles_support.h"
#include "tests/support/all_nodes.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using packing::InterruptedPacking;
using packing::OnJam;

// A request, which can be canceled at a report of its progress.
struct Request {
  Shapes shapes;
  SizeDistribution distribution;
  packing::PackOptions options;
  int reports = 0;                            // of the last run
  std::optional<packing::PackResult> result;  // of the last run, if it was not canceled

  // The packing that was reached when it was canceled at report `stop`, if any.
  std::optional<InterruptedPacking> run(int stop, const Particles* start = nullptr) {
    std::atomic<bool> cancel{false};
    std::optional<InterruptedPacking> reached;
    options.interrupted = [&](const InterruptedPacking& p) { reached = p; };
    reports = 0;
    result.reset();
    const Work::Report report = [&](double, const std::string&) { cancel = ++reports == stop || cancel; };
    try {
      result = packing::pack_particles(distribution, shapes, start, options, Work(&cancel, &report));
    } catch (const Cancelled&) {
    }
    return reached;
  }
  double fraction(const Particles& p) const { return packing::volume_fraction(shapes, p); }
};

// Spheres that reach their size, spheres that jam, and bodies that are not round.
Request easy_spheres() {
  Request r;
  r.shapes = test::shapes_of({test::icosphere(2)});
  r.distribution = test::distribution(r.shapes, 1, 2, 0.5);
  r.options.population.count = 150;
  return r;
}
Request jammed_spheres(OnJam on_jam) {
  Request r;
  r.shapes = test::shapes_of({test::icosphere(3)});
  r.distribution = test::distribution(r.shapes, 1, 1.3, 0.72);
  r.options.population.count = 120;
  r.options.on_jam = on_jam;
  r.options.iterations = 1200;
  return r;
}
Request dense_bodies() {
  Request r;
  r.shapes = test::shapes_of({test::peanut(2), test::cube()});
  r.distribution = test::distribution(r.shapes, 1, 2, 0.6);
  r.options.population.count = 100;
  r.options.iterations = 800;
  r.options.on_jam = OnJam::Shrink;
  return r;
}
// More than 600 particles, so that an estimate comes first and all are shrunk beforehand.
Request estimated_spheres() {
  Request r = jammed_spheres(OnJam::Shrink);
  r.distribution = test::distribution(r.shapes, 1, 1.3, 0.85);
  r.options.population.count = 700;
  r.options.iterations = 400;
  return r;
}

void expect_whole(const Request& r, const Particles& p) {
  EXPECT_GT(r.fraction(p), 0);
  for (std::size_t i = 0; i < p.count(); ++i) {
    EXPECT_GE(p.position[i].minCoeff(), 0);
    EXPECT_GT((p.box - p.position[i]).minCoeff(), 0);
    EXPECT_NEAR(p.orientation[i].norm(), 1, 1e-9);
    EXPECT_NEAR(p.scale[i] * r.shapes.shapes[p.shape[i]].size(), p.size[i], 1e-9);
  }
}

// Cancels at several reports. What was reached continues at its density, and ends at least as dense.
void expect_resumable(Request r) {
  r.run(0);
  const int all = r.reports;
  ASSERT_TRUE(r.result);
  const auto whole = r.result->particles;
  int saved = 0;
  for (int stop = std::max(1, all / 7); stop < all; stop += std::max(1, all / 5)) {
    const auto reached = r.run(stop);
    EXPECT_FALSE(r.result);
    if (!reached) continue;  // it was canceled before particles were moved
    ++saved;
    expect_whole(r, reached->particles);
    EXPECT_EQ(reached->particles.box, whole.box);
    const double density = r.fraction(reached->particles);
    if (reached->overlap <= packing::kTolerance) {
      EXPECT_LT(packing::audit(r.shapes, reached->particles).worst, 0.02) << "at report " << stop;
    }
    // Canceled again at its first move, it has lost nothing.
    for (int again = 1; again < 40; ++again)
      if (const auto next = r.run(again, &reached->particles)) {
        EXPECT_GE(r.fraction(next->particles), density * (1 - 1e-6))
            << "at reports " << stop << ", " << again;
        break;
      }
    r.run(0, &reached->particles);
    ASSERT_TRUE(r.result);
    EXPECT_EQ(r.result->kept, r.result->particles.count());
    EXPECT_LE(r.result->max_penetration, packing::kTolerance);
    // Particles that are left out later take their volume with them.
    if (reached->overlap <= packing::kTolerance && r.options.on_jam != OnJam::Drop)
      EXPECT_GE(r.fraction(r.result->particles), density * (1 - 1e-3)) << "at report " << stop;
    else
      EXPECT_GE(r.fraction(r.result->particles), 0.95 * r.fraction(whole)) << "at report " << stop;
  }
  EXPECT_GE(saved, 2);
}

TEST(InterruptedPacking, SpheresContinue) { expect_resumable(easy_spheres()); }
TEST(InterruptedPacking, JammedSpheresThatMayShrinkContinue) {
  expect_resumable(jammed_spheres(OnJam::Shrink));
}
TEST(InterruptedPacking, JammedSpheresThatMayBeLeftOutContinue) {
  expect_resumable(jammed_spheres(OnJam::Drop));
}
TEST(InterruptedPacking, OtherBodiesContinue) { expect_resumable(dense_bodies()); }
TEST(InterruptedPacking, ParticlesShrunkBeforehandContinue) { expect_resumable(estimated_spheres()); }

// Sizes are those of the request again, to the last bits.
TEST(InterruptedPacking, ParticlesRegainTheirSize) {
  Request r = easy_spheres();
  r.run(0);
  const auto whole = r.result->particles;
  std::optional<InterruptedPacking> reached;
  for (int stop = 1; !reached; ++stop) reached = r.run(stop);  // while they grow
  ASSERT_LT(reached->particles.size[0], 0.99 * whole.size[0]);
  r.run(0, &reached->particles);
  ASSERT_TRUE(r.result);
  EXPECT_EQ(r.result->particles.size, whole.size);
  EXPECT_EQ(r.result->particles.shape, whole.shape);
  EXPECT_EQ(r.result->shrink, 1);
}

TEST(InterruptedPacking, NothingIsSavedBeforeParticlesMove) {
  Request r = easy_spheres();
  EXPECT_FALSE(r.run(1));
  EXPECT_FALSE(r.result);
}

TEST(InterruptedPacking, NothingIsSavedWithoutACancellation) {
  Request r = easy_spheres();
  EXPECT_FALSE(r.run(0));
  r = jammed_spheres(OnJam::Fail);
  r.options.iterations = 200;
  bool saved = false;
  r.options.interrupted = [&](const InterruptedPacking&) { saved = true; };
  const auto pack_them = [&] { packing::pack_particles(r.distribution, r.shapes, nullptr, r.options); };
  EXPECT_THROW(pack_them(), Error);
  EXPECT_FALSE(saved);
}

TEST(InterruptedPacking, AStartOfAnotherRequestIsNotRegrown) {
  Request r = easy_spheres();
  const packing::Population fresh =
      packing::populate(r.distribution, r.shapes, nullptr, r.options.population);
  Particles start = fresh.particles;
  for (auto& q : start.orientation) q = Quat::Identity();
  EXPECT_FALSE(packing::regrown(fresh, start));  // nothing was shrunk
  for (auto& s : start.size) s *= 0.9;
  const auto grown = packing::regrown(fresh, start);
  ASSERT_TRUE(grown);
  EXPECT_NEAR(grown->start_shrink, 0.9, 1e-12);
  EXPECT_EQ(grown->particles.size, fresh.particles.size);
  EXPECT_EQ(grown->kept, start.count());
  Particles other = start;
  other.size[7] *= 1.001;
  EXPECT_FALSE(packing::regrown(fresh, other));
  other = start;
  other.box *= 1.01;
  EXPECT_FALSE(packing::regrown(fresh, other));
  other = start;
  other.cls[3] += 1;
  EXPECT_FALSE(packing::regrown(fresh, other));
  other = start;
  other.position[2][1] = std::nan("");
  EXPECT_FALSE(packing::regrown(fresh, other));
}

TEST(InterruptedPacking, ParticlesThatWereLeftOutStayOut) {
  Request r = easy_spheres();
  const packing::Population fresh =
      packing::populate(r.distribution, r.shapes, nullptr, r.options.population);
  Particles start;
  start.box = fresh.particles.box;
  for (std::size_t i = 0; i < fresh.particles.count(); ++i) {
    if (i % 9 == 0) continue;
    start.resize(start.count() + 1);
    start.shape.back() = fresh.particles.shape[i], start.cls.back() = fresh.particles.cls[i];
    start.size.back() = 0.8 * fresh.particles.size[i];
  }
  const auto grown = packing::regrown(fresh, start);
  ASSERT_TRUE(grown);
  EXPECT_EQ(grown->kept, start.count());
  EXPECT_EQ(grown->particles.count(), fresh.particles.count());
  for (std::size_t i = 0; i < start.count(); ++i)
    EXPECT_EQ(grown->particles.size[i], fresh.particles.size[i / 8 * 9 + i % 8 + 1]) << i;
}

// --- Through the runtime, as an editor or the command line does it.

std::string graph_of(const std::string& type, const std::string& start = {}) {
  return "terrazzo: 1\nnodes:\n"
         "  ball: {type: Shape, params: {kind: ellipsoid, size: 1}}\n"
         "  sizes: {type: Distribution, params: {kind: lognormal, mean: 1, sd: 0.2, min: 0.6, max: 1.6, "
         "volume_fraction: 0.5}}\n" +
         (start.empty() ? "" : "  so_far: {type: LoadParticles, params: {path: '" + start + "'}}\n") +
         "  pack: {type: " + type +
         ", params: {count: 150, size: [7, 6, 6.5], seed: 3}, inputs: {distribution: sizes.distribution, "
         "shapes: ball.shapes" +
         (start.empty() ? "" : ", start: so_far.particles") + "}}\n";
}

// Cancels the evaluation at the first report of the node `pack` with a note on its penetration.
struct Stop : Observer {
  std::atomic<Evaluation*> evaluation{nullptr};
  bool stopped = false;
  void progress(int, double, const std::string& note) override {
    if (stopped || note.find("penetration") == std::string::npos) return;
    while (!evaluation) {
    }
    evaluation.load()->cancel();
    stopped = true;
  }
};

NodeResult result_of(Session& session, const std::string& graph, Observer* observer, Stop* stop) {
  for (const auto& d : session.open_text(graph, test::temporary_folder() / "g.yaml"))
    ADD_FAILURE() << d.text();
  const auto running = session.evaluate({"pack"}, observer);
  if (stop) stop->evaluation = running.get();
  const auto& result = running->wait();
  for (const auto& n : result.nodes)
    if (n.error) ADD_FAILURE() << n.error->text();
  return result.nodes.at(static_cast<std::size_t>(running->graph().find("pack")));
}

class InterruptedNode : public ::testing::TestWithParam<const char*> {
 protected:
  static const ValueTypes& types() {
    static const ValueTypes all = [] {
      ValueTypes t;
      register_value_types(t);
      return t;
    }();
    return all;
  }
};

TEST_P(InterruptedNode, LeavesAFileFromWhichItContinues) {
  const fs::path out = test::temporary_folder();
  Session session(test::all_nodes(), types(), {.output_folder = out});
  Stop stop;
  const NodeResult first = result_of(session, graph_of(GetParam()), &stop, &stop);
  EXPECT_EQ(first.status, Status::Cancelled);
  ASSERT_TRUE(first.saved);
  ASSERT_EQ(first.saved->file, out / "pack.interrupted.json") << first.saved->message.text();
  EXPECT_NE(first.saved->message.message.find("volume fraction"), std::string::npos);
  EXPECT_NE(first.saved->message.hint.find("LoadParticles"), std::string::npos);

  const Particles reached = test::loaded(first.saved->file);
  EXPECT_EQ(reached.box, Vec3(7, 6, 6.5));
  const NodeResult resumed =
      result_of(session, graph_of(GetParam(), first.saved->file.string()), nullptr, nullptr);
  EXPECT_EQ(resumed.status, Status::Computed);
  EXPECT_EQ(resumed.metrics.at("particles"), static_cast<double>(reached.count()));
  EXPECT_NEAR(resumed.metrics.at("packing_fraction"), 0.5, 0.01);

  // The interruption changes neither keys nor results of the original request.
  const NodeResult again = result_of(session, graph_of(GetParam()), nullptr, nullptr);
  Session other(test::all_nodes(), types(), {.output_folder = out});
  const NodeResult never = result_of(other, graph_of(GetParam()), nullptr, nullptr);
  EXPECT_EQ(again.status, Status::Computed);
  EXPECT_EQ(first.key, never.key);
  EXPECT_EQ(again.outputs, never.outputs);
}

INSTANTIATE_TEST_SUITE_P(Nodes, InterruptedNode, ::testing::Values("Anneal", "Pack"),
                         [](const auto& i) { return std::string(i.param); });

}  // namespace
}  // namespace terrazzo
