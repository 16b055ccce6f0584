// The HTTP server before a fake service, for the tests in Python: FOLDER NAME=VALUE... Prints one line of JSON with
// ports and token; then obeys lines on standard input, answering each with "ok": "state ID STATE", "tell COUNT",
// "hold 1", "hold 0" and "held COUNT" (FakeBackend::hold), "asked COUNT", "given_up COUNT", "reload", "drain"; ends
// with its input.
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "src/base/files/open_files.h"
#include "src/service/http/server.h"
#include "tests/http/fake_backend.h"

int main(int argc, char** argv) {
  using namespace tessera::service;
  spdlog::set_default_logger(spdlog::stderr_logger_mt("http"));
  const std::filesystem::path folder = argv[1];
  std::map<std::string, std::string> given;
  for (int at = 2; at < argc; ++at) {
    const std::string word = argv[at];
    given[word.substr(0, word.find('='))] = word.substr(word.find('=') + 1);
  }
  const auto number = [&](const char* name, int usual) {
    return given.contains(name) ? std::stoi(given[name]) : usual;
  };
  tessera::raise_open_files_limit();
  if (given.contains("open_files")) {
    const rlimit limit{static_cast<rlim_t>(number("open_files", 0)), static_cast<rlim_t>(number("open_files", 0))};
    if (::setrlimit(RLIMIT_NOFILE, &limit) != 0) return 1;
  }
  FakeBackend backend(folder, static_cast<std::uint64_t>(number("file_bytes", 1000)));
  backend.profile_bytes = static_cast<std::size_t>(number("profile_bytes", 0));
  http::ServerOptions options;
  options.listeners = {{.address = given.contains("address") ? given["address"] : "127.0.0.1"}, {.operations = true}};
  options.tokens = folder / "tokens";
  options.sessions = folder / "sessions";
  options.certificate = given["certificate"];
  options.key = given["key"];
  options.public_url = given["public_url"];
  options.insecure = number("insecure", 0) == 1;
  options.threads = static_cast<std::uint32_t>(number("threads", 2));
  options.workers = static_cast<std::uint32_t>(number("workers", 4));
  options.connections = static_cast<std::uint32_t>(number("connections", 2048));
  options.header_time = std::chrono::milliseconds(number("header_ms", 10'000));
  options.idle_time = std::chrono::milliseconds(number("idle_ms", 60'000));
  options.write_time = std::chrono::milliseconds(number("write_ms", 30'000));
  options.comment_time = std::chrono::milliseconds(number("comment_ms", 15'000));
  auto started = http::Server::start(options, backend.backend());
  if (!started) {
    std::cout << nlohmann::json{{"error", started.error().where}, {"status", static_cast<int>(started.error().code)}}
              << std::endl;
    return static_cast<int>(started.error().code);
  }
  http::Server& server = *started.value();
  std::cout << nlohmann::json{{"ports", server.ports()}, {"token", server.token()}} << std::endl;
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    std::string what, id, state;
    words >> what >> id >> state;
    bool done = true;
    if (what == "state") backend.set_state(id, state);
    if (what == "tell") backend.tell(std::stoi(id));
    if (what == "hold") backend.hold(id == "1");
    if (what == "held") backend.wait_for_held(std::stoi(id));
    if (what == "asked") backend.wait_for_asked(std::stoi(id));
    if (what == "given_up") backend.wait_for_given_up(std::stoi(id));
    if (what == "reload") done = server.reload().has_value();
    if (what == "drain") done = server.drain(std::chrono::seconds(10));
    std::cout << (done ? "ok" : "failed") << std::endl;
  }
  backend.hold(false);  // the server waits for whom it holds
}
