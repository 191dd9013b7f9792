// Measures every path that has a shader, on this machine's GPU and on its processor, and compares their
// results.
// `./dev gpu-bundle` packs it with the libraries it needs.
#include <GL/glcorearb.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "graph/diagnostic.h"
#include "tests/bench/gpu/measure.h"

namespace terrazzo::gpu {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

namespace {

std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

void measure_device(const Options& o, const Tell& tell) {
  const EglContext context(o.device);
  const auto get = context.function<PFNGLGETSTRINGPROC>("glGetString");
  const auto text = [&](GLenum what) { return std::string(reinterpret_cast<const char*>(get(what))); };
  constexpr GLenum kDedicatedKilobytes = 0x9047;  // GL_NVX_gpu_memory_info
  GLint kilobytes = 0;
  context.function<PFNGLGETINTEGERVPROC>("glGetIntegerv")(kDedicatedKilobytes, &kilobytes);
  const std::string memory = kilobytes > 0 ? fmt::format("{} MiB", kilobytes / 1024) : "not told";
  tell(fmt::format("device {}, driver {}, memory {}; processor {} with {} threads", text(GL_RENDERER),
                   text(GL_VERSION), memory, processor(), std::thread::hardware_concurrency()),
       {{"kind", "device"},
        {"renderer", text(GL_RENDERER)},
        {"vendor", text(GL_VENDOR)},
        {"driver", text(GL_VERSION)},
        {"memory", memory},
        {"processor", processor()},
        {"threads", std::thread::hardware_concurrency()}});
}

constexpr int kNoDevice = 77;  // exit status

constexpr const char* kHelp =
    "terrazzo_gpu [--software] [--quick] [--repeats N] [--most EDGE] [--only slices|volumes|solids] [--out "
    "FILE]\n"
    "  --software  Mesa's software renderer instead of the GPU\n"
    "  --quick     small inputs, single runs: tests the program, measures nothing of use\n"
    "  --repeats N  runs of each, after one to warm up (3)\n"
    "  --most EDGE  the largest volume and solid, in voxels along an edge (512)\n"
    "  --out FILE  also writes the results as JSON\n";

int run(int count, char** arguments) {
  Options options;
  std::string only, out;
  for (int i = 1; i < count; ++i) {
    const std::string a = arguments[i];
    if (a == "--software")
      options.device = GlDevice::Cpu;
    else if (a == "--quick")
      options.quick = true;
    else if (a == "--repeats" && i + 1 < count)
      options.repeats = std::atoi(arguments[++i]);
    else if (a == "--most" && i + 1 < count)
      options.most = std::atoi(arguments[++i]);
    else if (a == "--only" && i + 1 < count)
      only = arguments[++i];
    else if (a == "--out" && i + 1 < count)
      out = arguments[++i];
    else {
      std::fputs(kHelp, a == "--help" ? stdout : stderr);
      return a == "--help" ? 0 : 2;
    }
  }
  nlohmann::json all = nlohmann::json::array();
  const Tell tell = [&](const std::string& line, const nlohmann::json& entry) {
    fmt::print("{}\n", line);
    std::fflush(stdout);
    all.push_back(entry);
    if (!out.empty()) std::ofstream(out) << all.dump(1) << "\n";  // each time: a later step may fail
  };
  constexpr const char* kSteps[] = {"", "slices", "volumes", "solids"};
  if (std::find(std::begin(kSteps), std::end(kSteps), only) == std::end(kSteps) || options.repeats < 1 ||
      options.most < 1) {
    std::fputs(kHelp, stderr);
    return 2;
  }
  int failed = 0;
  const auto step = [&](const char* name, void (*measure)(const Options&, const Tell&)) {
    if (!only.empty() && only != name && std::strcmp(name, "device") != 0) return;
    try {
      measure(options, tell);
    } catch (const Error& e) {
      tell(fmt::format("{}: {}", name, e.what()), {{"kind", "failed"}, {"step", name}, {"error", e.what()}});
      failed = e.diagnostic().code == "no-gl" && std::strcmp(name, "device") == 0 ? kNoDevice : 1;
    } catch (const std::exception& e) {
      tell(fmt::format("{}: failed: {}", name, e.what()),
           {{"kind", "failed"}, {"step", name}, {"error", e.what()}});
      failed = 1;
    }
  };
  step("device", measure_device);
  if (failed) return failed;
  step("slices", measure_slices);
  step("volumes", measure_volumes);
  step("solids", measure_solids);
  return failed;
}

}  // namespace
}  // namespace terrazzo::gpu

int main(int count, char** arguments) { return terrazzo::gpu::run(count, arguments); }
