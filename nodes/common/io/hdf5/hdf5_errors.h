// Errors of the reader of HDF5 files.
#pragma once

#include <string>

#include "graph/diagnostic.h"

namespace terrazzo {

[[noreturn]] inline void hdf5_damaged(const std::string& what) {
  throw Error("unreadable-volume", what, "write the file again");
}
[[noreturn]] inline void hdf5_unsupported(
    const std::string& what,
    const std::string& hint =
        "write the file again with the default settings of HDF5, for example with h5py") {
  throw Error("unreadable-volume", what, hint);
}

}  // namespace terrazzo
