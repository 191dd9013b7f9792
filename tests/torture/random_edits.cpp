// Random edits of parameters, wires and input files. Every result is compared with one computed from scratch,
// which detects stale values.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "runtime/random.h"
#include "runtime/session.h"
#include "tests/support/report_contents.h"
#include "tests/torture/bed.h"

namespace terrazzo::torture {
namespace fs = std::filesystem;
namespace {

constexpr const char* graph = R"(terrazzo: 1
nodes:
  wood: {type: Pattern, params: {width: 12, height: 12}}
  marble: {type: Pattern, params: {kind: marble, width: 12, height: 12}}
  photo: {type: LoadImage, params: {path: photo.ppm}}
  linked: {type: LoadImage, params: {path: link.ppm}}
  inside: {type: LoadImage, params: {path: folder/photo.ppm}}
  sheet: {type: ContactSheet, inputs: {images: [wood.image, photo.image]}, params: {cell: 32}}
  all: {type: ContactSheet, inputs: {images: [sheet.image, marble.image, linked.image, inside.image]}, params: {cell: 32}}
  file: {type: Export, inputs: {image: all.image}, params: {path: all.png}}
)";

std::string photo(Random& random) {
  std::string text = "P6\n4 4\n255\n";  // equal sizes, so that only the content shows a change
  for (int i = 0; i < 48; ++i) text += static_cast<char>(random.below(256));
  return text;
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

void set_old_time(const fs::path& file) {
  const struct timespec times[2] = {{1'000'000'000, 0}, {1'000'000'000, 0}};
  if (::utimensat(AT_FDCWD, file.c_str(), times, AT_SYMLINK_NOFOLLOW) != 0)
    throw std::runtime_error("utimensat");
}

void link(const fs::path& link, const fs::path& target) {
  const fs::path fresh = link.string() + ".new";
  fs::create_symlink(target, fresh);
  set_old_time(fresh);
  fs::rename(fresh, link);
}

// The inputs are in folders a and b and always have the same modification time.
class Inputs {
 public:
  explicit Inputs(const fs::path& folder, Random& random) : folder_(folder) {
    write(folder / "graph.yaml", graph);
    for (const char* name : {"a", "b"}) {
      fs::create_directories(folder / name);
      write(folder / name / "photo.ppm", photo(random));
      set_old_time(folder / name / "photo.ppm");
    }
    write(folder / "photo.ppm", photo(random));
    set_old_time(folder / "photo.ppm");
    link(folder / "link.ppm", "a/photo.ppm");
    link(folder / "folder", "a");
  }

  std::string change(Random& random) {
    const fs::path file =
        random.below(2) ? folder_ / "photo.ppm" : folder_ / (random.below(2) ? "a" : "b") / "photo.ppm";
    switch (random.below(5)) {
      case 0:
        link(folder_ / "link.ppm", std::string(random.below(2) ? "a" : "b") + "/photo.ppm");
        return "link.ppm changed its target";
      case 1:
        link(folder_ / "folder", random.below(2) ? "a" : "b");
        return "folder link changed its target";
      case 2:  // in place
        write(file, photo(random));
        set_old_time(file);
        return "overwritten in place, time restored: " + file.string();
      case 3: {  // another file with the same name, as after mv or cp -p
        const fs::path other = file.string() + ".other";
        write(other, photo(random));
        set_old_time(other);
        fs::rename(other, file);
        return "replaced, time kept: " + file.string();
      }
      default:  // unpacked again: the system often reuses the inode of the removed file
        fs::remove(file);
        write(file, photo(random));
        set_old_time(file);
        return "removed and created again: " + file.string();
    }
  }

 private:
  fs::path folder_;
};

std::vector<std::string> arguments(const fs::path& folder, const std::string& out, bool cached) {
  std::vector<std::string> a = {"run", (folder / "graph.yaml").string(), "--out", (folder / out).string(),
                                "--quiet"};
  if (cached)
    a.insert(a.end(), {"--cache", (folder / "cache").string()});
  else
    a.push_back("--no-cache");
  return a;
}

std::map<std::string, std::string> contents(const Graph& g, const RunResult& r) {
  std::map<std::string, std::string> out;
  for (std::size_t i = 0; i < g.nodes.size(); ++i) {
    if (r.nodes[i].error) throw std::runtime_error(r.nodes[i].error->text());
    for (const auto& [port, record] : r.nodes[i].outputs)
      out[g.nodes[i].path + "." + port] = record.content.text();
  }
  return out;
}

// Makes one edit of the session's graph and returns its description.
std::string edit(Session& session, Random& random) {
  static const std::vector<std::pair<std::string, std::vector<std::string>>> parameters = {
      {"wood.seed", {"1", "2", "3"}},         {"wood.scale", {"1", "2", "4"}},
      {"wood.kind", {"wood", "fat", "bone"}}, {"marble.seed", {"1", "2"}},
      {"marble.offset", {"0", "5"}},          {"photo.pixel_size", {"1", "2"}},
      {"linked.colorspace", {"auto", "auto"}}};
  static const std::vector<std::pair<std::string, std::vector<std::vector<std::string>>>> wires = {
      {"sheet.images", {{"wood.image"}, {"photo.image", "wood.image"}, {"wood.image", "marble.image"}}},
      {"all.images",
       {{"sheet.image"}, {"sheet.image", "linked.image"}, {"marble.image", "inside.image", "sheet.image"}}}};
  Diagnostics found;
  std::string what;
  if (random.below(4)) {
    const auto& [name, values] = parameters[random.below(parameters.size())];
    const std::string& value = values[random.below(values.size())];
    what = name + "=" + value;
    found = session.set(name, value);
  } else {
    const auto& [input, choices] = wires[random.below(wires.size())];
    const auto& sources = choices[random.below(choices.size())];
    what = fmt::format("{} from {}", input, fmt::join(sources, ", "));
    found = session.connect(input, sources);
  }
  if (has_errors(found)) throw std::runtime_error(what + ": " + found.front().text());
  return what;
}

// A session under many edits, some during evaluation. Each result is compared with that of a new session
// without a cache.
void edit_session(const fs::path& folder, Inputs& inputs, Random& random, int edits) {
  const NodeSet& nodes = node_set();
  const auto must_open = [&](Session& s, const Overrides& overrides) {
    const Diagnostics found = s.open(folder / "graph.yaml", overrides);
    if (has_errors(found)) throw std::runtime_error(found.front().text());
  };
  SessionOptions options{.cache_folder = folder / "cache", .output_folder = folder / "session"};
  if (random.below(2)) options.memory = 1;  // keeps nothing in memory
  Session session(nodes.registry, nodes.types, options);
  must_open(session, {});
  std::string what;
  for (int i = 0; i < edits; ++i) {
    what += edit(session, random) + "; ";
    if (random.below(3) == 0) {
      session.evaluate();  // canceled by the next edit, or because nobody waits for it
      what += edit(session, random) + "; ";
    }
    if (random.below(3) == 0) what += inputs.change(random) + "; ";
    const auto running = session.evaluate();
    const auto given = contents(running->graph(), running->wait());
    Session fresh(nodes.registry, nodes.types, {.output_folder = folder / "fresh"});
    must_open(fresh, session.overrides());
    const auto clean = fresh.evaluate();
    if (given != contents(clean->graph(), clean->wait())) throw std::runtime_error("stale after " + what);
  }
}

}  // namespace

Counts random_edits(const Options& o) {
  Random start(o.seed, 5, 0);
  const fs::path folder = fs::canonical(o.folder);
  Inputs inputs(folder, start);
  Counts counts{{"edits of a session", 0}, {"changes of files", 0}, {"changes during a run", 0}};
  repeat(o, "random_edits", [&](std::uint64_t trial) {
    Random random(o.seed, 6, trial);
    const auto good = [](const Ended& e) {
      if (e.exit_code != 0) throw std::runtime_error(e.text());
    };
    if (trial % 4 == 0) {
      constexpr int edits = 15;
      good(Child(
               [&] {
                 edit_session(folder, inputs, random, edits);
                 return 0;
               },
               folder)
               .wait());
      counts["edits of a session"] += edits;
      return;
    }
    std::string what;
    if (random.below(3) == 0) {
      Child running(arguments(folder, "out", true), folder);
      for (auto n = 1 + random.below(4); n > 0; --n) {
        ::usleep(static_cast<useconds_t>(random.below(8000)));
        what += inputs.change(random) + "; ";
      }
      const Ended e = running.wait();  // a file that is being replaced is missing for a moment
      if (e.hung || e.signal) throw std::runtime_error(e.text());
      ++counts["changes during a run"];
    } else {
      what = inputs.change(random);
      ++counts["changes of files"];
    }
    good(run(arguments(folder, "out", true), folder));
    good(run(arguments(folder, "fresh", false), folder));
    if (test::report_contents(folder / "out/report.json") !=
        test::report_contents(folder / "fresh/report.json"))
      throw std::runtime_error("stale after " + what);
  });
  return counts;
}

}  // namespace terrazzo::torture
