// Contents that the nodes' examples gave, recorded with the version of each node, so that a changed result
// under an unchanged version is noticed. Bits depend on the machine: each combination of libraries and CPU
// features has its own.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "graph/registry.h"

namespace terrazzo::test {

// What can change bits here: {"compiler": …, "libc": …, "cpu": …, "libraries": …}.
nlohmann::json this_machine();

// Of one node type in its example: by node "version", "key" (type, version, parameters, content of inputs)
// and "outputs" or "files" (content by name). Throws std::runtime_error if the example fails.
nlohmann::json example_contents(const Registry&, const NodeType&, int threads);

std::filesystem::path example_file(const NodeType&);

// What is wrong between the contents recorded for a type and those of now, with what to do; "" if nothing is.
// `same_version`: set if results changed that no raised version explains.
std::string compare_contents(const std::string& type, const nlohmann::json& recorded,
                             const nlohmann::json& now, bool* same_version = nullptr);

// The file with the contents of all combinations, and where a combination is in it.
std::filesystem::path contents_file();
nlohmann::json read_contents();
const nlohmann::json* contents_on(const nlohmann::json& all, const nlohmann::json& machine);

}  // namespace terrazzo::test
