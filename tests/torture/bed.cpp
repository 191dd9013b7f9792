#include "tests/torture/bed.h"

#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "runtime/files.h"
#include "tests/support/report_contents.h"

namespace terrazzo::torture {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr const char* graph = R"(terrazzo: 1
parameters:
  seed: {type: int, default: 1}
nodes:
  wood: {type: Pattern, params: {width: 16, height: 16, seed: '${seed}'}}
  photo: {type: LoadImage, params: {path: photo.ppm}}
  shape: {type: Shape, params: {kind: box, axes: [1, 2, '${seed}']}}
  sizes: {type: Distribution, params: {mean: 5, classes: 6}}
  picture: {type: Export, inputs: {image: wood.image}, params: {path: wood.png}}
  copy: {type: Export, inputs: {image: photo.image}, params: {path: copy.png}}
  mesh: {type: Export, inputs: {shapes: shape.shapes}, params: {path: sub/shape.glb}}
  table: {type: Export, inputs: {value: sizes.distribution}, params: {path: sub/sizes.csv}}
)";

// Files that every variant writes identically, except for their provenance, which names the run that first
// wrote them.
const std::set<std::string> alike = {"copy.png", "sub/sizes.csv"};

void write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

// Files by path below the folder, without the report, which contains times.
std::map<std::string, std::string> files_in(const fs::path& folder) {
  std::map<std::string, std::string> found;
  for (const auto& e : fs::recursive_directory_iterator(folder))
    if (e.is_regular_file() && e.path().filename() != "report.json")
      found[fs::relative(e.path(), folder).string()] = read_file(e.path()).value_or("");
  return found;
}

}  // namespace

Bed::Bed(const Options& o) : folder_(fs::canonical(o.folder)) {
  write(folder_ / "graph.yaml", graph);
  std::string photo = "P6\n8 8\n255\n";
  for (int i = 0; i < 192; ++i) photo += static_cast<char>(i * 37 + 11);
  write(folder_ / "photo.ppm", photo);
  keep(folder_ / "graph.yaml", graph);
  keep(folder_ / "photo.ppm", photo);
  keep(folder_ / "notes.txt", "beside the output folder");
  for (int variant = 0; variant < variants; ++variant) {
    const fs::path out = folder_ / fmt::format("clean{}", variant);
    const Ended e = run(arguments(variant, out, folder_ / "clean_cache"), folder_);
    if (e.exit_code != 0) throw std::runtime_error("the clean run failed: " + e.text());
    clean_.push_back({test::report_contents(out / "report.json"), files_in(out)});
    if (clean_.back().files.size() != 4 || clean_.back().contents.size() < 4)
      throw std::runtime_error("the clean run has missing outputs: " + e.text());
    seconds_ = e.seconds;
  }
  new_out();
  new_cache();
}

std::vector<std::string> Bed::arguments(int variant, const fs::path& out, const fs::path& cache) const {
  return {"run",
          (folder_ / "graph.yaml").string(),
          "--cache",
          cache.string(),
          "--out",
          out.string(),
          "--quiet",
          "--param",
          fmt::format("seed={}", variant + 1)};
}

void Bed::keep(const fs::path& file, const std::string& text) {
  write(file, text);
  // Old enough for every rule that protects recent files.
  fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(72));
  users_[file] = text;
}

void Bed::new_out() {
  fs::remove_all(out());
  keep(out() / "notes.txt", "in the output folder");
  keep(out() / "sub" / "wood.png.txt", "in a folder that the graph writes to");
}

void Bed::new_cache() {
  for (auto it = users_.begin(); it != users_.end();)
    it = it->first.string().rfind(cache().string() + "/", 0) == 0 ? users_.erase(it) : std::next(it);
  fs::remove_all(cache());
  const Ended e = run(arguments(0, folder_ / "clean0", cache()), folder_);  // turns the folder into a cache
  if (e.exit_code != 0) throw std::runtime_error("a run with a new cache failed: " + e.text());
  keep(cache() / "thesis.doc", "in the cache folder");
  for (const char* name : {"values", "actions", "files", "history"})
    if (fs::is_directory(cache() / name)) {
      keep(cache() / name / "thesis.doc", "deep in the cache folder");
      keep(cache() / name / "ab" / "thesis.doc", "deeper in the cache folder");
    }
}

std::string Bed::what_is_broken(const fs::path& out) const {
  if (!fs::exists(out)) return {};
  for (const auto& e : fs::recursive_directory_iterator(out)) {
    if (!e.is_regular_file() || users_.count(e.path())) continue;
    const std::string name = fs::relative(e.path(), out).string();
    const std::string text = read_file(e.path()).value_or("");
    if (e.path().filename() == "report.json") {
      if (!json::accept(text)) return fmt::format("{} is incomplete", e.path().string());
      continue;
    }
    bool known = e.path().filename().string()[0] == '.';  // a temporary file
    for (const Clean& c : clean_) known = known || (c.files.count(name) && c.files.at(name) == text);
    if (!known)
      return fmt::format("{} ({} bytes) is not a file that a clean run writes", e.path().string(),
                         text.size());
  }
  return {};
}

std::string Bed::what_differs(int variant, const fs::path& out) const {
  const Clean& clean = clean_[static_cast<std::size_t>(variant)];
  const auto contents = test::report_contents(out / "report.json");
  for (const auto& [port, content] : clean.contents)
    if (const auto it = contents.find(port); it == contents.end() || it->second != content)
      return fmt::format("{} is {}, not {}", port, it == contents.end() ? "missing" : it->second, content);
  for (const auto& [name, text] : clean.files) {
    const auto given = read_file(out / name);
    bool right = given == text;
    if (alike.count(name))
      for (const Clean& c : clean_) right = right || given == c.files.at(name);
    if (!right) return fmt::format("{} is missing or wrong", (out / name).string());
  }
  return {};
}

std::string Bed::what_the_user_lost() const {
  for (const auto& [file, text] : users_)
    if (read_file(file) != text) return fmt::format("the user's file {} is lost or changed", file.string());
  return {};
}

std::string Bed::what_a_run_gives(int variant) const {
  const Ended e = run(arguments(variant), folder_);
  if (e.exit_code != 0) return "the next run failed: " + e.text();
  return what_differs(variant, out());
}

void repeat(const Options& o, const std::string& part, const std::function<void(std::uint64_t)>& trial) {
  const double start = now();
  for (std::uint64_t i = 0; i == 0 || now() - start < o.seconds; ++i) try {
      trial(i);
    } catch (const std::exception& e) {
      throw std::runtime_error(fmt::format("{}, seed {}, trial {}: {}", part, o.seed, i, e.what()));
    }
}

}  // namespace terrazzo::torture
