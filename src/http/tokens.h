// Who may do what: a file of tokens, one a line, "NAME ROLE TOKEN", that its owner alone can read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/result.h"
#include "src/service/service.h"

namespace tessera::http {

// `bytes` random bytes of the system, in hexadecimal.
std::string random_hex(std::size_t bytes);
// In a time that depends on the lengths alone.
bool equal_in_constant_time(std::string_view a, std::string_view b);

class Tokens {
 public:
  // Made with one token of role admin when there is none. Errors: usage for a line that is no token, and for a file
  // that others can read; io.
  static Result<Tokens> open(const std::filesystem::path& file);

  // Those of `others` instead, from now on; called by any thread.
  void replace(Tokens others);

  std::optional<Caller> find(std::string_view token) const;
  // What a browser keeps in place of the token: derived from it, the same after a restart, and of no use once the token
  // is gone. Empty for what is no token.
  std::string session_of(std::string_view token) const;
  std::optional<Caller> find_session(std::string_view session) const;
  // The first token of that role, for the address that is printed.
  std::string first(Role role) const;

 private:
  struct Entry {
    Caller caller;
    std::string token, session;
  };
  struct Held {
    std::shared_mutex mutex;
    std::vector<Entry> entries;
  };
  std::unique_ptr<Held> held_ = std::make_unique<Held>();
};

std::optional<Role> role_of(std::string_view word);
std::string_view word_of(Role role);

}  // namespace tessera::http
