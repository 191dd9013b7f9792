// Available memory, so that a file whose header asks for too much is rejected before anything is allocated.
#pragma once

#include <cstdint>
#include <string>

namespace terrazzo {

// Bytes that this process can still allocate: the minimum of the machine's available memory, the rest of its
// control groups' limits (versions 1 and 2), and the rest of its address space limit (ulimit -v).
std::uint64_t available_memory();

// The rest of the address space limit, or UINT64_MAX if there is no limit.
std::uint64_t available_address_space();

// Throws Error "too-large" if `bytes` exceeds `limit`: "WHAT needs 3.2 GB of memory, but only 2.0 GB are
// available".
void require_memory(double bytes, std::uint64_t limit, const std::string& what);

}  // namespace terrazzo
