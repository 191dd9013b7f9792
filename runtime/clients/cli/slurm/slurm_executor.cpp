#include "runtime/clients/cli/slurm/slurm_executor.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "graph/text/read_number.h"
#include "runtime/clients/cli/slurm/slurm_detached.h"
#include "runtime/clients/cli/slurm/slurm_job.h"
#include "runtime/files.h"
#include "runtime/report/report_format.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;
namespace {

constexpr int kAttemptsAllowed = 3;    // in a row without a new result
constexpr double kPollsUntilGone = 6;  // network file systems show new files late

class Coordinator : public SlurmExecutor {
 public:
  Coordinator(const SweepPlan& plan, Store& store, const fs::path& out, const GraphOptions& o,
              const SlurmOptions& slurm)
      : plan_(plan),
        sweep_(plan.file),
        store_(store),
        slurm_(slurm),
        hash_(sweep_.hash()),
        out_(fs::absolute(out).lexically_normal()),
        jobs_(hash_, sweep_.folder, out_, o, slurm) {}

  bool out_of_time() const override { return out_of_time_; }
  bool gave_up() const override { return gave_up_; }

  void run(const SweepPoints& points, const std::atomic<bool>* cancel,
           const std::function<void(const SweepPoint&, const json&)>& finished) override {
    finished_ = &finished;
    known_.assign(points.size(), false);
    for (std::size_t i = 0; i < points.size() && !*cancel; ++i) look_at(i, true);
    if (std::find(known_.begin(), known_.end(), false) == known_.end()) return;  // needs no Slurm
    make_chunks();
    if (!ids_.empty())  // again, for points that ended before their logs were opened
      for (std::size_t i = 0; i < points.size() && !*cancel; ++i) look_at(i, true);
    if (waiting() && !*cancel) submit_missing();
    const auto* time_over = time_is_nearly_over();
    do {
      while (waiting() && !*cancel && !*time_over) {
        sleep(cancel);
        step();
      }
    } while (!*cancel && !*time_over && refused_.empty() && forget_lost());
    out_of_time_ = *time_over && !*cancel && refused_.empty() && waiting();
    if (out_of_time_) return;
    if (*cancel || !refused_.empty()) {
      slurm::cancel(jobs_.shared_name());
      slurm::cancel(jobs_.chunks_name(chunks_.size()));
    }
    if (!refused_.empty()) std::cerr << "error: " << refused_ << '\n';
    if (twice_ > 0)
      std::cerr << fmt::format(
          "note: {} results, which took {:.1f} s, were computed by two machines at a time\n", twice_,
          twice_seconds_);
    gave_up_ = missing() > 0;
  }

 private:
  std::size_t missing() const {
    std::size_t n = 0;
    for (const auto& c : chunks_) n += c.missing;
    return n;
  }
  bool waiting() const {
    return refused_.empty() && std::any_of(chunks_.begin(), chunks_.end(),
                                           [](const SlurmJob& c) { return c.missing > 0 && !c.gave_up; });
  }
  SlurmJob& chunk_of(std::size_t point) {
    return *std::prev(std::upper_bound(chunks_.begin(), chunks_.end(), point,
                                       [](std::size_t p, const SlurmJob& c) { return p < c.points.first; }));
  }

  // Reads a point's report. `resuming`: takes only a successful one, so that a failed point runs again.
  void look_at(std::size_t i, bool resuming) {
    if (known_[i]) return;
    const SweepPoint point = sweep_.points[i];
    const json report = read_report(out_ / point.folder / "report.json");
    if (!report.is_object() || report.value("sweep", "") != hash_.text()) return;
    if (resuming &&
        !(is_finished_point(report, hash_, out_ / point.folder) && is_in_cache(point, report, store_)))
      return;
    known_[i] = true;
    if (!chunks_.empty()) --chunk_of(i).missing;
    (*finished_)(point, report);
  }

