#include "src/front/apps/completion.h"

#include <CLI/CLI.hpp>

namespace tessera::apps {
namespace {

void add_word(std::string& list, const std::string& word) { list += (list.empty() ? "" : " ") + word; }

std::string words(const std::vector<std::string>& list) {
  std::string text;
  for (const auto& word : list) add_word(text, word);
  return text;
}

// Returns the possible values of an option, separated by spaces; "" if any value is possible.
std::string values_of(const Command& command, const CLI::Option& option) { return words(choices_of(command, option)); }

// Returns the branches of one command: its options, and the values of options that have few. For other options the
// script offers no words, so the shell completes names of files.
std::string branches(const Command& command) {
  const auto name = command.app->get_name();
  std::string options, arguments, values, any;
  int positionals = 0;
  for (const auto* option : command.app->get_options()) {
    if (option->get_group().empty()) continue;
    if (option->get_positional()) {
      if (positionals++ == 0) arguments = values_of(command, *option);
      continue;
    }
    std::vector<std::string> flags;
    for (const auto& flag : option->get_snames()) flags.push_back("-" + flag);
    for (const auto& flag : option->get_lnames()) flags.push_back("--" + flag);
    for (const auto& flag : flags) add_word(options, flag);
    if (option->get_type_name().empty()) continue;  // a switch
    const auto choices = values_of(command, *option);
    for (const auto& flag : flags) {
      const auto pattern = name + "\\ " + flag;
      if (choices.empty()) {
        any += (any.empty() ? "" : "|") + pattern;
      } else {
        values += "    " + pattern + ") offered='" + choices + "' ;;\n";
      }
    }
  }
  if (!any.empty()) values += "    " + any + ") ;;\n";
  const auto branch = [&](const std::string& after, const std::string& words) {
    return "    " + name + "\\ " + after + ") case $current in -*) offered='" + options + "' ;; *) offered='" + words +
           "' ;; esac ;;\n";
  };
  // If there are several arguments, only the first one has a known position: right after the command.
  return values + (positionals > 1 ? branch(name, arguments) + branch("*", "") : branch("*", arguments));
}

}  // namespace

std::vector<std::string> choices_of(const Command& command, const CLI::Option& option) {
  const auto key = option.get_positional() ? option.get_name() : option.get_lnames().front();
  const auto known = command.choices.find(key);
  if (known != command.choices.end()) return known->second;
  if (option.get_positional()) return {};
  // A type name like "2|3" lists the values. Capitals are placeholders.
  const auto& list = option.get_type_name();
  if (list.find('|') == std::string::npos || list.find_first_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ") != std::string::npos)
    return {};
  return CLI::detail::split(list, '|');
}

std::string completion(const std::vector<Command>& commands) {
  std::string names, cases;
  for (const auto& command : commands) {
    add_word(names, command.app->get_name());
    cases += branches(command);
  }
  return "# Completion of the command tessera for bash.\n"
         "_tessera() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} offered=\n"
         "  COMPREPLY=()\n"
         "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
         "    offered='" +
         names +
         " help --help --version'\n"
         "  else case ${COMP_WORDS[1]}\\ ${COMP_WORDS[COMP_CWORD-1]} in\n"
         "    help\\ *) offered='" +
         names + "' ;;\n" + cases +
         "  esac; fi\n"
         "  COMPREPLY=($(compgen -W \"$offered\" -- \"$current\"))\n"
         "}\n"
         "complete -o default -F _tessera tessera\n";
}

}  // namespace tessera::apps
