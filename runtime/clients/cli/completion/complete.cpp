#include "runtime/clients/cli/completion/complete.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>

#include "graph/text/utf8.h"
#include "runtime/clients/cli/completion/complete_value.h"
#include "runtime/clients/cli/default_graph.h"
#include "runtime/clients/cli/help/declared.h"
#include "runtime/clients/cli/options.h"
#include "runtime/clients/cli/placeholders.h"

namespace terrazzo::cli {
namespace {

// What the words before the last one say about it.
struct TypedWords {
  const CLI::App* command = nullptr;     // null if there is no such command
  const CLI::Option* pending = nullptr;  // the option whose value comes next
  std::vector<const CLI::Option*> used;
  std::size_t arguments = 0;  // number of arguments so far
  bool options_ended = false;
  std::string graph;
};

void read_option(TypedWords& typed, const std::string& word) {
  const auto equals = word.find('=');
  const CLI::Option* o = find_option(*typed.command, word.substr(0, equals));
  if (!o) return;
  typed.used.push_back(o);
  if (equals == std::string::npos && takes_value(*o)) typed.pending = o;
}

void read_argument(TypedWords& typed, const std::string& word) {
  if (const auto commands = subcommands(*typed.command); !commands.empty()) {
    const auto it = std::find_if(commands.begin(), commands.end(),
                                 [&](const CLI::App* a) { return a->get_name() == word; });
    typed.command = it == commands.end() ? nullptr : *it;
    return;
  }
  const auto all = arguments(*typed.command);
  if (typed.arguments < all.size() && placeholder_of(*all[typed.arguments]) == placeholder::graph)
    typed.graph = word;
  ++typed.arguments;
}

TypedWords read_words(const CLI::App& app, const std::vector<std::string>& words) {
  TypedWords typed;
  typed.command = &app;
  for (std::size_t i = 0; i + 1 < words.size() && typed.command; ++i) {
    const std::string& word = words[i];
    if (typed.pending)
      typed.pending = nullptr;
    else if (!typed.options_ended && word == "--")
      typed.options_ended = true;
    else if (!typed.options_ended && word.size() > 1 && word[0] == '-')
      read_option(typed, word);
    else
      read_argument(typed, word);
  }
  if (!typed.command || typed.arguments > 0) return typed;
  for (const CLI::Option* o : arguments(*typed.command))
    if (placeholder_of(*o) == placeholder::graph && !o->get_required())
      typed.graph = default_graph().string();
  return typed;
}

std::vector<std::string> option_names(const TypedWords& typed) {
  std::vector<std::string> out;
  for (const CLI::Option* o : named_options(*typed.command)) {
    if (!repeatable(*o) && std::count(typed.used.begin(), typed.used.end(), o)) continue;
    for (auto& name : names_of(*o)) out.push_back(std::move(name));
  }
  return out;
}

std::vector<std::string> candidates(const CLI::App& app, const Program& program,
                                    const std::vector<std::string>& words) {
  const TypedWords typed = read_words(app, words);
  const std::string& last = words.back();
  if (!typed.command) return {};
  if (typed.pending) return complete_value(program, *typed.pending, typed.graph, last);
  if (!typed.options_ended && last.starts_with('-')) {
    const auto equals = last.find('=');
    if (equals == std::string::npos) return option_names(typed);
    const CLI::Option* o = find_option(*typed.command, last.substr(0, equals));
    if (!o || !takes_value(*o)) return {};
    auto values = complete_value(program, *o, typed.graph, last.substr(equals + 1));
    for (auto& value : values) value = last.substr(0, equals + 1) + value;
    return values;
  }
  std::vector<std::string> out;
  for (const CLI::App* command : subcommands(*typed.command)) out.push_back(command->get_name());
  if (!out.empty()) return out;
  const auto all = arguments(*typed.command);
  if (typed.arguments < all.size()) return complete_value(program, *all[typed.arguments], typed.graph, last);
  return typed.options_ended ? out : option_names(typed);
}

}  // namespace

std::vector<std::string> complete(const CLI::App& app, const Program& program,
                                  const std::vector<std::string>& words) {
  if (words.empty()) return {};
  auto found = candidates(app, program, words);
  // Shells read one candidate per line, and an escaped one would name something else.
  std::erase_if(found,
                [&](const std::string& c) { return !c.starts_with(words.back()) || escape_line(c) != c; });
  return found;
}

int print_completions(const CLI::App& app, const Program& program, std::vector<std::string> words) {
  if (!words.empty() && words[0] == "--") words.erase(words.begin());
  if (const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC); null >= 0) ::dup2(null, STDERR_FILENO);
  try {
    for (const auto& candidate : complete(app, program, words)) std::cout << candidate << '\n';
  } catch (...) {  // no candidates
  }
  return kDone;
}

}  // namespace terrazzo::cli
