#include "runtime/clients/cli/sweep/sweep_sheet.h"

#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>

#include "runtime/clients/cli/write_value.h"
#include "runtime/json_text.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

std::string caption(const SweepPoint& p) {
  std::string out;
  for (const auto& [target, value] : p.values) out += (out.empty() ? "" : ", ") + target + " " + value;
  return out;
}

std::string quoted(const std::string& s) { return json_text(s); }  // JSON strings are valid YAML

}  // namespace

void write_sweep_sheet(const Program& program, Session& session, const GraphOptions& o,
                       const std::string& preview, const SweepPoints& points,
                       const std::vector<std::size_t>& with_preview) {
  if (!program.registry().find("LoadImage") || !program.registry().find("ContactSheet")) return;
  if (with_preview.empty()) {
    std::cerr << "no contact sheet: no point wrote '" << preview
              << "' (choose another file with --preview)\n";
    return;
  }
  std::string loads, images, captions;
  for (const std::size_t i : with_preview) {
    const SweepPoint point = points[i];
    // Relative, because the name of the output folder may not be UTF-8.
    const fs::path path = fs::path(point.folder) / preview;
    loads += fmt::format("  p{}: {{type: LoadImage, params: {{path: {}}}}}\n", i, quoted(path.string()));
    images += fmt::format("{}p{}.image", images.empty() ? "" : ", ", i);
    captions += (captions.empty() ? "" : ", ") + quoted(caption(point));
  }
  Diagnostics found;
  Graph graph = load_graph_text(
      fmt::format("terrazzo: 1\nnodes:\n{}  sheet: {{type: ContactSheet, inputs: {{images: [{}]}}, params: "
                  "{{captions: [{}]}}}}\n",
                  loads, images, captions),
      fs::absolute(o.out) / "sweep.yaml", program.registry(), {}, found);
  print(found);
  if (has_errors(found)) return;
  RunOptions options;
  options.targets = {append_writer(program.registry(), graph, graph.wire_to("sheet.image"), "sweep.png")};
  options.output_folder = o.out;
  options.threads = threads(o);
  options.memory = o.memory;
  options.cancel = cancel_on_interrupt();
  const RunResult r = session.evaluator().run(graph, options);
  print(r.errors());
  if (!r.failed() && !r.cancelled())
    std::cout << "wrote " << (fs::path(o.out) / "sweep.png").string() << '\n';
}

}  // namespace terrazzo::cli
