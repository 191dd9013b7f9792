#include "runtime/clients/studio/live/live_graph.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "graph/exception_text.h"
#include "graph/text/element_name.h"
#include "runtime/clients/studio/live/live_graph_watcher.h"
#include "runtime/files.h"
#include "runtime/json_text.h"

namespace terrazzo::studio {
using nlohmann::json;

struct LiveGraph::Running {
  std::unique_ptr<Watcher> watcher;
  std::shared_ptr<Evaluation> evaluation;  // destroyed first: it uses the watcher
};

namespace {

constexpr std::size_t kMostDrawn = 2000;  // nodes; the page's layout of more takes minutes

SessionOptions for_editing(SessionOptions options) {
  options.keep_intermediates = true;
  return options;
}

}  // namespace

LiveGraph::LiveGraph(const Registry& registry, const ValueTypes& types, SessionOptions options,
                     Document document, Overrides overrides, bool live)
    : registry_(registry),
      session_(registry, types, for_editing(std::move(options))),
      document_(std::move(document)),
      overrides_(std::move(overrides)),
      live_(live) {
  const std::lock_guard lock(mutex_);
  document_changed();
  thread_ = std::thread([this] { watch(); });
}

LiveGraph::~LiveGraph() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    for (const auto& r : running_) r->evaluation->cancel();
  }
  events_.end();
  wake_.notify_all();
  thread_.join();
  variants_.reset();
  running_.clear();  // waits, without the lock that the watchers need
}

// Also while a former evaluation still computes what later ones left as it was.
bool LiveGraph::is_running() const {
  return !then_.empty() || std::ranges::any_of(running_, [](const auto& r) {
    return !r->watcher->left && !r->evaluation->done();
  });
}

void LiveGraph::tell_run() {
  told_running_ = is_running();
  events_.add("run", json_text(run_json()));
}

json LiveGraph::run_json() const {
  const bool running = is_running();
  double expected = 0;
  std::size_t waiting = 0;
  for (const auto& [path, s] : states_) {
    if (s.state == "waiting" || s.state == "running" || s.state == "stale") expected += s.expected;
    waiting += s.state == "waiting" || s.state == "running";
  }
  return {{"running", running},   {"live", live_},         {"seconds", seconds_},
          {"expected", expected}, {"unfinished", waiting}, {"trouble", trouble_}};
}

void LiveGraph::document_changed() {
  const ReadGraph& read = document_.read();
  large_ = read.document.nodes.size() > kMostDrawn;
  found_ = session_.open_read(read.document, read.found, overrides_);
  valid_ = !has_errors(found_);
  tell_document();
  if (!valid_) return;
  inputs_.clear();
  for (const auto& node : session_.graph()->nodes)
    for (const auto& p : node.type->parameters)
      if (const auto it = node.parameters.find(p.name);
          p.kind == ParameterKind::InputPath && it != node.parameters.end())
        for (const auto& f : expand_glob(std::get<std::string>(it->second.value))) inputs_[f] = stamp_of(f);
  if (live_)
    start(safe_targets(*session_.graph()), true);
  else
    plan();
}

void LiveGraph::require_saved() {
  const std::lock_guard lock(mutex_);
  if (!document_.saved())
    throw Error("unsaved-changes", "the graph has unsaved changes",
                "save it first, or open the other one anyway");
}

void LiveGraph::open(Document document, bool discard, std::optional<bool> live) {
  if (!discard) require_saved();
  std::shared_ptr<Variants> left;  // ends without the lock
  const std::lock_guard lock(mutex_);
  left = std::move(variants_);
  ++variants_made_;
  for (const auto& r : running_) {
    r->watcher->current = false;
    r->watcher->left = true;
    r->evaluation->cancel();
  }
  then_.clear();
  document_ = std::move(document);
  inside_.clear();
  document_.look_for_left();  // of the former one, if it has the same file
  overrides_ = {};            // they belong to the graph of the command line
  states_.clear();
  past_.clear();
  disk_changed_ = false;
  seconds_ = 0;
  trouble_.clear();
  if (live) live_ = *live;
  events_.add("variants", "null");
  document_changed();
}

