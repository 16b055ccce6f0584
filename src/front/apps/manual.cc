// Writes the man pages, the shell completion and a description of the command into a folder: man1/tessera*.1,
// completions/tessera and commands.json. The build runs this program.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/base/result.h"
#include "src/front/apps/commands.h"
#include "src/front/apps/completion.h"
#include "src/front/apps/description.h"
#include "src/front/apps/man_page.h"

namespace tessera::apps {
namespace {

Status write_manual(const std::filesystem::path& folder) {
  CLI::App root;
  const auto commands = add_commands(root);
  BOOST_OUTCOME_TRYV(make_directories(folder / "man1"));
  BOOST_OUTCOME_TRYV(make_directories(folder / "completions"));
  BOOST_OUTCOME_TRYV(write_whole(folder / "man1" / "tessera.1", man_page_of_program(root, commands)));
  for (const auto& command : commands) {
    const auto name = "tessera-" + command.app->get_name() + ".1";
    BOOST_OUTCOME_TRYV(write_whole(folder / "man1" / name, man_page(command)));
  }
  BOOST_OUTCOME_TRYV(write_whole(folder / "commands.json", description_of(commands)));
  return write_whole(folder / "completions" / "tessera", completion(commands));
}

}  // namespace
}  // namespace tessera::apps

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: tessera_manual FOLDER\n", stderr);
    return 2;
  }
  const auto written = tessera::apps::write_manual(argv[1]);
  if (written) return 0;
  std::fprintf(stderr, "tessera_manual: %s\n", tessera::in_plain_words(written.error().where).c_str());
  return static_cast<int>(written.error().code);
}
