// What the declarations of the command line say, for the manual and shell completion.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace terrazzo::cli {

// In the order of declaration, without those that help does not list.
std::vector<const CLI::App*> subcommands(const CLI::App&);
std::vector<const CLI::Option*> named_options(const CLI::App&);
std::vector<const CLI::Option*> arguments(const CLI::App&);

// The option that is called "--name" or "-n", or null.
const CLI::Option* find_option(const CLI::App&, const std::string& name);
bool takes_value(const CLI::Option&);
bool repeatable(const CLI::Option&);
std::string placeholder_of(const CLI::Option&);
// The values that an IsMember validator accepts. Empty if there is none.
std::vector<std::string> choices_of(const CLI::Option&);
// "--name" and "-n"
std::vector<std::string> names_of(const CLI::Option&);

}  // namespace terrazzo::cli
