#include "src/front/daemon/last_words.h"

#include <fcntl.h>
#include <signal.h>
#include <string.h>  // sigabbrev_np
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/files/names.h"
#include "src/base/files/process.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"

namespace tessera::daemon {
namespace {

constexpr char format[8] = {'T', 'S', 'L', 'I', 'F', 'E', '1', '\n'};
constexpr std::size_t groups_max = 8, text_max = 256, path_max = 512;

enum class End : std::uint32_t { none, in_order, told };

// A control group, with the number of processes that the kernel had killed in it for want of memory.
struct Group {
  char path[path_max];
  std::uint64_t identity;  // the inode of its folder, which tells it from a later group with the same name
  std::uint64_t kills;
};

template <std::size_t size>
void put(char (&to)[size], std::string_view text) {
  const std::size_t n = std::min(text.size(), size - 1);
  std::memcpy(to, text.data(), n);
  to[n] = 0;
}

template <std::size_t size>
std::string text_of(const char (&from)[size]) {
  return {from, ::strnlen(from, size)};
}

// Returns how many processes the kernel has killed for want of memory: with cgroup v2 in the group and all groups below
// it, with v1 in the group alone. No value if that is not known.
std::optional<std::uint64_t> kills_in(const std::string& group) {
  for (const char* name : {"/memory.events", "/memory.oom_control"}) {
    std::ifstream file(group + name);
    std::string key;
    std::uint64_t value = 0;
    while (file >> key >> value) {
      if (key == "oom_kill") return value;
    }
  }
  return std::nullopt;
}

std::uint64_t identity_of(const std::string& folder) {
  const auto found = look_at(folder);  // an error if the system cannot tell; no value if there is no folder
  return found && found.value() ? found.value()->st_ino : 0;
}

// Returns the control groups around this process, the innermost first.
std::vector<std::string> groups_of_this_process() {
  std::vector<std::string> groups;
  std::ifstream file("/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (!controllers.empty() && controllers != "memory") continue;
    const std::string root = controllers.empty() ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
    std::filesystem::path group = line.substr(second + 1);
    while (true) {
      const std::string folder = root + (group == "/" ? "" : group.string());
      if (kills_in(folder)) groups.push_back(folder);
      if (group == "/" || group.empty()) break;
      group = group.parent_path();
    }
  }
  return groups;
}

}  // namespace

struct LastWords::Record {
  char identity[sizeof format];
  char boot[64];
  std::uint32_t end;     // an End
  std::uint32_t signal;  // 0: none
  char how[text_max];
  std::uint32_t doing_now;  // which of the two texts below counts
  char doing[2][text_max];
  Group groups[groups_max];

