#include "src/front/apps/server_options.h"

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/job/arguments.h"

namespace tessera::apps {
namespace {

Result<std::string> read_token(const std::string& path) {
  BOOST_OUTCOME_TRY(bytes, read_whole(path));
  std::string token(as_text(bytes));
  token.erase(0, token.find_first_not_of(" \t\r\n"));
  token.erase(token.find_last_not_of(" \t\r\n") + 1);
  if (token.empty()) return error(Errc::usage, path + ": holds no token");
  return token;
}

}  // namespace

void add_server_options(Command& command) {
  add_value(command, "server", "URL",
            "the address of the daemon, for example http://127.0.0.1:7070; or the address with a token that the daemon "
            "prints when it starts");
  add_value(command, "token-file", "FILE",
            "a file with the token in its first line; default: the token in TESSERA_TOKEN");
  // The token has no flag, because other users of the machine can see command lines.
  command.settings->declare("token");
  add_value(command, "ca", "FILE", "https: trust the certificates in this PEM file, instead of those of the system");
  add_value(command, "patience", "SECONDS",
            "how many seconds to wait for a daemon that does not answer any more; default: 600");
}

void add_remote_options(Command& command) {
  add_switch(command, "detach", "with --server: do not wait for the job", 0, true);
  add_server_options(command);
}

Status refuse_detach(const Settings& settings) {
  BOOST_OUTCOME_TRY(detach, settings.on("detach"));
  if (detach) return error(Errc::usage, "--detach is for a job of a daemon: give --server, too");
  return success();
}

bool names_server(const Settings& settings) { return !settings.text("server").value_or("").empty(); }

Result<client::Server> open_server(Settings& settings) {
  client::ServerOptions options;
  if (!names_server(settings))
    return error(Errc::usage, "no daemon is named; give --server URL, or set TESSERA_SERVER");
  BOOST_OUTCOME_TRY(address,
                    settings.get("server", [](const std::string& text) { return client::parse_address(text); }));
  options.address = *std::move(address);
  BOOST_OUTCOME_TRYV(settings.exclusive("token-file", "token"));
  if (const auto file = settings.text("token-file"); file && !file->empty()) {
    BOOST_OUTCOME_TRY(token, read_token(*file));
    options.token = std::move(token);
  } else {
    options.token = settings.text("token").value_or("");
  }
  options.authorities = settings.text("ca").value_or("");
  BOOST_OUTCOME_TRY(
      patience, settings.get("patience", [](const std::string& text) { return parse_integer(text, 0, 1'000'000); }));
  options.patience = std::chrono::seconds(patience.value_or(600));
  options.token_advice = "give it with --token-file, or in TESSERA_TOKEN";
  options.authorities_advice = "give the certificate of its authority with --ca FILE";
  return client::Server::make(std::move(options));
}

void print_json_line(const nlohmann::ordered_json& object) { std::printf("%s\n", json_text(object).c_str()); }

}  // namespace tessera::apps
