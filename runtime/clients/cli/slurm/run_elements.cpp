#include "runtime/clients/cli/slurm/run_elements.h"

#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>
#include <set>

#include "runtime/clients/cli/slurm/slurm_detached.h"
#include "runtime/clients/cli/slurm/slurm_executor.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
using nlohmann::json;

fs::path round_folder(const fs::path& out, std::size_t round) {
  return out / fmt::format("elements-{}", round);
}

namespace {

DetachablePlan detachable_plan(const std::vector<SweepPlan>& plans, const GraphOptions& o) {
  DetachablePlan out;
  out.sweep_file = round_folder(o.out, 1) / "sweep.json";
  std::string hashes;
  for (std::size_t k = 0; k < plans.size(); ++k) {
    const Hash hash = plans[k].file.hash();
    hashes += hash.text();
    out.job_prefixes.push_back(slurm_job_prefix(hash, round_folder(o.out, k + 1)));
  }
  out.hash = hash_of(hashes);
  return out;
}

}  // namespace

std::optional<int> run_elements(Session& session, const GraphOptions& o, const SlurmOptions& s) {
  const auto plans = plan_rounds(session, o);
  if (plans.empty())
    throw Error("usage", "--executor slurm computes the elements of repeated nodes, but the graph has none",
                "repeat a node with `each`, or run several settings with `terrazzo sweep`");
  const std::atomic<bool>* cancel = cancel_on_interrupt();
  const DetachablePlan detachable = detachable_plan(plans, o);
  if (const auto code = wait_for_detached(detachable, o, s)) return code;
  if (s.detach && !s.is_job()) {
    write_sweep_file(detachable.sweep_file, plans.front().file);
    submit_detached(job_role::coordinator, detachable, o, s);
    return kDone;
  }
  for (std::size_t k = 0; k < plans.size(); ++k) {
    const SweepPoints& points = plans[k].file.points;
    const fs::path out = round_folder(o.out, k + 1);
    write_sweep_file(out / "sweep.json", plans[k].file);
    if (!o.quiet)
      std::cout << fmt::format("round {} of {}: {} elements; see `terrazzo status {}`", k + 1, plans.size(),
                               points.size(), o.out)
                << std::endl;
    const auto slurm = slurm_executor(plans[k], session.evaluator().store(), out, o, s);
    std::set<std::size_t> finished;  // an element may finish again if the cache has lost its result
    std::size_t failed = 0;
    slurm->run(points, cancel, [&](const SweepPoint& p, const json& report) {
      const PointSummary summary = summary_of(report);
      finished.insert(p.index);
      failed += summary.status != "done";
      for (const auto& error : summary.errors) std::cerr << p.name() << ": error: " << error << '\n';
      if (!o.quiet)
        std::cout << fmt::format("[{}/{}] {}: {} computed, {} cached, {:.2f} s", finished.size(),
                                 points.size(), p.name(), summary.computed, summary.cached, summary.seconds)
                  << std::endl;
    });
    if (slurm->out_of_time()) {
      submit_detached(s.job_role, detachable, o, s);
      return kDone;
    }
    if (*cancel) {
      std::cerr << "interrupted; rerun the same command to resume\n";
      return kInterrupted;
    }
    if (slurm->gave_up() || failed > 0) {
      std::cerr << fmt::format(
          "{} of {} elements failed, and {} have no result; the rest of the graph was not run; rerun the "
          "same "
          "command to resume\n",
          failed, points.size(), points.size() - finished.size());
      return kNodeFailed;
    }
  }
  require_same_files(plans.back().file, session.evaluator().hashes());
  if (s.coordinates()) {
    submit_detached(job_role::finisher, detachable, o, s);
    return kDone;
  }
  return {};
}

}  // namespace terrazzo::cli
