#include "src/files/lock_owner.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <random>
#include <string_view>
#include <system_error>
#include <vector>

#include "src/files/checksum.h"

namespace tessera {
namespace {

constexpr char separator = ',';

// Empty when the system does not tell.
std::string first_word_of(const char* path) {
  std::ifstream file(path);
  std::string word;
  file >> word;
  return word;
}

// 0 when there is no such process, or the system does not tell.
std::uint64_t start_of(std::int64_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(file, text, '\0');
  // The second field is the program's name in brackets, which may hold anything; the start is the 22nd.
  const auto name_end = text.rfind(')');
  if (name_end == std::string::npos) return 0;
  std::size_t at = name_end + 1;
  for (int field = 2; field < 22; ++field) {
    at = text.find(' ', at);
    if (at == std::string::npos) return 0;
    ++at;
  }
  std::uint64_t start = 0;
  std::from_chars(text.data() + at, text.data() + text.size(), start);
  return start;
}

std::string safe(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == separator || c == '/' || c == '\0'; }, '_');
  return text;
}

std::string this_boot() { return safe(first_word_of("/proc/sys/kernel/random/boot_id")); }

std::string this_pid_namespace() {
  std::error_code ignored;  // then it is empty, and processes are not looked up
  return safe(std::filesystem::read_symlink("/proc/self/ns/pid", ignored).string());
}

template <class T>
bool read_number(const std::string& text, T& value) {
  const auto end = text.data() + text.size();
  return !text.empty() && std::from_chars(text.data(), end, value).ptr == end;
}

}  // namespace

LockOwner LockOwner::this_process() {
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  std::random_device random;
  const auto token = checksum_text(std::uint64_t{random()} << 32 | random());
  return {safe(host.data()), this_boot(), this_pid_namespace(), ::getpid(), start_of(::getpid()), token};
}

std::string LockOwner::name() const {
  std::string name = host;
  for (const auto& part : {boot, pid_namespace, std::to_string(process), std::to_string(started), token})
    name += separator + part;
  return name;
}

std::optional<LockOwner> LockOwner::from_name(const std::string& name) {
  std::vector<std::string> parts(1);
  for (const char c : name) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  LockOwner owner;
  if (parts.size() != 6 || !read_number(parts[3], owner.process) || !read_number(parts[4], owner.started))
    return std::nullopt;
  owner.host = parts[0];
  owner.boot = parts[1];
  owner.pid_namespace = parts[2];
  owner.token = parts[5];
  return owner;
}

bool LockOwner::under_this_kernel() const { return !boot.empty() && boot == this_boot(); }

bool LockOwner::may_be_alive() const {
  if (pid_namespace.empty() || pid_namespace != this_pid_namespace()) return true;
  return start_of(process) == started;
}

}  // namespace tessera
