#include "src/apps/help.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>

namespace tessera {
namespace {

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override {
    if (option->get_type_size() == 0 || option->get_type_name().empty()) return "";
    const bool many = option->get_expected_max() == CLI::detail::expected_max_vector_size;
    return " " + option->get_type_name() + (many ? " ..." : "");
  }
};

// The least number of steps from one to the other (optimal string alignment).
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
    answer = "perhaps '" + *meant + "' is meant";
  } else {
    for (const auto& command : commands) answer += (answer.empty() ? "there are " : ", ") + command;
  }
  return error(Errc::usage, "'" + word + "' is no command; " + answer + "; see 'tessera --help'");
}

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter() {
  auto formatter = std::make_shared<HelpFormatter>();
  formatter->label("SUBCOMMAND", "COMMAND");
  return formatter;
}

std::optional<std::string> nearest(std::string_view word, const std::vector<std::string>& names) {
  constexpr std::size_t longest = 40;  // of what can be a name at all: paths are given, too
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

}  // namespace tessera
