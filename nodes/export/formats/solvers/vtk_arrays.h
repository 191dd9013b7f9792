// Arrays of VTK XML files (version 1.0): base64 on one line, plain or compressed by zlib in blocks.
#pragma once

#include <cstdint>
#include <functional>
#include <ostream>
#include <string>

#include "runtime/work.h"

namespace terrazzo::exporting {

// In the order of the words of the parameter `compression`.
enum class VtkCompression { Zlib, None };

// Planes of `plane_bytes` bytes each.
struct VtkArray {
  std::string name;
  const char* type = "Int32";  // of VTK
  int components = 1;
  std::size_t planes = 0, plane_bytes = 0;
  std::function<void(int z0, int z1, char* out)> fill;
};

// `data` must outlive the array.
VtkArray bytes_as_array(const std::string& name, const char* type, const void* data, std::size_t size);

class VtkStream {
 public:
  VtkStream(std::ostream& out, VtkCompression compression, Work work)
      : out_(out), compression_(compression), work_(std::move(work)) {}

  void line(const VtkArray&);                       // the encoded array on one line
  void element(const VtkArray&);                    // as a DataArray
  void tuples(const VtkArray&, std::size_t count);  // as a DataArray of field data

 private:
  void plain(const VtkArray&);
  void compressed(const VtkArray&);

  std::ostream& out_;
  VtkCompression compression_;
  Work work_;
};

}  // namespace terrazzo::exporting
