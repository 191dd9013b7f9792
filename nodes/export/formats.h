// The formats of Export: which file name selects which, what each can hold, and what writes it.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "runtime/value.h"

namespace terrazzo::exporting {

struct Job;  // writers.h

struct Format {
  std::string extension;  // ".vti"
  // Types of values that it can hold, and names of texture maps; empty: any, and several.
  std::vector<std::string> types = {};
  std::vector<std::string> required = {};  // types without which it cannot be written
  bool several = false;                    // holds several values; otherwise one of `types`
  void (*write)(const Job&) = nullptr;
  // Types, and others that may be connected beside each, for what they add to it.
  std::vector<std::pair<std::string, std::string>> additions = {};
};

// README.md lists the places of a new format.
const std::vector<Format>& formats();

// By the end of the file name. Throws Error "unknown-format".
const Format& format_of(const std::string& path);

// Checks the connected values, by type name. Throws Error "format-does-not-fit", "no-shapes",
// "missing-input".
void check_fit(const Format&, const std::map<std::string, Value>&);

// Throws Error "no-shapes", "missing-input" if there is no value of this type.
void require_value(const Format&, const std::map<std::string, Value>&, const std::string& type);

// "a/block.inp" and "_periodic.inp" → "a/block_periodic.inp".
std::string beside(const std::string& path, const Format&, const std::string& end);

}  // namespace terrazzo::exporting
