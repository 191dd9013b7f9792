// A document that is evaluated as it is edited. It knows no HTTP.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <thread>

#include "runtime/bundle/write_bundle.h"
#include "runtime/clients/studio/live/document.h"
#include "runtime/clients/studio/live/node_states.h"
#include "runtime/clients/studio/live/past_states.h"
#include "runtime/clients/studio/live/variants.h"
#include "runtime/clients/studio/server/event_log.h"
#include "runtime/session.h"

namespace terrazzo::studio {

// All methods may be called from any thread. Each change of the document's text starts an evaluation of all
// nodes that write no files, if `live`; computations that the change does not affect go on. Every change is
// reported in events(): "document", "arrangement" {arrangement, can_undo, can_redo, trouble}, "node" {path,
// …}, "run", "variants".
class LiveGraph {
 public:
  LiveGraph(const Registry&, const ValueTypes&, SessionOptions, Document, Overrides = {}, bool live = true);
  ~LiveGraph();

  // Everything: {number, document, nodes, run, variants}. `number`: the last event that it includes. Of a
  // graph with more nodes than a page can draw, pages get the text, and only nodes that failed or have
  // warnings.
  nlohmann::json state();
  const EventLog& events() const { return events_; }

  // Changes the document, and reports it. What `apply` throws leaves the document as it was. `scope`: the
  // path of a node that is a subgraph: then its file is changed, and saved at once. Throws Error
  // "unknown-node", and "read-only" for a file outside the folder of the graph, or of a graph that is read
  // only.
  template <class Change>
  void change(Change&& apply, const std::string& scope = {}) {
    const std::lock_guard lock(mutex_);
    note_end();
    Document& changed = scope.empty() ? document_ : inside(scope);
    const std::uint64_t before = changed.revision();
    if (!scope.empty()) require_writable(changed);
    apply(changed);
    if (!scope.empty()) save_inside(changed);
    if (changed.revision() != before)
      document_changed();
    else
      tell_document();
  }

  // Shows another document, and evaluates it if `live`, by default as before. Throws Error "unsaved-changes",
  // unless `discard`; unsaved text of a file stays beside it.
  void open(Document, bool discard, std::optional<bool> live = {});
  // Throws Error "unsaved-changes" if there are any.
  void require_saved();

  // Evaluates "NODE", "NODE.PORT" or graph outputs; without targets, everything, files included. Throws Error
  // "unknown-node", "unknown-port", or "invalid-graph" if the document has errors.
  void evaluate(const std::vector<std::string>& targets);
  // Cancels one node, or everything for "".
  void cancel(const std::string& node);
  void set_live(bool);
  // What a page shows: the path of a node, or "". After a change, it and its sources are computed before all
  // others, so that an edit shows soon.
  void show(const std::string& node);

  // What these edits would cost, without making them: {nodes: [{path, seconds, reason, perhaps}], seconds},
  // for all nodes that a change evaluates. Seconds are those of the last computation, 0 if unknown. Throws
  // what edit_document() throws, and Error with the first message if the graph would have errors. `scope`: as
  // for change().
  nlohmann::json price(const std::vector<Edit>&, const std::string& scope = {});

  // States after earlier evaluations of this document: see past_states.h. restore() is a step of undo, of the
  // document and of each subgraph's file that it changes.
  nlohmann::json history(const std::string& node = {}, const std::string& port = {});
  nlohmann::json past(std::size_t number);
  void restore(std::size_t number);

  // Shows variants of an output in place of those before: see variants.h. Throws what Variants() throws, and
  // Error "invalid-graph".
  void vary(VariantsRequest);
  void cancel_variants();
  // Makes the document, or the file of the subgraph, a variant, as a step of undo. Throws Error
  // "unknown-variant" and what edit_document() throws.
  void keep_variant(std::size_t tile);

  // The document inside of a node that is a subgraph, by its path ("asset", "asset/part"), like the document
  // of state(), without messages. Throws Error "unknown-node".
  nlohmann::json subgraph(const std::string& path);
  // The file of the document, or of a subgraph by the path of its node. Throws Error "unknown-node".
  std::filesystem::path file_of(const std::string& scope);
  // Names of files below the graph's folder, relative to it, and whether there are more: {files, more}.
  nlohmann::json files();
  // The document as it is now, to write a bundle of it.
  BundleRequest bundle_request();
  // The files that the graph writes, and where: {folder, files}; see written_files.h.
  nlohmann::json outputs();
  // One of these files. Throws Error "no-file".
  std::filesystem::path output(const std::string& path);
  // Keeps where nodes and notes are: see arrangement.h and Document::arrange(). `scope`: as for change().
  void arrange(const nlohmann::json&, const std::string& group = {}, const std::string& scope = {});

  // A value that an evaluation made or found, by its content hash. Throws Error "unknown-value" or
  // "lost-value".
  Value value(const std::string& hash);
  // A preview by its number. Empty if there is a newer one, or the result.
  Value preview(std::uint64_t number);

 private:
  struct Running;
  struct Watcher;

  void document_changed();  // with mutex_ held, as all that follow
  // The file of a subgraph, by the path of its node, as it is now.
  Document& inside(const std::string& scope);
  EditedGraph edited_graph(const std::string& scope);
  bool varied();  // whether the variants are of the document as it is
  PastStates::Texts texts() const;
  static void require_writable(const Document&);
  static void save_inside(Document&);
  void tell_document();
  void tell_arrangement();
  // Evaluates what is shown first, if `shown_first`; then_ follows.
  void start(const std::vector<std::string>& targets, bool shown_first = false);
  void begin(const std::vector<std::string>& targets, bool continues);
  void plan();
  static std::vector<std::string> safe_targets(const Graph&);
  nlohmann::json document_json();
  nlohmann::json run_json() const;
  bool is_running() const;
  void tell_run();
  void tell_node(const std::string& path);
  // If the current evaluation has ended: keeps the state, or starts what follows.
  void note_end();
  void watch();  // the thread: ends of evaluations, files that change

  const Registry& registry_;
  Session session_;
  std::mutex mutex_;
  Document document_;
  std::map<std::filesystem::path, Document> inside_;  // files of subgraphs that were opened
  Overrides overrides_;
  bool live_;
  EventLog events_;
  NodeStates states_;
  Diagnostics found_;
  bool valid_ = false;         // the session has the document's graph
  bool large_ = false;         // the graph has more nodes than a page can draw
  bool disk_changed_ = false;  // another program changed the file, and there are unsaved changes
  double seconds_ = 0;         // of the last run that ended
  PastStates past_;
  std::string trouble_;
  std::map<std::string, OutputRecord> values_;
  std::atomic<std::uint64_t> previews_{0};                  // made so far
  std::vector<std::unique_ptr<Running>> running_;           // the last one is current
  std::map<std::string, std::optional<FileStamp>> inputs_;  // files that the graph reads
  std::string shown_;
  std::vector<std::string> then_;   // targets of the evaluation that follows the current one
  std::vector<std::string> asked_;  // targets of the last request, with those that it did not wait for
  bool end_expected_ = false;       // the end of the current evaluation was not reported yet
  bool told_running_ = false;       // what pages know
  bool ended_ = false;
  std::condition_variable wake_;
  std::shared_ptr<Variants> variants_;           // null: none were asked for
  std::atomic<std::uint64_t> variants_made_{0};  // so that former ones, which still end, report no more
  std::thread thread_;
};

}  // namespace terrazzo::studio
