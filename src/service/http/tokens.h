// Who may do what: a file of tokens, one a line, "NAME ROLE TOKEN", that its owner alone can read.
#pragma once

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

class Tokens {
 public:
  // Whether a file without a token is one: then nobody gets in.
  enum class Empty : bool { refused, allowed };

  // Made with one token of role admin when there is none. Of a file that is ours the rights of others are taken away,
  // where they are the group's alone: what mounts a volume anew may have given them. Errors: usage for a line that is
  // no token, for a second token of one name, which owns what its jobs make, and for a file that others can read; io.
  static Result<Tokens> open(const std::filesystem::path& file, Empty empty = Empty::refused);

  // Those of `others` instead, from now on; called by any thread.
  void replace(Tokens others);

  std::optional<Caller> find(std::string_view token) const;
  // Tells this token from all others, and is of no use in its place: what may be kept of it.
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

}  // namespace tessera::http