  // Divides the points into chunks. Jobs of this sweep that are already queued decide how many.
  void make_chunks() {
    const std::size_t n = sweep_.points.size();
    fs::create_directories(jobs_folder(out_));
    const std::size_t size = jobs_.chunk_size(n, plan_.point_seconds);
    std::size_t count = (n + size - 1) / size;
    const auto queue = slurm::queue(jobs_.prefix());
    if (!queue) throw Error("no-slurm", "Slurm's controller does not answer", "check with `scontrol ping`");
    for (const auto& task : *queue) {
      if (!task.active()) continue;
      ids_.insert(task.job);
      if (task.name == jobs_.shared_name()) continue;
      const auto chunks = number_in_text<std::size_t>(task.name.substr(jobs_.prefix().size()));
      if (chunks && *chunks > 0) count = *chunks;
    }
    const auto log = [&](const std::string& name) {
      return LogReader(jobs_folder(out_) / (name + ".jsonl"), true);
    };
    for (std::size_t k = 0; k < count; ++k) {
      const std::string name = chunk_name(k, count);
      SlurmJob chunk{fmt::format("chunk {} of {}", k, count), name, log(name)};
      chunk.points = points_of(k, count, n);
      for (std::size_t i = chunk.points.first; i < chunk.points.last; ++i) chunk.missing += !known_[i];
      chunk.missing_before = chunk.missing;
      chunks_.push_back(std::move(chunk));
    }
    shared_ = std::make_unique<SlurmJob>(
        SlurmJob{"the job for what all points share", shared_name, log(shared_name)});
    needs_no_shared_ = sweep_.shared.empty() || (plan_.shared_seconds > 0 && plan_.shared_seconds < 5);
    shared_done_ = needs_no_shared_ || is_shared_in_cache();
    if (ids_.empty()) return;
    std::cerr << "note: jobs of this sweep are already queued\n";
    take(*queue);
  }

  // Whether the shared job ran before, and the cache still has its results.
  bool is_shared_in_cache() const {
    return terrazzo::is_shared_in_cache(sweep_, read_shared_report(sweep_, out_), store_);
  }

  // Prepares to compute again what the cache has lost of the elements of a graph. False if it has all.
  bool forget_lost() {
    if (sweep_.points.parts().empty() || times_lost_ == kAttemptsAllowed) return false;
    std::size_t lost = 0;
    for (std::size_t i = 0; i < known_.size(); ++i) {
      if (!known_[i]) continue;
      const SweepPoint point = sweep_.points[i];
      const json report = read_report(out_ / point.folder / "report.json");
      if (report.is_object() && (summary_of(report).status != "done" || is_in_cache(point, report, store_)))
        continue;
      known_[i] = false;
      ++lost;
      ++chunk_of(i).missing;
    }
    if (lost == 0) return false;
    ++times_lost_;
    std::cerr << fmt::format("warning: the cache has lost the results of {} elements; computing them again\n",
                             lost);
    shared_done_ = needs_no_shared_ || is_shared_in_cache();
    shared_->submitted = shared_->active = false;
    for (auto& chunk : chunks_)
      if (chunk.missing > 0) {
        chunk.submitted = chunk.active = false;
        chunk.gone_since.reset();
      }
    submit_missing();
    return true;
  }

  // Submits every chunk that has no results and is not queued.
  void submit_missing() {
    std::vector<std::size_t> numbers;
    for (std::size_t k = 0; k < chunks_.size(); ++k)
      if (const SlurmJob& c = chunks_[k]; c.missing > 0 && !c.submitted && !c.gave_up) numbers.push_back(k);
    if (numbers.empty()) return;
    const auto exclude = bad_nodes();
    std::uint64_t after = 0;
    if (!shared_done_) {
      if (!shared_->submitted) {
        shared_->task = {};
        ids_.insert(shared_->task.job = jobs_.submit_shared(exclude));
        shared_->submitted = shared_->active = true;
      }
      after = shared_->task.job;
    }
    slurm::Task submitted;
    ids_.insert(submitted.job =
                    jobs_.submit_chunks(numbers, chunks_.size(), !needs_no_shared_, after, exclude));
    for (const auto k : numbers) {
      SlurmJob& c = chunks_[k];
      c.submitted = c.active = true;
      c.missing_before = c.missing;
      c.task = submitted;
      c.trouble.clear();
    }
  }

