// Context: everything that a node's compute function may use. It must not read the clock, the environment or
// globals.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "runtime/intermediates.h"
#include "runtime/value.h"
#include "runtime/work.h"

namespace terrazzo {

class Context : public NodeParameters {
 public:
  virtual ~Context() = default;

  // --- Inputs. Required inputs are always set; optional inputs may be null.
  template <class T>
  const T& input(const std::string& name) const {
    return value(name).template as<T>();
  }
  template <class T>
  const T* optional(const std::string& name) const {
    const Value* v = find(name);
    return v && v->is<T>() ? &v->as<T>() : nullptr;
  }
  bool has(const std::string& name) const { return find(name) != nullptr; }
  const Value& value(const std::string& name) const;
  // The values of an input that accepts a list of wires, in the order written.
  const std::vector<Value>& list(const std::string& name) const;
  // The same for an input that is declared with one_at_a_time(): the number of values, and one of them. Each
  // call of nth() may read the value from the disk. Call it from the thread of compute.
  std::size_t count(const std::string& name) const;
  Value nth(const std::string& name, std::size_t i) const;

  // --- Parameters: see NodeParameters. They were checked against their declarations before compute runs.

  // The files that an InputPath names: existing, absolute, sorted, at least one.
  const std::vector<std::filesystem::path>& files(const std::string& name) const;

  // The bytes that this computation may allocate for the content of a file. Loaders compare it with the size
  // in the file's header before they allocate (require_memory in runtime/memory.h).
  std::uint64_t memory() const { return memory_; }

  // --- Results.
  template <class T>
  void output(const std::string& name, T v) {
    set_output(name, Value::of<T>(std::move(v)));
  }
  // A value whose type is known only at run time.
  void output(const std::string& name, Value v) { set_output(name, std::move(v)); }
  // Adds a number to the report and to the metrics printed at the end of a run.
  virtual void metric(const std::string& name, double v) = 0;
  // Reports a problem that the user should know about but that does not invalidate the result.
  virtual void warn(const std::string& message) = 0;
  // Writes a file in the output folder. `write` receives a temporary path with the same extension; the file
  // gets its final name only once it is complete and synced. Only for node types with writes_files.
  virtual void write_file(const std::string& relative,
                          const std::function<void(const std::filesystem::path& temporary)>& write) = 0;
  // Saves what a canceled computation has reached, in a file NODE.interrupted.EXTENSION in the output folder
  // that the user can go on from. Call it once, where Cancelled is caught, and then rethrow. It never throws:
  // problems are reported in NodeResult::saved. Nothing is saved if only an edit made this node obsolete.
  // `what`: what the file contains, as in "the packing so far (2000 particles)". `hint`: how to go on.
  virtual void save_interrupted(const std::string& extension, const std::string& what,
                                const std::string& hint,
                                const std::function<void(const std::filesystem::path& temporary)>& write) = 0;
  // The provenance of this result as JSON, for the metadata of files: graph, overrides, action keys of the
  // upstream nodes.
  virtual std::string provenance() const = 0;

  // --- Previews.
  // Whether somebody watches, so that preliminary values are worth their time. It may change at any time.
  virtual bool watched() const = 0;
  // Shows a preliminary value of an output, such as a picture with few samples, until the result is there. It
  // is no result: no key, cache or file knows it. Does nothing unless watched().
  template <class T>
  void preview(const std::string& name, T v) {
    if (watched()) set_preview(name, Value::of<T>(std::move(v)));
  }

  // --- Parts of this computation that later ones can use again.
  const Intermediates& intermediates() const { return intermediates_; }

  // --- Loops, progress and cancellation. Pass it to the algorithm.
  const Work& work() const { return work_; }

 protected:
  const Value* find(const std::string& name) const;
  virtual void set_output(const std::string& name, Value v) = 0;
  virtual void set_preview(const std::string& name, Value v) = 0;

  Work work_;
  Intermediates intermediates_;
  std::uint64_t memory_ = 0;
  std::map<std::string, std::vector<Value>> inputs_;
  std::map<std::string, std::vector<std::filesystem::path>> files_;
  std::map<std::string, std::vector<std::function<Value()>>> later_;  // inputs read one at a time
};

}  // namespace terrazzo
