// ./dev contents [NODE...]: updates this machine's entry in tests/contract/contents.json, or only these nodes
// in it. Refuses results that changed while the version of their node did not.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "nodes/register_nodes.h"
#include "tests/contract/contents.h"

int main(int argc, char** argv) try {
  using namespace terrazzo;
  using nlohmann::json;
  Registry registry;
  register_nodes(registry);
  json all = test::read_contents();
  const json machine = test::this_machine();
  const json* known = test::contents_on(all, machine);
  const json before = known ? *known : json::object();
  const std::vector<std::string> chosen(argv + 1, argv + argc);
  for (const std::string& name : chosen)
    if (!registry.find(name)) throw std::runtime_error("there is no node " + name);
  json types = chosen.empty() ? json::object() : before;
  int changed = 0, refused = 0;
  for (const NodeType* type : registry.all()) {
    if (!chosen.empty() && std::find(chosen.begin(), chosen.end(), type->name) == chosen.end()) continue;
    json now = test::example_contents(registry, *type, 2);
    const auto it = before.find(type->name);
    bool same_version = false;
    const std::string difference = it == before.end()
                                       ? type->name + " is new"
                                       : test::compare_contents(type->name, *it, now, &same_version);
    if (!difference.empty()) std::cerr << difference << '\n';
    changed += !difference.empty();
    refused += same_version;
    types[type->name] = std::move(now);
  }
  if (refused) {
    std::cerr << "nothing was written: " << refused << " results changed under the same version\n";
    return 1;
  }
  bool found = false;
  for (auto& entry : all)
    if (entry.at("machine") == machine) entry["types"] = types, found = true;
  if (!found) all.push_back({{"machine", machine}, {"types", types}});
  std::ofstream out(test::contents_file());
  out << all.dump(1) << '\n';
  if (!out.flush()) throw std::runtime_error("cannot write " + test::contents_file().string());
  std::cerr << types.size() << " node types, " << changed << " changed: " << test::contents_file().string()
            << '\n';
} catch (const std::exception& e) {
  std::cerr << "error: " << e.what() << '\n';
  return 1;
}
