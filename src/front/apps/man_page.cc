#include "src/front/apps/man_page.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <sstream>

#include "src/job/version.h"

namespace tessera::apps {
namespace {

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

// Returns lines that roff prints as they are.
std::string verbatim(const std::string& text) {
  std::istringstream lines(text);
  std::string page = ".nf\n";
  for (std::string line; std::getline(lines, line);) page += roff(line) + "\n";
  return page + ".fi\n";
}

std::string heading(const std::string& name, const std::string& what) {
  std::string capitals = name;
  for (auto& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return ".TH " + capitals + " 1 \"\" \"Tessera " + roff(version()) + "\" \"Tessera\"\n.SH NAME\n" + roff(name) +
         " \\- " + roff(what) + "\n";
}

std::string without_full_stop(std::string text) {
  if (text.ends_with('.')) text.pop_back();
  return text;
}

// Returns the names of an option: "-o, --output FOLDER".
std::string names_of(const CLI::Option& option) {
  std::string names;
  for (const auto& name : option.get_snames()) names += (names.empty() ? "" : ", ") + bold("-" + name);
  for (const auto& name : option.get_lnames()) names += (names.empty() ? "" : ", ") + bold("--" + name);
  if (names.empty()) names = italic(option.get_name());
  if (!option.get_type_name().empty()) names += " " + italic(option.get_type_name());
  return names;
}

// Returns the list of the arguments, or of the options that the help shows.
std::string list(const CLI::App& app, bool arguments) {
  std::string page;
  for (const auto* option : app.get_options()) {
    if (option->get_positional() != arguments || option->get_group().empty()) continue;
    page += ".TP\n" + names_of(*option) + "\n" + roff(option->get_description()) + "\n";
  }
  return page;
}

constexpr const char* exit_statuses =
    ".SH EXIT STATUS\n"
    ".TP\n0\nsuccess; with verify: the result is proved\n"
    ".TP\n2\nthe command line, a TESSERA_* variable or the configuration file is wrong, or the result folder holds "
    "something that may not be replaced\n"
    ".TP\n3\nan input file is not what it claims to be, or its points span no volume (in 2D: no area)\n"
    ".TP\n4\nthe system refused: a file is missing, the disk is full, a folder cannot be written\n"
    ".TP\n5\na result or run folder is damaged, or was written by a newer version\n"
    ".TP\n6\nverify found that the result is not the Delaunay triangulation\n"
    ".TP\n7\nthe job cannot be done within its memory\n"
    ".TP\n8\ninterrupted; the same command with \\-\\-resume continues\n"
    ".TP\n9\nanything else, told apart by its text\n";

}  // namespace

std::string roff(const std::string& text) {
  std::string escaped;
  bool begins_line = true;
  for (const char c : text) {
    if (begins_line && (c == '.' || c == '\'')) escaped += "\\&";
    begins_line = c == '\n';
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else if (c == '\'') {
      escaped += "\\(aq";  // roff would print a typographic quote
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string man_page_of_program(const CLI::App& root, const std::vector<Command>& commands) {
  std::string page = heading("tessera", without_full_stop(root.get_description()));
  page += ".SH SYNOPSIS\n" + bold("tessera") + " " + italic("COMMAND") + " [" + italic("OPTIONS") + "] ...\n";
  page +=
      ".SH DESCRIPTION\nTessera cuts space into tiles, triangulates every tile by itself, and lets the tiles exchange "
      "points until the result is exactly the Delaunay triangulation of all points. Each command has a page of its "
      "own.\n.SH COMMANDS\n";
  std::string see;
  for (const auto& command : commands) {
    const auto name = "tessera-" + command.app->get_name();
    page += ".TP\n" + bold(command.app->get_name()) + "\n" + roff(command.app->get_description()) + ".\n";
    see += (see.empty() ? "" : ",\n") + bold(name) + "(1)";
  }
  page += ".SH OPTIONS\n" + list(root, false);
  page +=
      ".SH CONFIGURATION\nEach option of a command, except those that belong to one run, can also be given by a "
      "variable, or in a TOML file in the table of its command. Flags override variables, and variables override the "
      "file. ";
  page += bold("--config") + " or " + bold("TESSERA_CONFIG") + " names the file.\n";
  return page + exit_statuses + ".SH SEE ALSO\n" + see + "\n";
}

std::string man_page(const Command& command) {
  const CLI::App& app = *command.app;
  std::string page = heading("tessera-" + app.get_name(), app.get_description());
  page += ".SH SYNOPSIS\n" + bold("tessera " + app.get_name()) + " [" + italic("OPTIONS") + "]";
  for (const auto* option : app.get_options([](const CLI::Option* o) { return o->get_positional(); })) {
    const bool many = option->get_expected_max() == CLI::detail::expected_max_vector_size;
    page += " [" + italic(option->get_name()) + (many ? " ..." : "") + "]";
  }
  page += "\n.SH DESCRIPTION\n" + roff(app.get_description()) + ".\n";
  if (const auto arguments = list(app, true); !arguments.empty()) page += ".SH ARGUMENTS\n" + arguments;
  page += ".SH OPTIONS\nA switch \\-\\-x has an opposite, \\-\\-no\\-x. The one that changes the default is listed.\n" +
          list(app, false);
  // The footer has blocks: "Examples:" and, for export, "Formats:", each with the lines below it.
  std::istringstream footer(app.get_footer());
  std::string block;
  const auto flush = [&] {
    if (!block.empty()) page += verbatim(block);
    block.clear();
  };
  for (std::string line; std::getline(footer, line);) {
    if (line.ends_with(':') && !line.starts_with(' ')) {
      flush();
      line.pop_back();
      for (auto& c : line) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      page += ".SH " + line + "\n";
    } else if (!line.empty()) {
      block += line + "\n";
    }
  }
  flush();
  page += ".SH ENVIRONMENT\n";
  for (const auto& name : command.settings->environment_names()) page += bold(name) + "\n.br\n";
  return page + exit_statuses + ".SH SEE ALSO\n" + bold("tessera") + "(1)\n";
}

}  // namespace tessera::apps
