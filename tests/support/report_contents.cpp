#include "tests/support/report_contents.h"

#include <nlohmann/json.hpp>

#include "runtime/files.h"

namespace terrazzo::test {

std::map<std::string, std::string> report_contents(const std::filesystem::path& report) {
  std::map<std::string, std::string> found;
  const auto text = read_file(report);
  if (!text) return found;
  const auto all = nlohmann::json::parse(*text);
  for (const auto& node : all.at("nodes"))
    for (const auto& [port, o] : node.at("outputs").items())
      found[node.at("name").get<std::string>() + "." + port] = o.at("content");
  return found;
}

}  // namespace terrazzo::test
