// What every reader of foreign files shares: its budget, the way it warns, and how it quotes what it found.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "runtime/memory.h"

namespace terrazzo {

class Context;

// Bytes that a reader may allocate, and where its warnings go (nowhere by default).
struct Reading {
  std::uint64_t memory = available_memory();
  std::function<void(const std::string&)> warn = [](const std::string&) {};
};
// The budget and the warnings of a node.
Reading reading_of(Context&);

// Text from a file or from a library, fit for a message: invalid UTF-8 and control characters become '?',
// runs of blanks become one, and what exceeds 200 bytes is cut.
std::string printable(std::string_view foreign);

// The whole content of a regular file. Throws Error "too-large" if it exceeds the budget and
// "unreadable-file" if it cannot be read.
std::string read_whole(const std::filesystem::path&, const Reading&);

}  // namespace terrazzo
