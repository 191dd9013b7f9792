#include "runtime/clients/cli/help/declared.h"

namespace terrazzo::cli {

std::vector<const CLI::App*> subcommands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* a) { return !a->get_group().empty(); });
}

std::vector<const CLI::Option*> named_options(const CLI::App& app) {
  return app.get_options(
      [](const CLI::Option* o) { return !o->get_group().empty() && !o->get_positional(); });
}

std::vector<const CLI::Option*> arguments(const CLI::App& app) {
  return app.get_options([](const CLI::Option* o) { return o->get_positional(); });
}

const CLI::Option* find_option(const CLI::App& app, const std::string& name) {
  for (const CLI::Option* o : named_options(app))
    if (o->check_name(name)) return o;
  return nullptr;
}

bool takes_value(const CLI::Option& o) { return o.get_items_expected_max() > 0; }

bool repeatable(const CLI::Option& o) {
  return o.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
}

// CLI11 appends the description of every validator: "FORMAT:{dot,svg}".
std::string placeholder_of(const CLI::Option& o) {
  const std::string type = o.get_type_name();
  return type.substr(0, type.find(':'));
}

std::vector<std::string> choices_of(const CLI::Option& o) {
  const std::string type = o.get_type_name();
  const auto open = type.find(":{"), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return {};
  return CLI::detail::split(type.substr(open + 2, close - open - 2), ',');
}

std::vector<std::string> names_of(const CLI::Option& o) {
  std::vector<std::string> out;
  for (const auto& name : o.get_snames()) out.push_back("-" + name);
  for (const auto& name : o.get_lnames()) out.push_back("--" + name);
  return out;
}

}  // namespace terrazzo::cli
