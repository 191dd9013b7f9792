// Writing HDF5 files. Every failure becomes an Error, and equal content gives equal bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace terrazzo::exporting {

enum class Hdf5Type { Int32, UInt32, Int64, UInt64, UInt8, Float };

// A file that is being written. Paths of groups and datasets are absolute; missing groups are made. Only one
// file of the process is open at a time, because the library is not safe for threads: a second one waits. All
// functions throw Error "write-failed".
class Hdf5Output {
 public:
  // `compress`: datasets with rows of 4 KiB and more are compressed by zlib, row by row.
  explicit Hdf5Output(const std::filesystem::path&, bool compress = false);
  ~Hdf5Output();

  void group(const std::string& path);
  // A dataset of `size` elements along each axis, the last fastest. `fill(first, last, out)` gives the
  // elements of the rows first ≤ i < last of the first axis; it is called in order, for `rows` rows at a
  // time.
  void dataset(const std::string& path, Hdf5Type, const std::vector<std::uint64_t>& size, std::uint64_t rows,
               const std::function<void(std::uint64_t first, std::uint64_t last, void* out)>& fill);
  // All at once.
  void dataset(const std::string& path, Hdf5Type, const std::vector<std::uint64_t>& size, const void* data);
  // Texts of any length.
  void texts(const std::string& path, const std::vector<std::string>&);
  // A text of a fixed length.
  void text(const std::string& path, const std::string&);
  // Attributes of a group or dataset.
  void attribute(const std::string& path, const std::string& name, const std::string& text);
  void attribute(const std::string& path, const std::string& name, Hdf5Type, std::uint64_t count,
                 const void* data);

  // Closes the file. Without this call, the file is incomplete.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
  bool compress_ = false;
};

}  // namespace terrazzo::exporting
