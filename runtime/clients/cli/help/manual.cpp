#include "runtime/clients/cli/help/manual.h"

#include <fmt/format.h>

#include <iostream>

#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/help/declared.h"
#include "runtime/clients/cli/help/manual_text.h"
#include "runtime/clients/cli/help/roff.h"
#include "runtime/report/provenance.h"

namespace terrazzo::cli {
namespace {

std::string full_name(const CLI::App& app) {
  return app.get_parent() ? full_name(*app.get_parent()) + " " + app.get_name() : app.get_name();
}

// "terrazzo show [OPTION...] GRAPH NODE.PORT"
std::string usage(const CLI::App& command) {
  std::string out = roff_bold(full_name(command));
  if (named_options(command).size() > 1) out += " [" + roff_italic("OPTION") + "...]";  // --help is one
  for (const CLI::Option* o : arguments(command)) {
    const std::string name = roff_italic(placeholder_of(*o));
    out += o->get_required() ? " " + name : " [" + name + "]";
  }
  return out;
}

// The commands that run something, which are those without subcommands.
std::vector<const CLI::App*> all_commands(const CLI::App& app) {
  std::vector<const CLI::App*> out;
  for (const CLI::App* command : subcommands(app)) {
    const auto inner = all_commands(*command);
    if (inner.empty()) out.push_back(command);
    out.insert(out.end(), inner.begin(), inner.end());
  }
  return out;
}

std::string option_entry(const CLI::Option& o) {
  std::string title;
  for (const auto& name : names_of(o)) title += (title.empty() ? "" : ", ") + roff_bold(name);
  if (o.get_positional() || takes_value(o))
    title += (title.empty() ? "" : " ") + roff_italic(placeholder_of(o));
  std::string text = o.get_description() + ".";
  if (o.get_required() && !o.get_positional()) text += " Required.";
  if (!o.get_default_str().empty()) text += " Default: " + o.get_default_str() + ".";
  return roff_entry(title, roff_text(text));
}

std::string command_section(const CLI::App& command) {
  std::string out = ".SS " + usage(command) + "\n" + roff_text(command.get_description()) + ".\n";
  for (const CLI::Option* o : arguments(command)) out += option_entry(*o);
  for (const CLI::Option* o : named_options(command))
    if (o != command.get_help_ptr()) out += option_entry(*o);
  return out;
}

}  // namespace

std::string manual(const CLI::App& app) {
  const std::string name = app.get_name(), about = app.get_description();
  std::string out =
      fmt::format(".TH {0} 1 \"\" \"{0} {1}\" \"User Commands\"\n", name, roff_text(program_version));
  out += ".SH NAME\n" + name + " \\- " + roff_text(about.substr(about.find(": ") + 2)) + "\n";
  out += ".SH SYNOPSIS\n";
  for (const CLI::App* command : all_commands(app)) out += usage(*command) + "\n.br\n";
  out += roff_bold(name) + " [" + roff_italic("OPTION") + "]\n";
  out += manual_description();
  out += ".SH OPTIONS\nEvery command accepts " + roff_bold("--help") + ".\n";
  for (const CLI::Option* o : named_options(app)) out += option_entry(*o);
  out += ".SH COMMANDS\n";
  for (const CLI::App* command : all_commands(app)) out += command_section(*command);
  return out + manual_end();
}

void add_manual(CLI::App& app) {
  app.add_subcommand("manual", "Print this program's manual page as roff, for `man -l`")->callback([&app] {
    std::cout << manual(app);
  });
}

}  // namespace terrazzo::cli
