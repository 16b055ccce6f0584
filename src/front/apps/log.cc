#include "src/front/apps/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "src/base/printable.h"

namespace tessera::apps {

void start_log() {
  auto logger = spdlog::stderr_color_mt("tessera");
  logger->set_pattern("%H:%M:%S.%e %^%l%$ %v");
  logger->set_level(spdlog::level::warn);
  spdlog::set_default_logger(std::move(logger));
}

void log_everything() { spdlog::set_level(spdlog::level::debug); }

void log_debug(const std::string& message) { spdlog::debug("{}", printable(message)); }

}  // namespace tessera::apps