// Everything that a run without targets evaluates, but not the nodes that write files.
std::vector<std::string> LiveGraph::safe_targets(const Graph& graph) {
  std::vector<std::string> out;
  for (const int i : graph.sinks()) {
    const GraphNode& node = graph.nodes[i];
    if (!node.type->writes_files) out.push_back(node.path);
    for (const auto& [port, wires] : node.inputs)
      for (const auto& w : wires)
        if (node.type->writes_files) out.push_back(graph.nodes[w.node].path);
  }
  return out;
}

void LiveGraph::plan() {
  const auto graph = session_.graph();
  RunOptions options;
  options.output_folder = session_.options().output_folder;
  auto& e = session_.evaluator();
  const Plan plan = plan_run(*graph, options, e.store(), e.hashes(), session_.history());
  apply_plan(states_, *graph, plan, false);
  for (const auto& [path, s] : states_) tell_node(path);
  // Finds the values that are in the cache, so that they can be looked at. Nothing is computed.
  std::vector<std::string> cached;
  for (std::size_t i = 0; i < graph->nodes.size(); ++i)
    if (plan.nodes[i].step == Plan::Step::Cached && !graph->nodes[i].type->writes_files)
      cached.push_back(graph->nodes[i].path);
  if (!cached.empty()) begin(cached, false);
  tell_run();
}

void LiveGraph::start(const std::vector<std::string>& targets, bool shown_first) {
  const auto graph = session_.graph();
  RunOptions options;
  options.targets = target_nodes(*graph, targets);
  options.output_folder = session_.options().output_folder;
  auto& e = session_.evaluator();
  const Plan plan = plan_run(*graph, options, e.store(), e.hashes(), session_.history());
  apply_plan(states_, *graph, plan, true, shown_first);  // only a request leaves the graph as it was
  seconds_ = 0;
  then_.clear();
  asked_ = targets;
  if (targets.empty())
    for (const int i : graph->sinks()) asked_.push_back(graph->nodes[i].path);
  const int shown = shown_first ? graph->find(shown_) : -1;
  const auto runs = [&](int i) {
    const auto step = plan.nodes[i].step;
    return step != Plan::Step::Cached && step != Plan::Step::Unneeded;
  };
  if (shown >= 0 && runs(shown) && !graph->nodes[shown].type->writes_files) {
    begin({shown_}, false);
    then_ = targets;
  } else {
    begin(targets, false);
  }
  for (const auto& [path, s] : states_) tell_node(path);
  tell_run();
}

void LiveGraph::begin(const std::vector<std::string>& targets, bool continues) {
  for (const auto& r : running_) r->watcher->current = false;
  std::erase_if(running_, [](const auto& r) { return r->evaluation->done(); });
  auto next = std::make_unique<Running>();
  next->watcher = std::make_unique<Watcher>(*this, session_.graph(), continues);
  next->evaluation = session_.evaluate(targets, next->watcher.get());
  running_.push_back(std::move(next));
  end_expected_ = true;
}

void LiveGraph::show(const std::string& node) {
  const std::lock_guard lock(mutex_);
  shown_ = node;
}

void LiveGraph::evaluate(const std::vector<std::string>& targets) {
  const std::lock_guard lock(mutex_);
  if (!valid_) throw Error("invalid-graph", "the graph has errors", "correct them first");
  // What was asked for before, such as a picture while a file is written, follows.
  const auto before = is_running() ? asked_ : std::vector<std::string>();
  start(targets);
  if (targets.empty() || before.empty()) return;
  then_ = before;
  asked_.insert(asked_.end(), before.begin(), before.end());
  tell_run();
}

void LiveGraph::cancel(const std::string& node) {
  const std::lock_guard lock(mutex_);
  if (node.empty() && !std::exchange(then_, {}).empty())
    for (auto& [path, s] : states_)
      if (s.state == "waiting" || s.state == "running") {
        s.state = "canceled";
        tell_node(path);
      }
  for (const auto& r : running_) {
    if (node.empty()) r->evaluation->cancel();
    const auto& nodes = r->evaluation->graph().nodes;
    for (std::size_t i = 0; i < nodes.size() && !node.empty(); ++i)
      if (is_named(nodes[i].path, node)) r->evaluation->cancel_node(i);
  }
}

