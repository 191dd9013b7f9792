// JSON of values, shortened for people.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>

namespace terrazzo {

// Replaces lists of more than `most` entries by {"shown": [the first ones], "of": their number}. Lists of
// numbers may have 20 times as many, so that curves are complete up to a limit.
void shorten_lists(nlohmann::json&, std::size_t most);

// Shortens lists and texts until the text of the JSON has about 20,000 characters or fewer.
nlohmann::json summary_json(const nlohmann::json&);

}  // namespace terrazzo
