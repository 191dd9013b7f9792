// How much memory a computation may take, so that a file whose header asks for too much is refused before
// anything is allocated.
#pragma once

#include <cstdint>
#include <string>

namespace terrazzo {

// Bytes that this process can still allocate: the least of the machine's available memory, what the control
// groups that it runs in leave (versions 1 and 2), and what its address space limit (ulimit -v) leaves.
std::uint64_t available_memory();

// What the address space limit alone leaves; the largest number where there is none.
std::uint64_t available_address_space();

// Throws Error "too-large" if `bytes` exceed `limit`: "WHAT needs 3.2 GB of memory; 2.0 GB may be used".
void require_memory(double bytes, std::uint64_t limit, const std::string& what);

}  // namespace terrazzo
