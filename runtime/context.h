// Context: all that a node's compute may see. No clock, no environment, no globals.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "graph/node_type.h"
#include "runtime/value.h"
#include "runtime/work.h"

namespace terrazzo {

class Context {
 public:
  virtual ~Context() = default;

  // --- inputs. A required one is always there; an optional one may be null.
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
  // All wires of an input that takes a list, in the order written.
  const std::vector<Value>& list(const std::string& name) const;

  // --- parameters, checked against their declaration before compute runs.
  bool boolean(const std::string& name) const;
  std::int64_t integer(const std::string& name) const;
  double number(const std::string& name) const;
  std::string text(const std::string& name) const;  // Text, Choice, OutputPath
  std::vector<std::int64_t> ints(const std::string& name) const;
  std::vector<double> numbers(const std::string& name) const;  // Numbers, Color
  std::vector<std::string> texts(const std::string& name) const;
  // The keyword that stands in the place of a value ("auto"), or "" where there is a value.
  std::string keyword(const std::string& name) const;
  // The files that an InputPath names: existing, absolute, sorted. A glob that matches nothing never gets
  // here.
  const std::vector<std::filesystem::path>& files(const std::string& name) const;

  // Bytes that this computation may allocate for what a file's header asks for. Loaders compare it with what
  // they need before they allocate (require_memory in runtime/memory.h).
  std::uint64_t memory() const { return memory_; }

  // --- results.
  template <class T>
  void output(const std::string& name, T v) {
    set_output(name, Value::of<T>(std::move(v)));
  }
  // A number for the report and the table at the end of a run.
  virtual void metric(const std::string& name, double v) = 0;
  // Something that the user should know but that does not make the result wrong.
  virtual void warn(const std::string& message) = 0;
  // Writes a file below the output folder: `write` gets a temporary path with the same extension, which takes
  // the final name only once whole and synced. For nodes with writes_files.
  virtual void write_file(const std::string& relative,
                          const std::function<void(const std::filesystem::path& temporary)>& write) = 0;
  // What made this result, as JSON: graph, overrides, keys of the nodes upstream. For files' metadata.
  virtual std::string provenance() const = 0;

  // --- loops, progress, cancellation: pass it on to the algorithm.
  const Work& work() const { return work_; }

 protected:
  const Value* find(const std::string& name) const;
  virtual void set_output(const std::string& name, Value v) = 0;
  const ParameterValue& raw(const std::string& name) const;

  Work work_;
  std::uint64_t memory_ = 0;
  std::map<std::string, std::vector<Value>> inputs_;
  std::map<std::string, ParameterValue> parameters_;
  std::map<std::string, std::vector<std::filesystem::path>> files_;
};

}  // namespace terrazzo