void LiveGraph::set_live(bool live) {
  const std::lock_guard lock(mutex_);
  live_ = live;
  tell_run();
  if (live_ && valid_) start(safe_targets(*session_.graph()), true);
}

Value LiveGraph::value(const std::string& hash) {
  OutputRecord record;
  {
    const std::lock_guard lock(mutex_);
    const auto varied = variants_ ? variants_->record(hash) : std::nullopt;
    const auto it = values_.find(hash);
    if (!varied && it == values_.end())
      throw Error("unknown-value", "no node of this session made this value");
    record = varied ? *varied : it->second;
  }
  Value v = session_.evaluator().store().get_value(record);
  if (!v) throw Error("lost-value", "the value is no longer in the cache", "run the node again");
  return v;
}

Value LiveGraph::preview(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  for (const auto& [path, s] : states_)
    for (const auto& [port, p] : s.previews)
      if (p.number == number) return p.value;
  return variants_ ? variants_->preview(number) : Value();
}

void LiveGraph::vary(VariantsRequest request) {
  std::shared_ptr<Variants> before;  // ends without the lock
  const std::lock_guard lock(mutex_);
  if (!valid_) throw Error("invalid-graph", "the graph has errors", "correct them first");
  RunOptions options;
  options.output_folder = session_.options().output_folder;
  options.threads = session_.options().threads;
  options.memory = session_.options().file_memory;
  options.cancel = session_.options().cancel;
  options.keep_intermediates = true;
  const auto tell = [this, number = variants_made_ + 1](const json& j) {
    if (number == variants_made_) events_.add("variants", json_text(j));
  };
  auto next = std::make_shared<Variants>(
      session_.evaluator(), registry_, edited_graph(request.scope), std::move(options), std::move(request),
      [this] { return ++previews_; }, tell);
  if (variants_) variants_->cancel();
  before = std::exchange(variants_, std::move(next));
  ++variants_made_;
  events_.add("variants", json_text(variants_->json()));
  tell_document();
}

void LiveGraph::cancel_variants() {
  const std::lock_guard lock(mutex_);
  if (variants_) variants_->cancel();
}

void LiveGraph::keep_variant(std::size_t tile) {
  Edit kept;
  std::string scope;
  {
    const std::lock_guard lock(mutex_);
    if (!variants_) throw Error("unknown-variant", "there are no variants");
    kept = variants_->edit(tile);
    scope = variants_->scope();
  }
  change([&](Document& d) { d.edit({kept}); }, scope);
}

void LiveGraph::note_end() {
  if (!end_expected_ || !running_.back()->evaluation->done()) return;
  end_expected_ = false;
  try {
    const RunResult& r = running_.back()->evaluation->wait();
    seconds_ += r.seconds;
    trouble_ = r.trouble;
  } catch (const std::exception& e) {
    trouble_ = exception_text(e);
  }
  if (const auto rest = std::exchange(then_, {}); !rest.empty())
    begin(rest, true);
  else if (valid_)
    past_.add(texts(), states_);
  tell_run();
}

void LiveGraph::watch() {
  std::unique_lock lock(mutex_);
  for (int tick = 0; !wake_.wait_for(lock, std::chrono::milliseconds(50), [&] { return ended_; }); ++tick) {
    note_end();
    if (told_running_ != is_running()) tell_run();
    if (tick % 20 != 0) continue;  // files: once a second
    if (document_.follow_arrangement()) tell_arrangement();
    if (document_.changed_on_disk() && !disk_changed_) try {
        if (document_.saved())
          document_.reload();
        else
          disk_changed_ = true;
        document_changed();
      } catch (const Error& e) {
        disk_changed_ = true;
        trouble_ = e.diagnostic().message;
        events_.add("document", json_text(document_json()));
      }
    const bool same = std::all_of(inputs_.begin(), inputs_.end(),
                                  [](const auto& f) { return stamp_of(f.first) == f.second; });
    if (same || !live_ || !valid_) continue;
    for (auto& [file, stamp] : inputs_) stamp = stamp_of(file);
    start(safe_targets(*session_.graph()), true);
  }
}

}  // namespace terrazzo::studio
