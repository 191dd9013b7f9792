#include "runtime/clients/python/run_object.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <future>
#include <set>

#include "runtime/clients/python/outside.h"
#include "runtime/clients/python/python_node.h"
#include "runtime/threads/thread_room.h"

namespace terrazzo::python {
namespace {

constexpr std::chrono::milliseconds kTick(50);

// Live evaluations of this process. Used with the GIL held.
std::set<std::weak_ptr<Evaluation>, std::owner_less<>>& live() {
  static auto& all = *new std::set<std::weak_ptr<Evaluation>, std::owner_less<>>;
  return all;
}
bool ended = false;         // the interpreter is exiting
pid_t first_process = 0;    // that evaluated; the worker threads are in it
int threads_with_room = 0;  // for so many, the address space sufficed

bool forked() { return first_process != 0 && first_process != ::getpid(); }

std::atomic<int> threads_in_code{0};
thread_local int depth = 0;  // of InCode in this thread

// Handles signals. If a handler raised, returns the exception.
std::unique_ptr<py::error_already_set> raised_by_signal() {
  if (PyErr_CheckSignals() == 0) return nullptr;
  return std::make_unique<py::error_already_set>();
}

}  // namespace

bool exiting() { return ended; }

InCode::InCode() : counted(!ended || depth > 0) {
  if (counted) {
    ++threads_in_code;
    ++depth;
  }
}
InCode::~InCode() {
  if (counted) {
    --depth;
    --threads_in_code;
  }
}

namespace {

// A process that evaluates nothing any more must not make a session either.
void require_living_process() {
  if (ended) throw Error("shut-down", "the interpreter is exiting, so nothing is evaluated any more");
  if (forked())
    throw Error("forked", "this process was forked after an evaluation, and has no worker threads",
                "use multiprocessing.set_start_method('spawn'), or fork before the first evaluation");
}

}  // namespace

void require_workers(int threads) {
  require_living_process();
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  if (threads > threads_with_room) {
    require_room_for_threads(threads - threads_with_room);
    threads_with_room = threads;
  }
  first_process = ::getpid();
}

ProgressQueue::ProgressQueue(const Graph& graph, const std::vector<int>& targets) {
  for (const bool needed : needed_nodes(graph, targets.empty() ? graph.sinks() : targets))
    state_.needed += needed;
}

void ProgressQueue::started(int node) {
  const std::lock_guard lock(mutex_);
  state_.running[node] = {};
}

void ProgressQueue::progress(int node, double fraction, const std::string& note) {
  const std::lock_guard lock(mutex_);
  Running& r = state_.running[node];
  r.fraction = fraction;
  if (!note.empty()) r.note = note;
}

void ProgressQueue::finished(int node, const NodeResult&) {
  const std::lock_guard lock(mutex_);
  state_.running.erase(node);
  ++state_.done;
}

ProgressQueue::State ProgressQueue::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

RunObject::RunObject(py::object graph, const std::vector<std::string>& targets,
                     const std::filesystem::path& out, std::optional<int> apart)
    : graph_object_(std::move(graph)), owner_(graph_object_.cast<GraphObject&>()) {
  require_living_process();
  const std::vector<std::string> known = owner_.targets(targets);
  Session& session = owner_.session();
  const int asked = apart.value_or(0) > 0 ? *apart : session.options().threads;
  threads_ = asked > 0 ? asked : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  require_workers(threads_);
  session.set_output_folder(out);
  revision_ = owner_.revision();
  given_ = owner_.given();
  graph_ = session.graph();
  progress_ = std::make_unique<ProgressQueue>(*session.graph(), target_nodes(*session.graph(), known));
  evaluation_ = apart ? session.evaluate_apart(known, progress_.get(), *apart)
                      : session.evaluate(known, progress_.get());
  std::erase_if(live(), [](const auto& weak) { return weak.expired(); });
  live().insert(evaluation_);
}

RunObject::~RunObject() {
  if (forked()) {  // its thread does not exist here, so it cannot be joined
    new std::shared_ptr<Evaluation>(std::move(evaluation_));
    progress_.release();
    return;
  }
  if (!evaluation_) return;
  const Outside outside;  // nodes written in Python need the GIL to end
  evaluation_->cancel();
  while (!evaluation_->wait_for(kTick)) {  // end_all_runs() may keep the evaluation, which uses progress_
  }
  evaluation_.reset();
}

void RunObject::wait(const py::object& draw) {
  if (forked()) require_living_process();
  const InCode in_code;
  std::unique_ptr<py::error_already_set> stop;
  bool end = false;
  while (!end) {
    {
      const Outside outside;
      end = evaluation_->wait_for(kTick);
    }
    if (!stop && (stop = raised_by_signal())) evaluation_->cancel();
    stop_canceled_calls();
    if (stop || draw.is_none()) continue;
    try {
      draw(end);
    } catch (py::error_already_set&) {
      evaluation_->cancel();
      const Outside outside;
      while (!evaluation_->wait_for(kTick)) {
      }
      throw;
    }
  }
  if (stop) throw py::error_already_set(*stop);
}

const RunResult& RunObject::result() {
  wait(py::none());
  return evaluation_->wait();
}

void RunObject::raise_errors() {
  const Diagnostics found = result().errors();
  for (const auto& d : found)
    if (cause_.is_none() && d.code == "python") cause_ = take_exception(d.hint);
  if (!found.empty()) raise(found, cause_);
}

std::optional<std::vector<std::string>> RunObject::elements(const std::string& output) const {
  if (!owner_.is_list(output)) return {};
  // The linker numbers the elements of an output that is a list.
  const auto named = [&](const std::string& name) {
    std::vector<std::string> out;
    for (const auto& o : graph().outputs)
      if (o.name == name || o.name.rfind(name + "[#", 0) == 0) out.push_back(o.name);
    return out;
  };
  std::vector<std::string> out = named(output);
  for (const auto& [name, w] : owner_.document().outputs)
    if (out.empty() && w.text == output) out = named(name);
  if (out.empty())
    throw Error("not-evaluated", fmt::format("'{}' was not evaluated by this run", output),
                "name it as a target of the run");
  return out;
}

namespace {

// An output that a run has evaluated, from the store or computed again.
Value fetch(Session& session, const Graph& graph, const RunResult& r, const Wire& wire) {
  const InCode in_code;
  const NodeResult& node = r.nodes[wire.node];
  {
    const Outside outside;
    if (Value v = session.evaluator().store().get_value(node.outputs.at(wire.port), node.cached_seconds))
      return v;
  }
  require_workers(session.options().threads);
  std::atomic<bool> cancel{false};
  RunOptions options;
  options.cancel = &cancel;
  options.threads = session.options().threads;
  options.output_folder = session.options().output_folder;
  options.memory = session.options().file_memory;
  auto future =
      std::async(std::launch::async, [&] { return session.evaluator().value(graph, r, wire, options); });
  std::unique_ptr<py::error_already_set> stop;
  for (bool end = false; !end;) {
    {
      const Outside outside;
      end = future.wait_for(kTick) == std::future_status::ready;
    }
    if (!stop) stop = raised_by_signal();
    if (stop || ended) cancel = true;
  }
  if (stop) throw py::error_already_set(*stop);
  return future.get();
}

}  // namespace

Wire RunObject::evaluated(const std::string& output) {
  const RunResult& r = result();
  const Wire wire = graph().wire_to(output);
  if (!r.nodes[wire.node].outputs.count(wire.port))
    throw Error("not-evaluated", fmt::format("'{}' was not evaluated by this run", output),
                "name it as a target of the run");
  return wire;
}

Value RunObject::value(const std::string& output) {
  const Wire wire = evaluated(output);
  Value value = fetch(owner_.session(), graph(), result(), wire);
  owner_.remember(output, revision_, graph(), result(), wire);
  return value;
}

KeptOutput RunObject::keep(const std::string& output) {
  const Wire wire = evaluated(output);
  if (!kept_) kept_ = std::make_shared<const FinishedRun>(FinishedRun{graph_, result(), given_});
  return {graph_object_, kept_, wire};
}

Value KeptOutput::value() const {
  return fetch(graph_object.cast<GraphObject&>().session(), *run->graph, run->result, wire);
}

void end_all_runs() {
  ended = true;
  if (forked()) return;
  std::vector<std::shared_ptr<Evaluation>> all;
  for (const auto& weak : live())
    if (auto e = weak.lock()) all.push_back(std::move(e));
  for (const auto& e : all) e->cancel();
  const py::gil_scoped_release without_gil;
  for (const auto& e : all)
    while (!e->wait_for(kTick)) {
    }
  all.clear();
  while (threads_in_code > depth) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void leave_without_exit_handlers() {
  threads_in_code = depth;  // the other threads do not exist here
  // Registered last, so called first, after Python has ended.
  ::on_exit(
      [](int status, void*) {
        std::fflush(nullptr);
        ::_exit(status);
      },
      nullptr);
}

bool process_was_forked() { return forked(); }

}  // namespace terrazzo::python
