#include "runtime/clients/studio/live/variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "graph/exception_text.h"

namespace terrazzo::studio {
using Json = nlohmann::json;
namespace {

constexpr std::size_t kMostVariants = 64;

SweepPoints points_of(const VariantsRequest& request) {
  SweepPoints points({{request.target, parse_values(request.values)}}, {});
  if (points.size() > kMostVariants)
    throw Error("too-large",
                fmt::format("the list has {} values, and {} fit side by side", points.size(), kMostVariants),
                "use fewer values here, or terrazzo sweep");
  return points;
}

// The edit that a point of a sweep stands for.
Edit edit_of(const SweepPoint& point) {
  const auto& [target, value] = point.values.front();
  const auto dot = target.rfind('.');
  Edit e;
  e.kind = dot == std::string::npos ? Edit::Kind::SetDefault : Edit::Kind::SetParameter;
  e.node = dot == std::string::npos ? "" : target.substr(0, dot);
  e.name = target.substr(dot == std::string::npos ? 0 : dot + 1);
  e.value = read_written(value);
  return e;
}

// Variants are looked at, and write no files.
void require_no_files(const Graph& graph, int node) {
  const auto needed = needed_nodes(graph, {node});
  for (std::size_t i = 0; i < graph.nodes.size(); ++i)
    if (needed[i] && graph.nodes[i].type->writes_files)
      throw Error("writes-files", "'" + graph.nodes[i].path + "' writes files",
                  "show a result that needs no written file");
}

// The nearest shapes that a node's result comes from.
std::optional<OutputRecord> shapes_of(const Graph& graph, const RunResult& result, int node) {
  std::vector<int> found = {node};
  for (std::size_t k = 0; k < found.size(); ++k)
    for (const auto& [input, wires] : graph.nodes[found[k]].inputs)
      for (const Wire& w : wires) {
        const auto& outputs = result.nodes[w.node].outputs;
        if (const auto it = outputs.find(w.port); it != outputs.end() && it->second.type == "Shapes")
          return it->second;
        if (std::ranges::count(found, w.node) == 0) found.push_back(w.node);
      }
  return {};
}

}  // namespace

// Receives the events of one evaluation of a tile.
struct Variants::Watcher : Observer {
  Variants& owner;
  const Graph& graph;
  const int shown;
  const std::size_t tile;
  const bool quick;
  std::chrono::steady_clock::time_point told{};

  Watcher(Variants& owner, const Graph& graph, int shown, std::size_t tile, bool quick)
      : owner(owner), graph(graph), shown(shown), tile(tile), quick(quick) {}

  void started(int node) override { now(node, 0); }

  void progress(int node, double fraction, const std::string& /*note*/) override {
    const auto time = std::chrono::steady_clock::now();
    if (time - told < std::chrono::milliseconds(100)) return;
    told = time;
    now(node, fraction);
  }

  void now(int node, double fraction) {
    owner.change(tile, [&](Tile& t) {
      t.doing = graph.nodes[node].path;
      t.progress = fraction;
    });
  }

  bool wants_previews(int node) override { return node == shown; }

  void preview(int node, const std::string& port, const Value& value) override {
    if (node != shown || port != owner.request_.port) return;
    owner.change(tile, [&](Tile& t) {
      t.preview = Preview{owner.preview_number_(), value};
      if (quick) owner.stop_nodes();
    });
  }
};

Graph EditedGraph::link(const std::string& text, const Registry& registry, Diagnostics& found) const {
  if (file == root_file) return load_graph_text(text, root_file, registry, overrides, found);
  Overrides with = overrides;
  with.files[file] = text;
  return load_graph_text(root.text, root_file, registry, with, found);
}

Variants::Variants(Evaluator& evaluator, const Registry& registry, EditedGraph source, RunOptions options,
                   VariantsRequest request, std::function<std::uint64_t()> preview_number,
                   std::function<void(const Json&)> tell)
    : evaluator_(evaluator),
      registry_(registry),
      source_(std::move(source)),
      options_(std::move(options)),
      request_(std::move(request)),
      points_(points_of(request_)),
      preview_number_(std::move(preview_number)),
      tell_(std::move(tell)),
      tiles_(points_.size()) {
  for (std::size_t i = 0; i < tiles_.size(); ++i) tiles_[i].value = points_[i].values.front().second;
  thread_ = std::thread([this] { run(); });
}

Variants::~Variants() {
  cancel();
  thread_.join();
}

void Variants::cancel() {
  const std::lock_guard lock(mutex_);
  canceled_ = true;
  stop_nodes();
}

void Variants::stop_nodes() {
  for (auto& flag : stop_) flag = true;
}

template <class Change>
void Variants::change(std::size_t tile, Change&& apply) {
  const std::lock_guard lock(mutex_);
  apply(tiles_[tile]);
  tell_(locked_json());
}

void Variants::run() {
  for (const bool quick : {true, false})
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
      {
        const std::lock_guard lock(mutex_);
        if (canceled_) break;
        if (tiles_[i].state == "done" || tiles_[i].state == "failed") continue;
      }
      evaluate(i, quick);
    }
  const std::lock_guard lock(mutex_);
  for (auto& t : tiles_)
    if (t.state != "done" && t.state != "failed") t.state = "canceled";
  running_ = false;
  tell_(locked_json());
}

