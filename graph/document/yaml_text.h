// Values as YAML text, as a person would write them.
#pragma once

#include <string>
#include <vector>

#include "graph/parameter.h"

namespace terrazzo {

// A scalar, in quotes if it needs them. Valid inside of {} and [] too.
std::string yaml_word(const std::string&);
// "[a, b]"
std::string yaml_list(const std::vector<std::string>&);
std::string yaml_value(const WrittenValue&);

}  // namespace terrazzo
