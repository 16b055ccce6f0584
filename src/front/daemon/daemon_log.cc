#include "src/front/daemon/daemon_log.h"

#include <fmt/chrono.h>
#include <spdlog/formatter.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "src/base/json/json_text.h"
#include "src/base/printable.h"

namespace tessera::daemon {
namespace {

// Writes each message as one line. Messages contain text from callers, which may have line ends and control sequences.
class OneLine final : public spdlog::formatter {
 public:
  OneLine(bool json, bool insecure) : json_(json), insecure_(insecure) {}

  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    const auto when = fmt::format("{:%FT%T}Z", fmt::gmtime(message.time));
    const auto name = spdlog::level::to_string_view(message.level);
    const std::string level(name.data(), name.size());
    const std::string text = printable({message.payload.data(), message.payload.size()});
    std::string line;
    if (json_) {
      nlohmann::ordered_json object{{"time", when}, {"level", level}, {"message", text}};
      if (insecure_) object["insecure"] = true;
      line = json_text(object);
    } else {
      line = when + " " + level + (insecure_ ? " INSECURE " : " ") + text;
    }
    line += '\n';
    out.append(line.data(), line.data() + line.size());
  }
  std::unique_ptr<spdlog::formatter> clone() const override { return std::make_unique<OneLine>(json_, insecure_); }

 private:
  bool json_, insecure_;
};

}  // namespace

void start_daemon_log(bool json, bool insecure) {
  auto logger = spdlog::stderr_logger_mt(daemon_log_name);
  logger->set_formatter(std::make_unique<OneLine>(json, insecure));
  logger->set_level(spdlog::level::info);
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace tessera::daemon
