// The test bed of the trials: a small graph that writes files, in several variants, the results of clean runs
// for comparison, and user files that must stay untouched.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/torture/child.h"
#include "tests/torture/torture.h"

namespace terrazzo::torture {

class Bed {
 public:
  explicit Bed(const Options&);

  static constexpr int variants = 5;
  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path out() const { return folder_ / "out"; }
  std::filesystem::path cache() const { return folder_ / "cache"; }
  double seconds() const { return seconds_; }  // duration of a clean run

  std::vector<std::string> arguments(int variant, const std::filesystem::path& out,
                                     const std::filesystem::path& cache) const;
  std::vector<std::string> arguments(int variant) const { return arguments(variant, out(), cache()); }

  // Replaces the output folder or the cache by a new one with the user's files in it.
  void new_out();
  void new_cache();

  // These checks return a description of the fault, or "".
  // Every file under a final name in an output folder is a complete file of some variant.
  std::string what_is_broken(const std::filesystem::path& out) const;
  // Contents and files equal those of this variant.
  std::string what_differs(int variant, const std::filesystem::path& out) const;
  std::string what_the_user_lost() const;
  // Runs this variant and compares everything. This must succeed in any state that a trial leaves behind.
  std::string what_a_run_gives(int variant) const;

 private:
  struct Clean {
    std::map<std::string, std::string> contents;  // by NODE.PORT
    std::map<std::string, std::string> files;     // by path below the output folder
  };
  void keep(const std::filesystem::path& file, const std::string& text);

  std::filesystem::path folder_;
  double seconds_ = 0;
  std::vector<Clean> clean_;
  std::map<std::filesystem::path, std::string> users_;  // their content
};

// Calls `trial` with 0, 1, 2 … until the time is over, at least once. Adds the part's name, the seed and the
// trial number to exceptions.
void repeat(const Options&, const std::string& part, const std::function<void(std::uint64_t)>& trial);

}  // namespace terrazzo::torture
