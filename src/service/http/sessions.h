// Browser sessions: a browser keeps a random number in place of a token. The number is of no use elsewhere, expires,
// and can be revoked.
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

namespace tessera::service::http {

// Thread-safe.
class Sessions {
 public:
  using Clock = std::chrono::system_clock;  // a session outlives the process and its restart
  static constexpr std::chrono::seconds lifetime = std::chrono::hours(7 * 24);
  static constexpr std::size_t of_a_token_max = 32;  // one more ends the oldest

  // Keeps sessions in `file`, readable only by its owner, as checksums: so a reader of the file gets neither a session
  // nor a token. Empty: nowhere.
  explicit Sessions(std::filesystem::path file = {}) : file_(std::move(file)) {}
  // Loads the sessions of the process before. A missing file means no sessions. Errors: io; usage for an invalid line.
  Status load(Clock::time_point now);

  // Begins a session for the token with this mark (Tokens::mark_of). Returns the number for the browser. Error io.
  Result<std::string> begin(std::string_view mark, Clock::time_point now);
  // The mark of the session's token; nothing when the session has ended.
  std::optional<std::string> find(std::string_view session, Clock::time_point now) const;
  // Ends a session, if it exists. Error io: the session has ended, but comes back at a restart.
  Status end(std::string_view session);
  // Ends the sessions of tokens whose mark `known` refuses. Error as in end().
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
  std::map<std::string, Kept, std::less<>> kept_;  // by the checksum of the browser's number
};

}  // namespace tessera::service::http
