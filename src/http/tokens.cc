#include "src/http/tokens.h"

#include <fcntl.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <mutex>
#include <span>
#include <sstream>
#include <utility>

#include "src/base/check.h"
#include "src/files/descriptor.h"
#include "src/files/disk_file.h"
#include "src/files/whole_file.h"

namespace tessera::http {
namespace {

constexpr std::size_t token_bytes = 32, token_length_min = 32;
constexpr std::array<std::pair<Role, std::string_view>, 3> roles{
    {{Role::read, "read"}, {Role::submit, "submit"}, {Role::admin, "admin"}}};

std::string hex(std::span<const unsigned char> bytes) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : bytes) {
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  return text;
}

std::string derived(std::string_view token) {
  constexpr std::string_view purpose = "tessera browser session";
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned length = 0;
  const unsigned char* made =
      HMAC(EVP_sha256(), token.data(), static_cast<int>(token.size()),
           reinterpret_cast<const unsigned char*>(purpose.data()), purpose.size(), digest.data(), &length);
  check(made != nullptr, "HMAC failed");
  return hex(std::span(digest).first(length));
}

// Not there before, and readable by nobody else from its first moment.
Status make_file(const std::filesystem::path& file) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (fd < 0) return io_error(file, "cannot make it", errno);
  FileHandle handle(fd);
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

std::string random_hex(std::size_t bytes) {
  std::vector<unsigned char> random(bytes);
  check(RAND_bytes(random.data(), static_cast<int>(bytes)) == 1, "no random numbers");
  return hex(random);
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

Result<Tokens> Tokens::open(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) {
    if (errno != ENOENT) return io_error(file, "cannot read it", errno);
    BOOST_OUTCOME_TRYV(make_file(file));
  } else if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    return error(Errc::usage, file.string() + ": others can read it; its rights must be 0600");
  }
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  std::istringstream text{std::string(as_text(bytes))};
  Tokens tokens;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    std::istringstream words(line);
    std::string name, role, token, more;
    if (!(words >> name) || name[0] == '#') continue;
    words >> role >> token;
    const std::optional<Role> known = role_of(role);
    if (!known || token.size() < token_length_min || words >> more)
      return error(Errc::usage,
                   file.string() + ", line " + std::to_string(number) +
                       ": must be a name, a role (read, submit, admin) and a token of at least 32 characters");
    tokens.held_->entries.push_back({{name, *known}, token, derived(token)});
  }
  if (tokens.held_->entries.empty()) return error(Errc::usage, file.string() + ": holds no token");
  return tokens;
}

void Tokens::replace(Tokens others) {
  const std::unique_lock lock(held_->mutex);
  held_->entries.swap(others.held_->entries);
}

std::optional<Caller> Tokens::find(std::string_view token) const {
  const std::shared_lock lock(held_->mutex);
  // All are compared, so that the time does not tell which one was close.
  std::optional<Caller> found;
  for (const Entry& entry : held_->entries)
    if (equal_in_constant_time(entry.token, token)) found = entry.caller;
  return found;
}

std::string Tokens::session_of(std::string_view token) const { return find(token) ? derived(token) : std::string(); }

std::optional<Caller> Tokens::find_session(std::string_view session) const {
  const std::shared_lock lock(held_->mutex);
  std::optional<Caller> found;
  for (const Entry& entry : held_->entries)
    if (equal_in_constant_time(entry.session, session)) found = entry.caller;
  return found;
}

std::string Tokens::first(Role role) const {
  const std::shared_lock lock(held_->mutex);
  for (const Entry& entry : held_->entries)
    if (entry.caller.role == role) return entry.token;
  return {};
}

}  // namespace tessera::http
