// Callers and their rights: a file of tokens that only its owner can read, one a line, "NAME ROLE TOKEN".
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/result.h"
#include "src/service/caller.h"

namespace tessera::service::http {

class Tokens {
 public:
  // Whether a file without tokens is allowed; then all requests are refused.
  enum class Empty : bool { refused, allowed };

  // Reads the file. If it is missing, makes it with one token of the role admin. If the file is ours and only its group
  // has rights, they are removed: a new mount of a volume may have added them. Errors: usage for an invalid line, for
  // two tokens of one name (a name owns what its jobs make), and for a file that others can read; io.
  static Result<Tokens> open(const std::filesystem::path& file, Empty empty = Empty::refused);

  // Replaces all tokens. Thread-safe.
  void replace(Tokens others);

  std::optional<Caller> find(std::string_view token) const;
  // Identifies a token, and cannot be used in its place. So the mark may be stored.
  static std::string mark_of(std::string_view token);
  std::optional<Caller> find_mark(std::string_view mark) const;
  // The first token of that role, for the address that is printed; empty when there is none.
  std::string first(Role role) const;

 private:
  struct Entry {
    Caller caller;
    std::string token, mark;
  };
  struct Held {
    std::shared_mutex mutex;
    std::vector<Entry> entries;
  };
  std::unique_ptr<Held> held_ = std::make_unique<Held>();
};

std::optional<Role> role_of(std::string_view word);
std::string_view word_of(Role role);

}  // namespace tessera::service::http
