// Tests every reader with damaged files, each in a child process limited to 2 GB of memory and 10 s.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <new>
#include <stdexcept>

#include "graph/document/raw_document.h"
#include "graph/graph.h"
#include "nodes/common/io/pictures/picture_codec.h"
#include "nodes/common/io/provenance.h"
#include "nodes/data/volume.h"
#include "runtime/codec.h"
#include "runtime/compute_node.h"
#include "tests/support/all_nodes.h"
#include "tests/torture/input_seeds.h"
#include "tests/torture/mutate.h"
#include "tests/torture/torture.h"

namespace terrazzo::torture {
namespace {
namespace fs = std::filesystem;

constexpr rlim_t kMemory = 2'000'000'000;
constexpr unsigned kSeconds = 10;

constexpr int kBatch = 25;  // inputs per child, because starting one takes longer than reading most inputs

// A child's verdicts on its inputs, in memory shared with its parent.
struct Verdicts {
  int done = 0;
  char text[kBatch][200] = {};
  void say(const std::string& s) { std::snprintf(text[done], sizeof text[done], "%s", s.c_str()); }
};

// A damaged file and its companion files. The reader opens the first.
struct Input {
  std::map<std::string, std::string> files;
  bool other_choice = false;
};

void run_node(const std::string& name, const fs::path& file, bool other_choice) {
  ComputeRequest request;
  request.type = test::all_nodes().find(name);
  std::map<std::string, ParameterValue> written;
  for (const auto& p : request.type->parameters)
    // Only a mask of instances may have a second one with their classes.
    if (p.kind == ParameterKind::InputPath && !(other_choice && name == "LoadLabels" && p.name == "classes"))
      request.files[p.name] = {p.name == "key" ? file.parent_path() / "key.csv" : file};
  const auto set = [&](const char* parameter, const char* text) {
    const Parameter* p = request.type->find_parameter(parameter);
    std::string why;
    if (p) written[parameter] = read_parameter(*p, read_written(text), why).value();
  };
  for (const char* bare : {".tif", ".npy", ".zip"})
    if (name == "LoadVolume" && file.extension() == bare) set("spacing", "1");
  if (other_choice) set("repair", "true");
  if (other_choice && name == "LoadLabels") set("kind", "classes");
  for (const auto& p : request.files) written[p.first] = p.second[0].string();
  request.parameters = effective_parameters(*request.type, written);
  const ComputeResult result = compute_node(std::move(request));
  // The loaded value can be stored and reads back to the same bytes.
  for (const auto& [port, value] : result.outputs) {
    BufferWriter once, twice;
    value.type().encode(value.data(), once);
    Reader reader(once.buffer.data(), once.buffer.size());
    value.type().encode(value.type().decode(reader).get(), twice);
    if (once.buffer != twice.buffer) throw std::logic_error("the stored value differs");
  }
}

void read(const std::string& reader, const fs::path& file, bool other_choice) {
  if (reader.starts_with("provenance.")) {
    read_provenance(file);
  } else if (reader == "graph.yaml") {
    Diagnostics found;
    load_graph(file, test::all_nodes(), {}, found);
    if (has_errors(found)) throw Error(found.front());
  } else {
    run_node(reader.substr(0, reader.find('.')), file, other_choice);
  }
}

// Prepares, once for all children, what can be prepared without starting a thread.
void prepare() {
  test::all_nodes();
  initialize_openvdb();
  OIIO::attribute("threads", 1);
  OIIO::attribute("exr_threads", -1);
  OIIO::ImageInput::create("png");
  picture_codec();
}

void read_one(const std::string& reader, const Input& input, const fs::path& place, Verdicts& verdicts) {
  try {
    for (const auto& [name, content] : input.files) std::ofstream(place / name, std::ios::binary) << content;
    ::alarm(kSeconds);
    read(reader, place / input.files.begin()->first, input.other_choice);
    verdicts.say("value");
  } catch (const Error& e) {
    const auto& d = e.diagnostic();
    verdicts.say(d.code.empty() || d.message.size() > 1500
                     ? "loss: an error message of " + std::to_string(d.message.size()) + " bytes"
                     : "error " + d.code);
  } catch (const std::exception& e) {
    verdicts.say(std::string("loss: ") + e.what());
  } catch (...) {
    verdicts.say("loss: an exception");
  }
}

[[noreturn]] void child(const std::string& reader, const std::vector<Input>& inputs, const fs::path& place,
                        Verdicts& verdicts) {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t most = pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + kMemory;
  const rlimit memory{most, most}, no_core{0, 0};
  ::setrlimit(RLIMIT_AS, &memory);
  ::setrlimit(RLIMIT_CORE, &no_core);
  if (!std::freopen("/dev/null", "w", stderr)) ::_exit(2);  // libraries print to stderr
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  for (const Input& input : inputs) {
    read_one(reader, input, place, verdicts);
    ++verdicts.done;
  }
  ::_exit(0);
}

// Outcomes of the inputs up to the first one that ended the child.
std::vector<std::string> run_child(const std::string& reader, const std::vector<Input>& inputs,
                                   const fs::path& place, Verdicts& verdicts) {
  verdicts = Verdicts{};
  const pid_t pid = ::fork();
  if (pid < 0) throw std::runtime_error("fork failed");
  if (pid == 0) child(reader, inputs, place, verdicts);
  int status = 0;
  ::waitpid(pid, &status, 0);
  std::vector<std::string> outcomes(verdicts.text, verdicts.text + std::min(verdicts.done, kBatch));
  if (WIFSIGNALED(status))
    outcomes.push_back(WTERMSIG(status) == SIGALRM ? "loss: it took 10 s"
                                                   : fmt::format("loss: signal {}", WTERMSIG(status)));
  else if (WEXITSTATUS(status) != 0)
    outcomes.push_back(fmt::format("loss: exit code {}", WEXITSTATUS(status)));
  return outcomes;
}

void make_seeds(const Options& o, const fs::path& folder) {
  fs::create_directories(folder);
  const pid_t pid = ::fork();
  if (pid < 0) throw std::runtime_error("fork failed");
  if (pid == 0) {
    try {
      write_input_seeds(folder, o.source);
      ::_exit(0);
    } catch (const std::exception& e) {
      std::fprintf(stderr, "%s\n", e.what());
      ::_exit(1);
    }
  }
  int status = 0;
  ::waitpid(pid, &status, 0);
  if (status != 0) throw std::runtime_error("cannot write the seeds of mutated inputs");
}

}  // namespace

Counts mutated_inputs(const Options& o) {
  make_seeds(o, o.folder / "seeds");
  const std::vector<InputSeed> seeds = read_input_seeds(o.folder / "seeds");
  std::map<std::string, std::vector<const InputSeed*>> readers;
  for (const auto& s : seeds) readers[s.reader].push_back(&s);
  prepare();
  void* shared = ::mmap(nullptr, sizeof(Verdicts), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) throw std::runtime_error("mmap failed");
  auto& verdicts = *new (shared) Verdicts;
  const fs::path place = o.folder / "input";
  fs::create_directories(place);
  const auto started = std::chrono::steady_clock::now();
  const auto elapsed = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  };
  Counts counts;
  for (std::uint64_t round = 0; round == 0 || elapsed() < o.seconds; ++round) {
    std::uint64_t index = 0;
    for (const auto& [reader, of_reader] : readers) {
      ++index;
      std::vector<Input> inputs;
      for (std::uint64_t trial = round * kBatch; trial < (round + 1) * kBatch; ++trial) {
        Random r(o.seed, index, trial);
        // The first trials are the valid files, which must load.
        const bool valid = trial < of_reader.size();
        const InputSeed& seed = *of_reader[valid ? trial : r.below(of_reader.size())];
        const InputSeed& other = *of_reader[r.below(of_reader.size())];
        Input input{seed.files, r.below(2) == 1};
        auto damaged = input.files.begin();
        std::advance(damaged, static_cast<std::ptrdiff_t>(r.below(input.files.size())));
        if (!valid) damaged->second = mutated(damaged->second, other.files.begin()->second, r);
        inputs.push_back(std::move(input));
      }
      const auto outcomes = run_child(reader, inputs, place, verdicts);
      for (std::size_t i = 0; i < outcomes.size(); ++i) {
        const std::uint64_t trial = round * kBatch + i;
        const bool lost =
            outcomes[i].starts_with("loss") || (trial < of_reader.size() && outcomes[i] != "value");
        if (lost) {
          if (i < inputs.size())
            for (const auto& [name, content] : inputs[i].files)
              std::ofstream(place / name, std::ios::binary) << content;
          throw std::runtime_error(fmt::format("{}, seed {}, trial {}: {}; the input is in {}", reader,
                                               o.seed, trial, outcomes[i], place.string()));
        }
        ++counts["mutated_inputs " + reader];
        ++counts["mutated_inputs " + reader + ", " + outcomes[i]];
      }
    }
  }
  ::munmap(shared, sizeof(Verdicts));
  return counts;
}

}  // namespace terrazzo::torture
