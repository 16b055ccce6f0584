#include "src/front/apps/machine_options.h"

#include "src/job/arguments.h"
#include "src/job/job_options.h"
#include "src/job/machine.h"

namespace tessera::apps {

void add_memory_option(Command& command, const std::string& of) {
  add_value(command, "memory", "SIZE",
            "memory for " + of + ", for example 800M or 4G; default: 70 % of what is available");
}

void add_threads_option(Command& command) {
  add_value(command, "threads", "N", "worker threads; default: all processors this process may use");
}

Result<std::uint64_t> memory_option(const Settings& settings) {
  BOOST_OUTCOME_TRY(memory,
                    settings.get("memory", or_auto([](const std::string& text) { return parse_memory(text); }, 0)));
  return memory.value_or(0) > 0 ? *memory : default_memory();
}

Result<std::uint32_t> threads_option(const Settings& settings) {
  BOOST_OUTCOME_TRY(
      threads,
      settings.get("threads", or_auto([](const std::string& text) { return parse_integer(text, 1, threads_max); }, 0)));
  return threads.value_or(0) > 0 ? static_cast<std::uint32_t>(*threads) : usable_processors();
}

}  // namespace tessera::apps
