#include "runtime/session.h"

#include <set>
#include <utility>

#include "graph/document/raw_document.h"
#include "graph/exception_text.h"
#include "runtime/bundle/bundle.h"
#include "runtime/report/provenance.h"
#include "runtime/report/recipe.h"

namespace terrazzo {
namespace fs = std::filesystem;

Evaluation::~Evaluation() {
  cancel();
  if (thread_.joinable()) thread_.join();
}

bool Evaluation::done() const {
  const std::lock_guard lock(mutex_);
  return done_;
}

const RunResult& Evaluation::wait() {
  std::unique_lock lock(mutex_);
  finished_.wait(lock, [&] { return done_; });
  if (failure_) std::rethrow_exception(failure_);
  return result_;
}

bool Evaluation::wait_for(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  return finished_.wait_for(lock, time, [&] { return done_; });
}

void Evaluation::cancel() {
  cancel_ = true;
  for (auto& flag : cancel_node_) flag = true;
}

Session::Session(const Registry& registry, const ValueTypes& types, SessionOptions options)
    : registry_(registry),
      options_(std::move(options)),
      store_(types, options_.cache_folder, options_.memory),
      hashes_(store_.folder()),
      history_(store_.folder()),
      evaluator_(types, store_, hashes_) {}

Session::~Session() {
  for (const auto& weak : evaluations_)
    if (const auto e = weak.lock()) {
      e->cancel();
      std::unique_lock lock(e->mutex_);
      e->finished_.wait(lock, [&] { return e->done_; });
    }
}

Diagnostics Session::open(const fs::path& given, Overrides overrides) {
  Diagnostics found;
  fs::path file = given;
  if (is_bundle(given)) try {
      file = open_bundle(given, registry_);
    } catch (const Error& e) {
      return {e.diagnostic()};
    }
  const auto text = read_graph_text(file, found);
  return text ? open_text(*text, file, std::move(overrides)) : found;
}

Diagnostics Session::open_text(std::string text, const fs::path& file, Overrides overrides) {
  Diagnostics found;
  RawDocument doc = read_document(text, file.lexically_normal(), found);
  return open_read(std::move(doc), std::move(found), std::move(overrides));
}

Diagnostics Session::open_read(RawDocument doc, Diagnostics found, Overrides overrides) {
  if (!has_errors(found)) return open_document(std::move(doc), std::move(overrides));
  link_document(std::move(doc), registry_, overrides, found);  // reports the other errors too
  return found;
}

Diagnostics Session::open_document(RawDocument doc, Overrides overrides) {
  std::swap(document_, doc);
  Diagnostics found = load(std::move(overrides));
  if (has_errors(found)) document_ = std::move(doc);
  return found;
}

namespace {

// Nodes of `before` that are changed or missing in `after`, and all nodes downstream of them.
std::vector<int> obsolete_nodes(const Graph& before, const Graph& after) {
  std::map<std::string, std::string> now;
  for (const auto& node : after.nodes) now[node.path] = recipe(after, node);
  std::vector<bool> changed(before.nodes.size());
  std::vector<int> out;
  for (std::size_t i = 0; i < before.nodes.size(); ++i) {
    const GraphNode& node = before.nodes[i];
    const auto it = now.find(node.path);
    changed[i] = it == now.end() || it->second != recipe(before, node);
    for (const auto& [port, wires] : node.inputs)
      for (const auto& w : wires) changed[i] = changed[i] || changed[w.node];
    if (changed[i]) out.push_back(i);
  }
  return out;
}

template <class List, class Value>
void put(List& list, const std::string& name, Value value) {
  for (auto& [known, v] : list)
    if (known == name) {
      v = std::move(value);
      return;
    }
  list.emplace_back(name, std::move(value));
}

}  // namespace

Diagnostics Session::load(Overrides overrides) {
  Diagnostics found;
  auto graph = std::make_shared<Graph>(link_document(document_, registry_, overrides, found));
  if (has_errors(found)) return found;
  std::erase_if(evaluations_, [](const auto& weak) { return weak.expired(); });
  for (const auto& weak : evaluations_)
    if (const auto e = weak.lock(); e && e->follows_edits_ && !e->done())
      for (const int i : obsolete_nodes(e->graph(), *graph)) e->cancel_node_[i] = true;
  graph_ = std::move(graph);
  overrides_ = std::move(overrides);
  return found;
}

Diagnostics Session::set(const std::string& node_parameter, const std::string& value) {
  Overrides o = overrides_;
  put(o.set, node_parameter, value);
  return load(std::move(o));
}

Diagnostics Session::set_parameter(const std::string& name, const std::string& value) {
  Overrides o = overrides_;
  put(o.parameters, name, value);
  return load(std::move(o));
}

Diagnostics Session::connect(const std::string& node_input, const std::vector<std::string>& outputs) {
  Overrides o = overrides_;
  put(o.wires, node_input, outputs);
  return load(std::move(o));
}

std::shared_ptr<Evaluation> Session::evaluate(const std::vector<std::string>& targets, Observer* observer) {
  return start(targets, observer, options_.threads, true);
}

std::shared_ptr<Evaluation> Session::evaluate_apart(const std::vector<std::string>& targets,
                                                    Observer* observer, int threads) {
  return start(targets, observer, threads > 0 ? threads : options_.threads, false);
}

std::shared_ptr<Evaluation> Session::start(const std::vector<std::string>& targets, Observer* observer,
                                           int threads, bool follows_edits) {
  std::shared_ptr<Evaluation> e(new Evaluation);
  e->graph_ = graph_;
  e->follows_edits_ = follows_edits;
  e->cancel_node_.resize(graph_->nodes.size());
  RunOptions& o = e->options_;
  o.targets = target_nodes(*graph_, targets);
  o.output_folder = options_.output_folder;
  o.threads = threads;
  o.memory = options_.file_memory;
  o.keep_intermediates = options_.keep_intermediates;
  o.cancel = options_.cancel;
  o.cancel_node = &e->cancel_node_;
  o.cancel_all = &e->cancel_;
  o.observer = observer;
  o.provenance = provenance(*graph_, overrides_);
  std::erase_if(evaluations_, [](const auto& weak) { return weak.expired(); });
  evaluations_.push_back(e);
  e->thread_ = std::thread([this, at = e.get()] {
    RunResult result;
    std::exception_ptr failure;
    try {
      result = evaluator_.run(*at->graph_, at->options_);
    } catch (...) {
      failure = std::current_exception();
    }
    try {
      if (!failure) history_.record(*at->graph_, result, hashes_);
    } catch (const std::exception& e) {
      result.trouble = std::string("cannot save what `terrazzo explain` needs: ") + exception_text(e);
    }
    const std::lock_guard lock(at->mutex_);
    at->result_ = std::move(result);
    at->failure_ = failure;
    at->done_ = true;
    at->finished_.notify_all();
  });
  return e;
}

Value Session::value(const std::string& output) {
  const Wire wire = graph_->wire_to(output);
  const auto e = evaluate({output});
  const RunResult& r = e->wait();
  if (const auto errors = r.errors(); !errors.empty()) throw Error(errors[0]);
  if (r.cancelled()) throw Cancelled();
  return evaluator_.value(e->graph(), r, wire);
}

double Session::known_seconds(const GraphNode& node) {
  const auto before = history_.find(*graph_, node);
  if (!before) return 0;
  Tier tier;
  const auto record = store_.find_action(Hash::parse(before->key), tier);
  return record ? record->seconds : 0;
}

}  // namespace terrazzo
