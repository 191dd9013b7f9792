// How a run gets the result of one node: from the cache, or by computing it.
#include <chrono>
#include <memory>

#include "graph/document/file_set.h"
#include "runtime/files/protected_files.h"
#include "runtime/interrupted.h"
#include "runtime/report/file_provenance.h"
#include "runtime/run.h"

namespace terrazzo {
namespace fs = std::filesystem;

Run::Outcome Run::compute_alone(int i, const Inputs& inputs) {
  const NodeResult& r = result(i);
  const auto later = [&]() -> std::function<void()> {
    auto handle = std::make_shared<tbb::task_handle>(group_.defer([this, i] { visit(i); }));
    return [this, handle] { (*arena_)->enqueue(std::move(*handle)); };
  };
  if (!e_.begin(r.record, later)) return Outcome::Elsewhere;
  struct End {
    Evaluator& e;
    const Hash key;
    ~End() { e.end(key); }
  } end{e_, r.record};
  // Another run may have finished between the first lookup and begin().
  if (use_cached(i) || compute(i, inputs)) return Outcome::Done;
  return Outcome::FilesChanged;
}

bool Run::use_cached(int i) {
  NodeResult& r = result(i);
  Tier tier;
  const auto record = e_.store_.find_action(r.record, tier);
  // A plugin may have other outputs now, under the same version. Its node runs again.
  if (!record || !has_outputs_of(*record, *node(i).type)) return false;
  // Written files are cache hits only if their content is unchanged. The name alone proves nothing.
  for (const auto& f : record->files) {
    const auto now = e_.hashes_.hash(options_.output_folder / f.path);
    if (!now || *now != f.content) return false;
  }
  for (const auto& f : record->files) claim(i, options_.output_folder / f.path, f.path);
  // A value that the store has lost is recomputed only when a consumer needs it.
  r.status = tier == Tier::Memory ? Status::Memory : Status::Disk;
  r.outputs = record->outputs;
  r.metrics = record->metrics;
  r.warnings = record->warnings;
  r.files = record->files;
  r.cached_seconds = record->seconds;
  return true;
}

bool Run::files_changed(int i) {
  const InputFiles& before = state(i).files;
  if (before.paths.empty()) return false;
  try {
    const InputFiles now = input_files(node(i), e_.hashes_, options_.memory);
    return now.paths != before.paths || now.hashes != before.hashes;
  } catch (const Error&) {
    return true;  // the file is gone; the next attempt reports that
  }
}

bool Run::compute(int i, const Inputs& inputs) {
  NodeResult& r = result(i);
  tell([&](Observer& o) { o.started(i); });
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const Work::Report report = [this, i](double fraction, const std::string& note) {
    tell([&](Observer& o) { o.progress(i, fraction, note); });
  };
  auto record = std::make_shared<ActionRecord>();
  ComputeRequest q = request(i, work(i, &report));
  record->type = q.type->name;
  record->version = q.type->version;
  record->parameters = q.parameters;
  for (const auto& [name, paths] : state(i).files.paths)
    for (std::size_t k = 0; k < paths.size(); ++k)
      record->input_files[name].push_back({paths[k].string(), state(i).files.hashes.at(name)[k]});
  record->inputs = inputs;
  ComputeResult computed;
  try {
    computed = compute_node(std::move(q));
  } catch (const Error&) {
    if (files_changed(i)) return false;
    throw;
  }
  if (files_changed(i)) return false;
  for (auto& [port, value] : computed.outputs) {
    record->outputs[port] = e_.store_.put_value(value, seconds());
    keep(i, port, std::move(value));
  }
  for (const auto& f : computed.files) {
    const auto hash = e_.hashes_.hash(options_.output_folder / f);
    if (!hash) throw Error("write-failed", "the file '" + f + "' disappeared right after it was written");
    record->files.push_back({f, *hash});
  }
  record->metrics = std::move(computed.metrics);
  record->warnings = std::move(computed.warnings);
  r.seconds = record->seconds = seconds();
  r.outputs = record->outputs;
  r.metrics = record->metrics;
  r.warnings = record->warnings;
  r.files = record->files;
  r.status = Status::Computed;
  e_.store_.put_action(r.record, std::move(record));
  return true;
}

void Run::keep(int i, const std::string& port, Value value) {
  if (e_.store_.keeps_on_disk()) return;
  const std::lock_guard lock(state(i).mutex);
  state(i).values[port] = std::move(value);
}

// What nodes need that write files.
void Run::write_requests(int i, ComputeRequest& q) {
  q.provenance = file_provenance(graph_, i, result_, options_);
  q.keep = protected_files();
  q.claim = [this, i](const fs::path& file, const std::string& shown) { claim(i, file, shown); };
}

std::shared_ptr<const ProtectedFiles> Run::protected_files() {
  std::call_once(protected_once_, [&] { protected_ = std::make_shared<const ProtectedFiles>(graph_); });
  return protected_;
}

void Run::claim(int i, const fs::path& file, const std::string& shown) {
  const std::lock_guard lock(writers_mutex_);
  const auto [writer, first] = writers_.emplace(place_of(file).string(), i);
  if (first || writer->second == i) return;
  throw Error("same-file",
              "'" + shown + "' is the file that '" + node(writer->second).path + "' has just written",
              "give each its own file name");
}

ComputeRequest Run::request(int i, Work work) {
  ComputeRequest q;
  q.type = node(i).type;
  for (const auto& [port, wires] : node(i).inputs) {
    const bool later = q.type->find_input(port)->one_at_a_time;
    for (const auto& w : wires)
      if (is_left_out(graph_, result_, node(i), w))
        continue;
      else if (later)
        q.later[port].push_back([this, &w] { return value_of(w, false); });
      else
        q.inputs[port].push_back(value_of(w));
  }
  std::map<std::string, ParameterValue> written;
  for (const auto& [name, p] : node(i).parameters) written[name] = p.value;
  q.parameters = effective_parameters(*q.type, written);
  q.files = state(i).files.paths;
  q.output_folder = options_.output_folder;
  if (q.type->writes_files) write_requests(i, q);
  q.work = std::move(work);
  q.memory = options_.memory;
  if (options_.keep_intermediates) q.intermediates = Intermediates(e_.store_);
  if (options_.observer) {
    q.watched = [this, i] { return options_.observer->wants_previews(i); };
    q.preview = [this, i](const std::string& port, const Value& v) {
      tell([&](Observer& o) { o.preview(i, port, v); });
    };
  }
  q.save_interrupted = [this, i](const InterruptedWork& work) {
    if (run_is_cancelled()) result(i).saved = save(work, node(i), options_.output_folder, *protected_files());
  };
  return q;
}

}  // namespace terrazzo
