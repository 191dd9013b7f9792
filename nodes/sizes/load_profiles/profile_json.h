// Profiles as JSON, with outlines: what Export and `terrazzo show --json` write.
#pragma once

#include <string>

#include "nodes/data/profiles.h"

namespace terrazzo::load_profiles {

// Whether the text is a JSON object, which no table is.
bool is_json(const std::string& text);

// Reads the fields of Profiles, in mm, with every number as it was written. If the object has several values,
// as Export writes several inputs, the field `profiles` is read. `file` is used in messages only. Throws
// Error "unreadable-file" if the structure is another, "bad-profile" with the index of the profile.
Profiles read_profiles_json(const std::string& text, const std::string& file);

}  // namespace terrazzo::load_profiles
