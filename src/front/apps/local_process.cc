#include "src/front/apps/local_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <unistd.h>

extern "C" {  // the header of glibc 2.36 does not say extern "C"
#include <sys/pidfd.h>
}

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <string_view>
#include <utility>

#include "src/base/files/process.h"

namespace tessera::apps {
namespace {

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> out;
  for (std::string& word : words) out.push_back(word.data());
  out.push_back(nullptr);
  return out;
}

std::vector<std::string> environment_without(const std::string& hidden) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable; ++variable) {
    if (!std::string_view(*variable).starts_with(hidden)) variables.emplace_back(*variable);
  }
  return variables;
}

}  // namespace

Result<StartedProcess> start_process(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                                     const std::filesystem::path& log, const std::string& hidden) {
  BOOST_OUTCOME_TRY(told, open_handle(log, O_WRONLY | O_CREAT | O_APPEND));
  BOOST_OUTCOME_TRY(nothing, open_handle("/dev/null", O_RDWR));
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return io_error(program, "cannot be started", errno);
  StartedProcess process;
  process.output = FileHandle(ends[0]);
  const FileHandle said(ends[1]);

  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawnattr_init(&attributes);
  const std::unique_ptr<posix_spawn_file_actions_t, int (*)(posix_spawn_file_actions_t*)> files_go(
      &files, ::posix_spawn_file_actions_destroy);
  const std::unique_ptr<posix_spawnattr_t, int (*)(posix_spawnattr_t*)> attributes_go(&attributes,
                                                                                      ::posix_spawnattr_destroy);
  sigset_t none, usual;
  ::sigemptyset(&none);
  ::sigemptyset(&usual);
  for (const int number : {SIGINT, SIGTERM, SIGPIPE, SIGXFSZ}) ::sigaddset(&usual, number);
  int failed = ::posix_spawn_file_actions_adddup2(&files, nothing.get(), STDIN_FILENO);
  if (failed == 0) failed = ::posix_spawn_file_actions_adddup2(&files, said.get(), STDOUT_FILENO);
  if (failed == 0) failed = ::posix_spawn_file_actions_adddup2(&files, told.get(), STDERR_FILENO);
  if (failed == 0) failed = ::posix_spawnattr_setsigmask(&attributes, &none);
  if (failed == 0) failed = ::posix_spawnattr_setsigdefault(&attributes, &usual);
  constexpr int flags = POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF;
  if (failed == 0) failed = ::posix_spawnattr_setflags(&attributes, flags);

  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<std::string> variables = environment_without(hidden);
  if (failed == 0) {
    failed = ::posix_spawn(&process.id.number, program.c_str(), &files, &attributes, pointers(words).data(),
                           pointers(variables).data());
  }
  if (failed != 0) return io_error(program, "cannot be started", failed);
  process.id.started =
      process_start(process.id.number);  // the child was not waited for, so the number is still its own
  return process;
}

Result<std::optional<RunningProcess>> RunningProcess::find(const ProcessId& id) {
  std::optional<RunningProcess> none;
  if (id.number <= 0) return none;
  FileHandle handle(::pidfd_open(id.number, 0));
  if (handle.get() < 0) {
    if (errno == ESRCH) return none;
    return io_error("process " + std::to_string(id.number), "its state cannot be read", errno);
  }
  // The order matters. The handle was opened before the start time is read, so it means the process with this start
  // time, or a process that has ended.
  if (process_start(id.number) != id.started) return none;
  RunningProcess process(std::move(handle));
  if (process.ends_within(std::chrono::milliseconds(0))) return none;
  return std::optional(std::move(process));
}

Status RunningProcess::signal(int number) const {
  if (::pidfd_send_signal(handle_.get(), number, nullptr, 0) == 0 || errno == ESRCH) return success();
  return io_error("a process of the cluster", "cannot be sent a signal", errno);
}

bool RunningProcess::ends_within(std::chrono::milliseconds time) const {
  const auto until = std::chrono::steady_clock::now() + time;
  pollfd ended{handle_.get(), POLLIN, 0};
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    const int found = ::poll(&ended, 1, static_cast<int>(std::max<std::int64_t>(0, left.count())));
    if (found > 0) return true;
    if (found == 0) return false;  // below 0: a signal interrupted the call
  }
}

}  // namespace tessera::apps
