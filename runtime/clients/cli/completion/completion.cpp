#include <iostream>
#include <memory>

#include "runtime/clients/cli/commands.h"
#include "runtime/clients/cli/completion/completion_scripts.h"

namespace terrazzo::cli {

void add_completion(CLI::App& app) {
  auto* command = app.add_subcommand("completion", "Print a script that completes commands in a shell");
  auto shell = std::make_shared<std::string>();
  command->add_option("shell", *shell, "Shell: bash, zsh or fish")
      ->required()
      ->type_name("SHELL")
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command->callback([shell] { std::cout << completion_script("terrazzo." + *shell); });
}

}  // namespace terrazzo::cli
