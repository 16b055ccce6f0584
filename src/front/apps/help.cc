#include "src/front/apps/help.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>

namespace tessera::apps {
namespace {

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override {
    if (option->get_type_size() == 0 || option->get_type_name().empty()) return "";
    const bool many = option->get_expected_max() == CLI::detail::expected_max_vector_size;
    return " " + option->get_type_name() + (many ? " ..." : "");
  }
};

// Returns the edit distance of two words (optimal string alignment).
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

Error no_command(const std::string& word, const std::vector<std::string>& commands) {
  std::string answer;
  if (const auto meant = nearest(word, commands)) {
    answer = "perhaps you mean '" + *meant + "'";
  } else {
    for (const auto& command : commands) answer += (answer.empty() ? "the commands are " : ", ") + command;
  }
  return error(Errc::usage, "'" + word + "' is not a command; " + answer + "; see 'tessera --help'");
}

// Returns the option of `app` that the user probably meant. A beginning counts, too: "--res" for "--resolution".
std::optional<std::string> nearest_option(std::string_view word, const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  if (const auto name = nearest(word, names)) return name;
  std::sort(names.begin(), names.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  const auto begins = [&](const std::string& name) { return name.size() > 3 && word.starts_with(name); };
  const auto begun = std::find_if(names.begin(), names.end(), begins);
  return begun == names.end() ? std::nullopt : std::optional(*begun);
}

std::string not_expected(const CLI::App& app, const std::string& name) {
  const std::vector<std::string> rest = app.remaining(true);
  const auto option = std::find_if(rest.begin(), rest.end(), [](const auto& word) { return word.starts_with('-'); });
  if (option == rest.end()) {
    return "'" + (rest.empty() ? std::string() : rest.front()) + "' is one argument too many for '" + name + "'";
  }
  const std::string word = option->substr(0, option->find('='));
  const auto meant = nearest_option(word, app);
  return "'" + word + "' is not an option of '" + name + "'" + (meant ? "; perhaps you mean '" + *meant + "'" : "");
}

// Returns a sentence about an option with a wrong number of values. The parser's message begins with the option.
std::string wrong_count(const CLI::App& app, const std::string& message) {
  const std::string option = message.substr(0, message.find(':'));
  const CLI::Option* known = app.get_option_no_throw(option);
  if (known == nullptr) return message;
  const std::string type = known->get_type_name();
  if (message.find(": At Most ") == std::string::npos) return option + " needs a value: " + type;
  const bool list = type == "LIST" || type.find(",...") != std::string::npos;
  return option + " is given more than once" + (list ? ": give all values at once, with commas between them" : "");
}

}  // namespace

std::string wrong_arguments(const CLI::App& app, const std::string& name, const CLI::ParseError& wrong) {
  if (dynamic_cast<const CLI::ExtrasError*>(&wrong) != nullptr) return not_expected(app, name);
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&wrong) != nullptr) return wrong_count(app, wrong.what());
  return wrong.what();
}

std::shared_ptr<CLI::FormatterBase> help_formatter() {
  auto formatter = std::make_shared<HelpFormatter>();
  formatter->label("SUBCOMMAND", "COMMAND");
  return formatter;
}

std::optional<std::string> nearest(std::string_view word, const std::vector<std::string>& names) {
  constexpr std::size_t longest = 40;  // no name is longer; longer words are paths
  if (word.size() < 2 || word.size() > longest) return std::nullopt;
  const auto begun = std::find_if(names.begin(), names.end(), [&](const auto& name) { return name.starts_with(word); });
  if (begun != names.end()) return *begun;
  const auto closer = [&](const auto& a, const auto& b) { return distance(word, a) < distance(word, b); };
  const auto best = std::min_element(names.begin(), names.end(), closer);
  if (best == names.end() || 3 * distance(word, *best) > best->size()) return std::nullopt;
  return *best;
}

Result<std::vector<std::string>> resolve_command(std::vector<std::string> arguments,
                                                 const std::vector<std::string>& commands) {
  const auto known = [&](const std::string& word) {
    return std::find(commands.begin(), commands.end(), word) != commands.end();
  };
  if (arguments.empty()) return error(Errc::usage, "no command is given; see 'tessera --help'");
  if (arguments.front() == "help") {
    if (arguments.size() == 1) return std::vector<std::string>{"--help"};
    if (!arguments[1].starts_with('-')) {
      if (!known(arguments[1])) return no_command(arguments[1], commands);
      return std::vector<std::string>{arguments[1], "--help"};
    }
    arguments.front() = "--help";
  }
  if (!arguments.front().starts_with('-') && !known(arguments.front())) return no_command(arguments.front(), commands);
  return arguments;
}

}  // namespace tessera::apps