  // Nodes on which two jobs ended without their results, unless no others are left.
  std::vector<std::string> bad_nodes() const {
    std::vector<std::string> out;
    for (const auto& [node, failures] : failures_)
      if (failures >= 2) out.push_back(node);
    if (!out.empty() && out.size() >= slurm::nodes(slurm_.partition).size()) out.clear();
    return out;
  }

  void step() {
    read_logs();
    if (!refused_.empty()) return;
    const auto queue = slurm::queue(jobs_.prefix());
    if (queue.has_value() == silent_)
      std::cerr << (silent_ ? "note: Slurm's controller answers again\n"
                            : "warning: Slurm's controller does not answer; still looking for results\n");
    silent_ = !queue;
    if (silent_) return;
    take(*queue);
    if (shared_done_) look_for_lost_shared();
    if (!shared_done_) look_after_shared();
    if (shared_done_ || !shared_->submitted)
      for (auto& chunk : chunks_) look_after(chunk);
    if (refused_.empty()) submit_missing();
  }

  void read_logs() {
    if (!shared_done_)
      for (const auto& event : shared_->log.news()) take(event, *shared_);
    for (auto& chunk : chunks_)
      if (chunk.missing > 0)
        for (const auto& event : chunk.log.news()) take(event, chunk);
    for (const auto i : std::exchange(late_, {})) {
      look_at(i, false);
      if (!known_[i]) late_.push_back(i);
    }
  }

  void take(const json& event, SlurmJob& job) {
    const std::string what = event.at("event"), message = event.value("message", "");
    if (what == "warning")
      std::cerr << fmt::format("warning: {}: {}\n", event.value("host", ""), message);
    else if (what == "stopped")
      job.trouble = message;
    else if (what == "missing") {
      job.misses_shared = true;
      job.trouble = "the cache lacks what all points share";
    } else if (what == "refused" && refused_.empty())
      refused_ = fmt::format("{} refuses to run the sweep: {}", event.value("host", ""), message);
    if (what != "finished" || event.value("sweep", "") != hash_.text()) return;
    twice_ += event.value("twice", 0u);
    twice_seconds_ += event.value("twice_seconds", 0.0);
    if (&job != shared_.get()) {
      const auto index = event.value("point", std::size_t{0});
      if (index >= 1 && index <= known_.size() && !known_[index - 1]) late_.push_back(index - 1);
    } else if (event.value("status", "") == "done") {
      shared_done_ = true;
    } else {
      refused_ = "what all points share failed";
      for (const auto& error : event.value("errors", std::vector<std::string>())) refused_ += "\n  " + error;
    }
  }

  // Takes over the states in Slurm's queue.
  void take(const std::vector<slurm::Task>& queue) {
    std::set<std::uint64_t> known;
    for (const auto& task : queue) known.insert(task.job);
    const auto forget = [&](SlurmJob& job) {
      // Unless it is found below. A single task of an array that is canceled while it waits leaves no trace.
      // A controller that lost its state has forgotten whole jobs.
      if (job.task.active())
        job.task.state = job.task.waits() && known.count(job.task.job) ? "CANCELLED" : "unknown to Slurm";
      job.active = false;
    };
    for (auto& chunk : chunks_) forget(chunk);
    forget(*shared_);
    for (const auto& task : queue) {
      if (!ids_.count(task.job)) continue;
      SlurmJob* job = task.name == jobs_.shared_name()               ? shared_.get()
                      : task.number && *task.number < chunks_.size() ? &chunks_[*task.number]
                                                                     : nullptr;
      if (!job || task.job < job->task.job) continue;
      job->task = task;
      job->submitted = true;
      job->active = task.active() || task.completing();
      if (held_.count(task.id()) || task.launch_failed()) {
        if (held_.insert(task.id()).second) slurm::cancel_task(task.id());
        job->active = false;
        job->task.state = "LAUNCH_FAILED";
      }
    }
    const auto now = Clock::now();
    const auto note = [&](SlurmJob& job) {
      if (job.active || !job.submitted)
        job.gone_since.reset();
      else if (!job.gone_since)
        job.gone_since = now;
    };
    for (auto& chunk : chunks_) note(chunk);
    note(*shared_);
  }

