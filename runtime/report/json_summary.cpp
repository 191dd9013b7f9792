#include "runtime/report/json_summary.h"

#include <nlohmann/json.hpp>

#include "graph/text/utf8.h"

namespace terrazzo {
using nlohmann::json;
namespace {

void shorten_texts(json& j, std::size_t most) {
  if (j.is_string() && j.get_ref<const std::string&>().size() > most)
    j = valid_utf8(j.get_ref<const std::string&>().substr(0, most)) + "…";
  if (j.is_structured())
    for (auto& x : j) shorten_texts(x, most);
}

}  // namespace

void shorten_lists(json& j, std::size_t most) {
  if (j.is_array() && j.size() > most) {
    const bool numbers = j[0].is_number() && j.size() <= 20 * most;
    if (!numbers) {
      const std::size_t all = j.size();
      j.erase(j.begin() + most, j.end());
      for (auto& x : j) shorten_lists(x, most);
      j = {{"shown", j}, {"of", all}};
      return;
    }
  }
  if (j.is_structured())
    for (auto& x : j) shorten_lists(x, most);
}

json summary_json(const json& all) {
  constexpr std::size_t kMostCharacters = 20'000;
  json out;
  for (const std::size_t most : {50, 20, 8, 3, 1}) {
    out = all;
    shorten_lists(out, most);
    shorten_texts(out, 200);
    if (out.dump(-1, ' ', false, json::error_handler_t::replace).size() <= kMostCharacters) break;
  }
  return out;
}

}  // namespace terrazzo
