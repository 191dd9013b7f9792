// Content hashes of the nodes' examples, recorded with the version of each node to detect results that change
// without a new version. Bits depend on the machine, so each combination of libraries and CPU features has
// its own entry.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "graph/registry.h"

namespace terrazzo::test {

// The properties of this machine that can change bits: {"compiler": …, "libc": …, "cpu": …, "libraries": …}.
nlohmann::json this_machine();

// Runs a node type's example. Returns, for each node of that type, "version", "key" (hash of type, version,
// parameters and inputs) and "outputs" or "files" (content by name). Throws std::runtime_error if the example
// fails. `cache`: the cache folder, or none.
nlohmann::json example_contents(const Registry&, const NodeType&, int threads,
                                const std::filesystem::path& cache = {});

std::filesystem::path example_file(const NodeType&);

// Describes the difference between a type's recorded and current contents and what to do; "" if they agree.
// `same_version` is set if results changed without a new version.
std::string compare_contents(const std::string& type, const nlohmann::json& recorded,
                             const nlohmann::json& now, bool* same_version = nullptr);

// The file with the contents of all machines, and the entry of one machine in it.
std::filesystem::path contents_file();
nlohmann::json read_contents();
const nlohmann::json* contents_on(const nlohmann::json& all, const nlohmann::json& machine);

}  // namespace terrazzo::test