  bool gone(const SlurmJob& job) const {
    return job.gone_since &&
           Clock::now() - *job.gone_since >= std::chrono::duration<double>(kPollsUntilGone * slurm_.poll);
  }

  // Decides about a job that is gone. False: it is not to be submitted again.
  bool again(SlurmJob& job, bool progress) {
    if (job.task.state == "CANCELLED") {
      std::cerr << fmt::format("warning: {} was canceled from outside\n", job.label);
      return false;
    }
    job.attempts = progress ? 1 : job.attempts + 1;
    if (!job.task.node.empty()) ++failures_[job.task.node];
    const bool give_up = job.attempts >= kAttemptsAllowed;
    std::cerr << (give_up ? "error: " : "warning: ") << job.ending(jobs_folder(out_))
              << (give_up ? fmt::format(" ({} times in a row)", job.attempts) : "; submitting it again")
              << '\n';
    job.submitted = false;
    job.gone_since.reset();
    return !give_up;
  }

  void look_after(SlurmJob& chunk) {
    if (chunk.missing == 0 || chunk.gave_up || !chunk.gone_since) return;
    for (std::size_t i = chunk.points.first; i < chunk.points.last; ++i) look_at(i, false);
    if (chunk.missing > 0 && gone(chunk)) chunk.gave_up = !again(chunk, chunk.missing < chunk.missing_before);
  }

  // Chunks that stopped because the cache has lost what all points share: computes that again, once, and then
  // these chunks.
  void look_for_lost_shared() {
    bool lost = false;
    for (auto& chunk : chunks_) {
      if (!chunk.misses_shared || chunk.active) continue;
      chunk.misses_shared = false;
      if (++chunk.times_without_shared > kAttemptsAllowed) continue;  // its trouble; look_after() decides
      lost = true;
      chunk.submitted = false;
      chunk.gone_since.reset();
    }
    if (!lost || is_shared_in_cache()) return;
    if (++shared_->attempts > kAttemptsAllowed) {
      refused_ = "the cache does not keep what all points share";
      return;
    }
    std::cerr << "warning: the cache has lost what all points share; computing it again\n";
    shared_done_ = shared_->submitted = shared_->active = false;
    shared_->gone_since.reset();
  }

  void look_after_shared() {
    if (!gone(*shared_)) return;
    if (!again(*shared_, false)) {
      refused_ = shared_->label + " has no result";
      return;
    }
    // Slurm has removed the chunks, which depend on this job.
    slurm::cancel(jobs_.chunks_name(chunks_.size()));
    ids_.clear();
    for (auto& chunk : chunks_) {
      chunk.submitted = chunk.active = false;
      chunk.gone_since.reset();
      chunk.task = {};
    }
  }

  void sleep(const std::atomic<bool>* cancel) const {
    const auto end = Clock::now() + std::chrono::duration<double>(slurm_.poll);
    while (!*cancel && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }

  const SweepPlan& plan_;
  const SweepFile& sweep_;
  Store& store_;
  const SlurmOptions& slurm_;
  const Hash hash_;
  const fs::path out_;
  const SlurmJobs jobs_;
  const std::function<void(const SweepPoint&, const json&)>* finished_ = nullptr;
  std::vector<bool> known_;        // by point: its result was taken
  std::vector<std::size_t> late_;  // points that are finished, but whose report is not visible yet
  std::vector<SlurmJob> chunks_;
  std::unique_ptr<SlurmJob> shared_;
  std::set<std::uint64_t> ids_;          // of the submitted jobs
  std::map<std::string, int> failures_;  // by node
  std::set<std::string> held_;           // tasks that Slurm could not start and does not try again
  std::string refused_;                  // why nothing more can run
  std::uint64_t twice_ = 0;
  double twice_seconds_ = 0;
  int times_lost_ = 0;
  bool needs_no_shared_ = false, shared_done_ = false, silent_ = false, out_of_time_ = false,
       gave_up_ = false;
};

}  // namespace

std::unique_ptr<SlurmExecutor> slurm_executor(const SweepPlan& plan, Store& store, const fs::path& out,
                                              const GraphOptions& o, const SlurmOptions& s) {
  return std::make_unique<Coordinator>(plan, store, out, o, s);
}

}  // namespace terrazzo::cli