  static std::atomic<Record*> kept;
  static Record* map(const FileHandle& file, int protection, int flags) {
    void* at = ::mmap(nullptr, sizeof(Record), protection, flags, file.get(), 0);
    return at == MAP_FAILED ? nullptr : static_cast<Record*>(at);
  }
  std::string memory_words() const;
  std::string words() const;
  static void on_signal(int number);
};
std::atomic<LastWords::Record*> LastWords::Record::kept{nullptr};

// Returns what the innermost control group that still exists tells about want of memory.
std::string LastWords::Record::memory_words() const {
  for (std::size_t i = 0; i < groups_max; ++i) {
    const std::string path = text_of(groups[i].path);
    if (path.empty()) return i == 0 ? "" : ", together with its control group";
    if (identity_of(path) != groups[i].identity) continue;
    const auto now = kills_in(path);
    if (!now) continue;
    if (*now > groups[i].kills) {
      return ", and the kernel has killed processes for lack of memory in its control group " + path + " (" +
             std::to_string(*now - groups[i].kills) + " times since it began)";
    }
    return i == 0 ? "" : ", together with its control group";
  }
  return ", together with its control group";
}

std::string LastWords::Record::words() const {
  if (!std::equal(std::begin(format), std::end(format), identity)) return {};
  std::string words;
  if (end == static_cast<std::uint32_t>(End::in_order)) return {};
  if (signal != 0) {
    const char* name = ::sigabbrev_np(static_cast<int>(signal));
    words = "was ended by signal " + (name ? "SIG" + std::string(name) : std::to_string(signal));
  } else if (end == static_cast<std::uint32_t>(End::told)) {
    words = text_of(how);
  } else if (text_of(boot) != boot_id()) {
    words = "went down with its machine";
  } else {
    words = "was killed (SIGKILL)" + memory_words();
  }
  const std::string was = text_of(doing[doing_now % 2]);
  return was.empty() ? words : words + ", while " + was;
}

// Records the signal and raises it again. The handler is gone then (SA_RESETHAND), so the signal ends the process.
void LastWords::Record::on_signal(int number) {
  if (Record* const record = kept.load(); record && record->signal == 0)
    record->signal = static_cast<std::uint32_t>(number);
  ::raise(number);
}

void LastWords::end_by(int signal) {
  struct sigaction action {};
  action.sa_handler = &Record::on_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_NODEFER;
  ::sigaction(signal, &action, nullptr);
}

Result<std::unique_ptr<LastWords>> LastWords::keep(const std::filesystem::path& scratch) {
  const auto path = last_words_file(scratch);
  BOOST_OUTCOME_TRY(file, open_handle(path, O_RDWR | O_CREAT | O_NOFOLLOW));
  BOOST_OUTCOME_TRY(size, size_of(file, path));
  // The blocks of the file are allocated before it is mapped. Otherwise a write on a full disk would raise SIGBUS.
  if (const int failed = ::posix_fallocate(file.get(), 0, sizeof(Record)); failed != 0)
    return io_error(path, "cannot be written", failed);
  Record* const record = Record::map(file, PROT_READ | PROT_WRITE, MAP_SHARED);
  if (!record) return io_error(path, "cannot map", errno);
  std::unique_ptr<LastWords> words(new LastWords(record));
  if (size == sizeof(Record)) words->before_ = record->words();
  std::memset(static_cast<void*>(record), 0, sizeof(Record));
  put(record->boot, boot_id());
  std::size_t at = 0;
  for (const std::string& group : groups_of_this_process()) {
    if (at == groups_max || group.size() >= path_max) break;
    put(record->groups[at].path, group);
    record->groups[at].identity = identity_of(group);
    record->groups[at++].kills = kills_in(group).value_or(0);
  }
  std::atomic_thread_fence(std::memory_order_release);
  std::copy(std::begin(format), std::end(format), record->identity);
  Record::kept = record;
  for (int number = 1; number <= SIGRTMAX; ++number) {
    constexpr int ignored[] = {SIGCHLD, SIGCONT, SIGTSTP, SIGTTIN, SIGTTOU, SIGURG, SIGWINCH, SIGTERM, SIGINT};
    if (std::find(std::begin(ignored), std::end(ignored), number) != std::end(ignored)) continue;
    struct sigaction before {};
    if (::sigaction(number, nullptr, &before) == 0 && before.sa_handler == SIG_DFL) end_by(number);
  }
  return words;
}

LastWords::~LastWords() {
  ends("ended by an exception");  // has no effect if another end was recorded before
  Record::kept = nullptr;
  ::munmap(record_, sizeof(Record));
}

// Writes the text that does not count at the moment, and only then lets it count.
void LastWords::doing(std::string_view what) {
  const std::uint32_t other = 1 - record_->doing_now % 2;
  put(record_->doing[other], what);
  std::atomic_thread_fence(std::memory_order_release);
  record_->doing_now = other;
}

void LastWords::ends(std::string_view how) {
  if (record_->end != static_cast<std::uint32_t>(End::none)) return;
  put(record_->how, how);
  std::atomic_thread_fence(std::memory_order_release);
  record_->end = static_cast<std::uint32_t>(End::told);
}

void LastWords::ends(const Status& served) {
  if (record_->end != static_cast<std::uint32_t>(End::none)) return;
  if (served) {
    record_->end = static_cast<std::uint32_t>(End::in_order);
  } else {
    const int status = static_cast<int>(served.error().code);
    ends("ended with status " + std::to_string(status) + " (" + served.error().where + ")");
  }
}

}  // namespace tessera::daemon
