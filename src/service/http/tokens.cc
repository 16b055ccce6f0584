#include "src/service/http/tokens.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <set>
#include <span>
#include <sstream>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/files/private_file.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/utf8.h"
#include "src/service/http/secrets.h"

namespace tessera::service::http {
namespace {

constexpr std::size_t token_bytes = 32, token_length_min = 32;
constexpr std::array<std::pair<Role, std::string_view>, 3> roles{
    {{Role::read, "read"}, {Role::submit, "submit"}, {Role::admin, "admin"}}};

// Makes a new file, which only its owner can ever read.
Status make_file(const std::filesystem::path& file) {
  BOOST_OUTCOME_TRY(handle, open_handle(file, O_WRONLY | O_CREAT | O_EXCL, file, S_IRUSR | S_IWUSR));
  const std::string text =
      "# NAME ROLE TOKEN; roles: read, submit, admin\nowner admin " + random_hex(token_bytes) + "\n";
  return write_on(handle.get(), std::as_bytes(std::span(text)), file);
}

}  // namespace

std::optional<Role> role_of(std::string_view word) {
  for (const auto& [role, name] : roles)
    if (name == word) return role;
  return std::nullopt;
}

std::string_view word_of(Role role) {
  for (const auto& [value, name] : roles)
    if (value == role) return name;
  return "none";
}

Result<Tokens> Tokens::open(const std::filesystem::path& file, Empty empty) {
  BOOST_OUTCOME_TRY(there, is_there(file));
  if (!there) {
    BOOST_OUTCOME_TRYV(make_file(file));
  }
  BOOST_OUTCOME_TRY(mended, keep_private(file, Mend::allowed));
  if (mended) spdlog::warn("{}: its group could read it; its rights are 0600 again", file.string());
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  std::istringstream text{std::string(as_text(bytes))};
  Tokens tokens;
  std::set<std::string> names;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    std::istringstream words(line);
    std::string name, role, token, more;
    if (!(words >> name) || name[0] == '#') continue;
    words >> role >> token;
    const std::optional<Role> known = role_of(role);
    const auto refuse = [&](const std::string& why) {
      return error(Errc::usage, file.string() + ", line " + std::to_string(number) + ": " + why);
    };
    if (!known || token.size() < token_length_min || words >> more || !is_utf8(name))
      return refuse("must be a name, a role (read, submit, admin) and a token of at least 32 characters");
    if (!names.insert(name).second)
      return refuse("there is a token of the name '" + name + "' already, and what it makes would be this one's, too");
    tokens.held_->entries.push_back({{name, *known}, token, mark_of(token)});
  }
  if (empty == Empty::refused && tokens.held_->entries.empty())
    return error(Errc::usage, file.string() + ": holds no token");
  return tokens;
}

void Tokens::replace(Tokens others) {
  const std::unique_lock lock(held_->mutex);
  held_->entries.swap(others.held_->entries);
}

std::optional<Caller> Tokens::find(std::string_view token) const {
  const std::shared_lock lock(held_->mutex);
  // All tokens are compared, so that the time does not tell which one was close.
  std::optional<Caller> found;
  for (const Entry& entry : held_->entries)
    if (equal_in_constant_time(entry.token, token)) found = entry.caller;
  return found;
}

std::string Tokens::mark_of(std::string_view token) { return checksum_of_secret(token); }

std::optional<Caller> Tokens::find_mark(std::string_view mark) const {
  const std::shared_lock lock(held_->mutex);
  const auto found = std::find_if(held_->entries.begin(), held_->entries.end(),
                                  [&](const Entry& entry) { return entry.mark == mark; });
  return found == held_->entries.end() ? std::nullopt : std::optional(found->caller);
}

std::string Tokens::first(Role role) const {
  const std::shared_lock lock(held_->mutex);
  for (const Entry& entry : held_->entries)
    if (entry.caller.role == role) return entry.token;
  return {};
}

}  // namespace tessera::service::http