void Variants::evaluate(std::size_t tile, bool quick) try {
  change(tile, [](Tile& t) { t.state = "running"; });
  Diagnostics found;
  const ReadGraph edited = edit_document(source_.edited, source_.file, edit(tile));
  const Graph graph = source_.link(edited.text, registry_, found);
  for (const auto& d : found)
    if (d.severity == Severity::Error) throw Error(d);
  const int node = graph.find(request_.node);
  if (node < 0) throw Error("unknown-node", "the graph has no node '" + request_.node + "' with this value");
  require_no_files(graph, node);
  const RunResult result = evaluate(graph, node, tile, quick);
  const NodeResult& shown = result.nodes[node];
  const auto output = shown.outputs.find(request_.port);
  const Diagnostics errors = result.errors();
  change(tile, [&](Tile& t) {
    t.seconds += result.seconds;
    t.doing.clear();
    t.progress = 0;
    if (!errors.empty()) {
      t.state = "failed";
      t.error = errors.front().node + ": " + errors.front().message;
    } else if (shown.status == Status::Cancelled || shown.status == Status::Skipped) {
      t.state = t.preview ? "preview" : "waiting";
    } else if (output == shown.outputs.end()) {
      t.state = "failed";
      t.error = request_.node + " has no output " + request_.port;
    } else {
      t.state = "done";
      t.output = output->second;
      if (t.output->type == "Particles") t.shapes = shapes_of(graph, result, node);
      t.preview.reset();
    }
  });
} catch (const std::exception& e) {
  change(tile, [&](Tile& t) {
    t.state = "failed";
    t.error = exception_text(e);
  });
}

RunResult Variants::evaluate(const Graph& graph, int node, std::size_t tile, bool quick) {
  Watcher watcher(*this, graph, node, tile, quick);
  RunOptions options = options_;
  options.targets = {node};
  options.observer = &watcher;
  options.cancel_node = &stop_;  // not the whole run, which would save what nodes have reached
  {
    const std::lock_guard lock(mutex_);
    stop_.clear();
    for (std::size_t i = 0; i < graph.nodes.size(); ++i) stop_.emplace_back(canceled_);
  }
  return evaluator_.run(graph, options);
}

Json Variants::json() const {
  const std::lock_guard lock(mutex_);
  return locked_json();
}

Json Variants::locked_json() const {
  Json tiles = Json::array();
  for (const Tile& t : tiles_) {
    Json j = {{"value", t.value},       {"state", t.state},     {"doing", t.doing},
              {"progress", t.progress}, {"seconds", t.seconds}, {"error", t.error}};
    if (t.output) j["output"] = json_of(*t.output);
    if (t.shapes) j["shapes"] = json_of(*t.shapes);
    if (t.preview) j["preview"] = {{"type", t.preview->value.type().name}, {"number", t.preview->number}};
    tiles.push_back(std::move(j));
  }
  return {{"target", request_.target},
          {"values", request_.values},
          {"node", request_.node},
          {"port", request_.port},
          {"scope", request_.scope},
          {"running", running_},
          {"tiles", tiles}};
}

Edit Variants::edit(std::size_t tile) const {
  if (tile >= points_.size())
    throw Error("unknown-variant", "there is no variant " + std::to_string(tile + 1));
  return edit_of(points_[tile]);
}

bool Variants::fit(const EditedGraph& now) const try {
  const auto first = [&](const ReadGraph& read) { return edit_document(read, source_.file, edit(0)).text; };
  if (now.file != source_.file) return false;
  if (now.file != now.root_file && now.root.text != source_.root.text) return false;
  return now.edited.text == source_.edited.text || first(now.edited) == first(source_.edited);
} catch (const Error&) {
  return false;
}

std::optional<OutputRecord> Variants::record(const std::string& hash) const {
  const std::lock_guard lock(mutex_);
  for (const Tile& t : tiles_)
    for (const auto& o : {t.output, t.shapes})
      if (o && o->content.text() == hash) return o;
  return {};
}

Value Variants::preview(std::uint64_t number) const {
  const std::lock_guard lock(mutex_);
  for (const Tile& t : tiles_)
    if (t.preview && t.preview->number == number) return t.preview->value;
  return {};
}

}  // namespace terrazzo::studio
