// What a browser keeps in place of a token: a random number that means nothing elsewhere, ends, and can be ended.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "src/base/result.h"

namespace tessera::http {

// Safe from any thread.
class Sessions {
 public:
  using Clock = std::chrono::system_clock;  // a session outlives the process, and its restart
  static constexpr std::chrono::seconds lifetime = std::chrono::hours(7 * 24);
  static constexpr std::size_t of_a_token_max = 32;  // one more ends the oldest

  // Kept in `file`, for its owner alone, as checksums: who reads it has neither a session nor a token. Empty: nowhere.
  explicit Sessions(std::filesystem::path file = {}) : file_(std::move(file)) {}
  // What the process before has left there. Without a file there are none. Error io; usage for a line that is none.
  Status load(Clock::time_point now);

  // A new one of the token with this mark (Tokens::mark_of), to be kept by the browser. Error io.
  Result<std::string> begin(std::string_view mark, Clock::time_point now);
  // The mark of its token; nothing once it has ended.
  std::optional<std::string> find(std::string_view session, Clock::time_point now) const;
  // Nothing happens when there is none. Error io: it has ended all the same, until a restart.
  Status end(std::string_view session);
  // Those of tokens that are none any more end. Error as of end().
  Status end_unless(const std::function<bool(const std::string& mark)>& known);

 private:
  struct Kept {
    std::string mark;
    std::int64_t ends_s = 0;  // since 1970
  };
  // REQUIRES: `mutex_` is held.
  Status write() const;

  const std::filesystem::path file_;
  mutable std::mutex mutex_;
  std::map<std::string, Kept, std::less<>> kept_;  // by the checksum of what the browser keeps
};

}  // namespace tessera::http
