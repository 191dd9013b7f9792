#include "runtime/compute_node.h"

#include <algorithm>
#include <new>

#include "graph/exception_text.h"
#include "graph/numeric_environment.h"
#include "graph/output_path.h"
#include "graph/text/utf8.h"
#include "runtime/files.h"
#include "runtime/files/protected_files.h"
#include "runtime/memory.h"

namespace terrazzo {
namespace fs = std::filesystem;
namespace {

// The path folder / relative. Throws Error "outside-output" if it leads out of the folder after links are
// resolved.
fs::path confined(const fs::path& folder, const std::string& relative) {
  std::error_code error;
  const fs::path path = folder / relative;
  const fs::path root = fs::weakly_canonical(folder, error);
  const fs::path parent = error ? fs::path() : fs::weakly_canonical(path.parent_path(), error);
  if (error) throw Error("write-failed", "cannot write '" + path.string() + "': " + error.message());
  if (leaves_folder(relative) || leaves_folder(parent.lexically_relative(root)))
    throw Error("outside-output",
                "'" + relative + "' leads out of the output folder '" + folder.string() + "'",
                "use a relative path inside it that no link redirects; --out sets the folder")
        .parameter("path");
  return path;
}

class NodeContext : public Context {
 public:
  explicit NodeContext(ComputeRequest r) : request_(std::move(r)) {
    work_ = request_.work;
    memory_ = available_memory();
    if (request_.memory > 0) memory_ = std::min(memory_, request_.memory);
    inputs_ = std::move(request_.inputs);
    later_ = std::move(request_.later);
    type_ = request_.type;
    parameters_ = std::move(request_.parameters);
    files_ = std::move(request_.files);
    intermediates_ = request_.intermediates;
  }

  void metric(const std::string& name, double v) override { result.metrics[name] = v; }
  void warn(const std::string& message) override { result.warnings.push_back(valid_utf8(message)); }
  std::string provenance() const override { return request_.provenance; }

  void write_file(const std::string& relative, const std::function<void(const fs::path&)>& write) override {
    if (!request_.type->writes_files)
      throw Error("node-bug", request_.type->name + " writes a file but does not declare writes_files_()");
    const fs::path final = confined(request_.output_folder, relative);
    try {
      if (request_.keep) request_.keep->require_other(final, relative);
      if (request_.claim) request_.claim(final, relative);
    } catch (Error& e) {
      throw e.parameter("path");
    }
    write_atomically(final, [&](const fs::path& temporary) {
      write(temporary);
      work_.check();  // if cancelled while writing, the existing file stays as it was
    });
    result.files.push_back(relative);
  }

  void save_interrupted(const std::string& extension, const std::string& what, const std::string& hint,
                        const std::function<void(const fs::path&)>& write) override {
    if (work_.cancelled() && request_.save_interrupted)
      request_.save_interrupted({extension, what, hint, write});
  }

  bool watched() const override { return request_.watched && !work_.cancelled() && request_.watched(); }

  ComputeResult result;

 protected:
  void set_output(const std::string& name, Value v) override {
    check_output(name, v);
    result.outputs[name] = std::move(v);
  }
  void set_preview(const std::string& name, Value v) override {
    check_output(name, v);
    request_.preview(name, std::move(v));
  }

 private:
  void check_output(const std::string& name, const Value& v) const {
    const Port* port = request_.type->find_output(name);
    if (!port || !port->accepts(v.type().name))
      throw Error("node-bug", request_.type->name + " sets an output '" + name + "' (" + v.type().name +
                                  ") that it does not declare");
  }

  ComputeRequest request_;
};

}  // namespace

ComputeResult compute_node(ComputeRequest request) {
  const NodeType& type = *request.type;
  const NumericEnvironment numbers;
  try {
    NodeContext context(std::move(request));
    context.work().check();
    if (type.check) type.check(context);
    type.compute(context);
    context.work().check();
    for (const auto& port : type.outputs)
      if (!context.result.outputs.count(port.name))
        throw Error("node-bug", type.name + " did not set its output '" + port.name + "'");
    return std::move(context.result);
  } catch (const Error&) {
    throw;
  } catch (const Cancelled&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw Error("out-of-memory", "not enough memory",
                "reduce the resolution, the size or the number of particles");
  } catch (const std::exception& e) {
    throw Error("failed", exception_text(e));
  }
}

std::map<std::string, ParameterValue> effective_parameters(
    const NodeType& type, const std::map<std::string, ParameterValue>& written) {
  std::map<std::string, ParameterValue> out;
  for (const auto& p : type.parameters) {
    const auto it = written.find(p.name);
    if (it != written.end())
      out[p.name] = it->second;
    else if (p.value)
      out[p.name] = *p.value;
    else
      throw Error("missing-parameter", type.name + " needs the parameter '" + p.name + "'").parameter(p.name);
  }
  return out;
}

}  // namespace terrazzo
