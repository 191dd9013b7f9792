#include "runtime/clients/cli/slurm/slurm_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "graph/text/utf8.h"
#include "runtime/files.h"
#include "runtime/sweep/sweep_log.h"

namespace terrazzo::cli {
namespace fs = std::filesystem;
namespace {

constexpr double kSecondsPerChunk = 300;
constexpr std::size_t kChunksIfUnknown = 100;

std::string absolute_folder(const fs::path& path) { return fs::absolute(path).lexically_normal().string(); }

std::string joined(const std::vector<std::string>& list) {
  std::string out;
  for (const auto& item : list) out += (out.empty() ? "" : ",") + item;
  return out;
}

}  // namespace

std::string quoted_word(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string profile_text(const SlurmOptions& slurm) {
  if (slurm.profile.empty()) return "";
  auto text = read_file(slurm.profile);
  if (!text)
    throw Error("usage", fmt::format("cannot read the profile '{}'", slurm.profile), "see --slurm-profile");
  if (!text->ends_with('\n')) *text += '\n';
  return *text;
}

std::vector<std::string> sbatch_arguments(const std::string& name, const fs::path& folder,
                                          const std::string& log, const GraphOptions& o,
                                          const SlurmOptions& slurm) {
  std::string place;  // sbatch replaces % in names
  for (const char c : absolute_folder(folder)) place += c == '%' ? std::string("%%") : std::string(1, c);
  std::vector<std::string> out = {"--requeue", "--open-mode=append", "--job-name=" + name,
                                  "--output=" + place + "/" + log};
  if (!slurm.partition.empty()) out.push_back("--partition=" + slurm.partition);
  if (o.threads > 0) out.push_back(fmt::format("--cpus-per-task={}", o.threads));
  out.insert(out.end(), slurm.options.begin(), slurm.options.end());
  return out;
}

std::string slurm_job_prefix(const Hash& sweep, const fs::path& out) {
  return "terrazzo-" + hash_of(sweep.text() + absolute_folder(out)).text().substr(0, 12) + "-";
}

SlurmJobs::SlurmJobs(const Hash& sweep, const std::string& folder, const fs::path& out, const GraphOptions& o,
                     const SlurmOptions& slurm)
    : sweep_(sweep),
      options_(o),
      slurm_(slurm),
      out_(absolute_folder(out)),
      prefix_(slurm_job_prefix(sweep, out)) {
  for (const std::string& path : {out_.string(), absolute_folder(o.graph), folder})
    if (find_invalid_utf8(path) != std::string::npos)
      throw Error("usage", fmt::format("'{}' is not UTF-8, which --executor slurm needs", valid_utf8(path)));
  profile_ = profile_text(slurm);
}

std::string SlurmJobs::shared_name() const { return prefix_ + terrazzo::shared_name; }
std::string SlurmJobs::chunks_name(std::size_t chunks) const { return prefix_ + std::to_string(chunks); }

std::size_t SlurmJobs::chunk_size(std::size_t points, double point_seconds) const {
  const std::size_t largest = slurm::largest_array();
  const std::size_t smallest = (points + largest - 1) / largest;
  std::size_t size = slurm_.chunk_size;
  if (size > 0 && size < smallest)
    std::cerr << fmt::format("note: chunks have {} points, because Slurm allows {} tasks here\n", smallest,
                             largest);
  if (size == 0)
    size = point_seconds > 0
               ? static_cast<std::size_t>(std::clamp(kSecondsPerChunk / point_seconds, 1.0, 1e5))
               : (points + kChunksIfUnknown - 1) / kChunksIfUnknown;
  return std::clamp(size, smallest, points);
}

fs::path SlurmJobs::script(const std::string& name, const std::string& part) const {
  // `exec`, so that Slurm's signals reach the program.
  std::string text = fmt::format(
      "#!/bin/bash\n{}exec ${{TERRAZZO:-{}}} sweep-worker {} {} --expect {} --threads {} --cache {}",
      profile_, quoted_word(fs::read_symlink("/proc/self/exe").string()),
      quoted_word((out_ / "sweep.json").string()), part, sweep_.text(),
      options_.threads > 0 ? std::to_string(options_.threads) : "\"${SLURM_CPUS_ON_NODE:-0}\"",
      quoted_word(absolute_folder(options_.cache.empty() ? default_cache() : fs::path(options_.cache))));
  if (options_.memory > 0) text += fmt::format(" --memory {}", options_.memory);
  const fs::path path = jobs_folder(out_) / name;
  write_text_atomically(path, text + "\n");
  return path;
}

std::vector<std::string> SlurmJobs::arguments(const std::string& name, const std::string& log,
                                              const std::vector<std::string>& exclude) const {
  auto out = sbatch_arguments(name, jobs_folder(out_), log, options_, slurm_);
  if (!exclude.empty()) out.insert(out.begin(), "--exclude=" + joined(exclude));
  return out;
}

std::uint64_t SlurmJobs::submit_shared(const std::vector<std::string>& exclude) const {
  auto command = arguments(shared_name(), std::string(terrazzo::shared_name) + ".txt", exclude);
  command.push_back(script("shared.sh", "--shared").string());
  return slurm::submit(command);
}

std::uint64_t SlurmJobs::submit_chunks(const std::vector<std::size_t>& numbers, std::size_t chunks,
                                       bool need_shared, std::uint64_t after,
                                       const std::vector<std::string>& exclude) const {
  auto command = arguments(chunks_name(chunks), fmt::format("chunk-%a-of-{}.txt", chunks), exclude);
  command.push_back("--array=" + slurm::ranges(numbers) +
                    (slurm_.parallel > 0 ? fmt::format("%{}", slurm_.parallel) : ""));
  if (after > 0) {
    command.push_back(fmt::format("--dependency=afterok:{}", after));
    command.push_back("--kill-on-invalid-dep=yes");
  }
  command.push_back(script("chunks.sh", fmt::format("--chunk \"$SLURM_ARRAY_TASK_ID/{}\"{}", chunks,
                                                    need_shared ? " --need-shared" : ""))
                        .string());
  return slurm::submit(command);
}

}  // namespace terrazzo::cli
