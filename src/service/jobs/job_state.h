// The states of a job, as its record and the API name them.
#pragma once

#include <algorithm>
#include <string_view>

namespace tessera::service::job_state {

inline constexpr const char* accepted = "accepted";
inline constexpr const char* running = "running";
inline constexpr const char* successful = "successful";
inline constexpr const char* failed = "failed";
inline constexpr const char* dismissed = "dismissed";

inline bool is_one(std::string_view text) {
  const std::string_view all[] = {accepted, running, successful, failed, dismissed};
  return std::find(std::begin(all), std::end(all), text) != std::end(all);
}

}  // namespace tessera::service::job_state
