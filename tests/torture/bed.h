// What the trials run: a small graph that writes files, in variants, with the results of clean runs to
// compare with, and files of the user's that nothing may touch.
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
  double seconds() const { return seconds_; }  // that a clean run takes

  std::vector<std::string> arguments(int variant, const std::filesystem::path& out,
                                     const std::filesystem::path& cache) const;
  std::vector<std::string> arguments(int variant) const { return arguments(variant, out(), cache()); }

  // Removes the output folder or the cache, and lays the user's files into the new one.
  void new_out();
  void new_cache();

  // What is wrong; "" if nothing is.
  // Every file under a final name in an output folder is that of some variant, whole.
  std::string what_is_broken(const std::filesystem::path& out) const;
  // Contents and files are those of this variant.
  std::string what_differs(int variant, const std::filesystem::path& out) const;
  std::string what_the_user_lost() const;
  // Runs this variant and compares everything: the state after whatever happened must allow that.
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
  std::map<std::filesystem::path, std::string> users_;  // what is in them
};

// The contents in the report of a run by NODE.PORT; nothing if there is no report.
std::map<std::string, std::string> report_contents(const std::filesystem::path& out);

// Calls `trial` with 0, 1, 2 … until the time is over, at least once. What it throws gets the part's name,
// the seed and the number of the trial.
void repeat(const Options&, const std::string& part, const std::function<void(std::uint64_t)>& trial);

}  // namespace terrazzo::torture
