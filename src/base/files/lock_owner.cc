#include "src/base/files/lock_owner.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <vector>

#include "src/base/files/process.h"
#include "src/base/random_token.h"

namespace tessera {
namespace {

constexpr char separator = ',';

std::string safe(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == separator || c == '/' || c == '\0'; }, '_');
  return text;
}

std::string this_boot() { return safe(boot_id()); }

std::string this_pid_namespace() {
  std::error_code ignored;  // then the name is empty, and processes are not looked up
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
  return {safe(host.data()), this_boot(), this_pid_namespace(), ::getpid(), process_start(::getpid()), random_token()};
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
  return process_start(process) == started;
}

}  // namespace tessera
