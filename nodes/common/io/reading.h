// Common to all readers of untrusted files: memory budget and warnings. Messages quote a file's content with
// `printable`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "graph/text/utf8.h"
#include "runtime/memory.h"

namespace terrazzo {

class Context;

// Memory that a reader may allocate in bytes, and the receiver of its warnings (none by default).
struct Reading {
  std::uint64_t memory = available_memory();
  std::function<void(const std::string&)> warn = [](const std::string&) {};
};
// The memory budget and the warnings of a node.
Reading reading_of(Context&);

// The whole content of a regular file. Throws Error "too-large" if it exceeds the memory budget,
// "unreadable-file" if it cannot be read.
std::string read_whole(const std::filesystem::path&, const Reading&);

}  // namespace terrazzo
