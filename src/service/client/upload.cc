#include "src/service/client/upload.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <span>

#include "src/base/files/descriptor.h"
#include "src/service/client/patience.h"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

constexpr int conflict = 409;  // also while the server has not noticed the end of a connection

Result<std::uint64_t> size_to_send(const FileHandle& file, const fs::path& path) {
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return io_error(path, "cannot be looked at", errno);
  if (!S_ISREG(status.st_mode)) return error(Errc::usage, path.string() + ": is no file; name the files to send");
  return static_cast<std::uint64_t>(status.st_size);
}

}  // namespace

Result<std::uint64_t> upload(Server& server, const fs::path& path, const std::string& folder, const std::string& name,
                             const std::function<void(std::uint64_t)>& on_bytes, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(file, open_handle(path, O_RDONLY));
  BOOST_OUTCOME_TRY(size, size_to_send(file, path));
  std::uint64_t at = 0;
  bool disk_failed = false;
  const auto source = [&](std::span<char> bytes) -> Result<std::size_t> {
    const auto read = ::pread(file.get(), bytes.data(), bytes.size(), static_cast<off_t>(at));
    disk_failed = read <= 0;
    if (read < 0) return io_error(path, "cannot be read", errno);
    if (read == 0) return error(Errc::io, path.string() + ": has become shorter while it was sent");
    at += static_cast<std::uint64_t>(read);
    on_bytes(at);
    return static_cast<std::size_t>(read);
  };
  std::uint64_t from = 0;
  bool again = false;
  Patience patience(server.patience());
  while (true) {
    at = from;
    int answer = 0;
    const auto sent = server.upload(folder, name, from, size - from, source, answer, stop);
    if (sent) return size;
    const bool cut = answer == 0 ? sent.error().code == Errc::io && !disk_failed : again && answer == conflict;
    // The server was never reached, or waiting does not help.
    if (!cut || (at == 0 && !again)) return sent.error();
    again = true;
    BOOST_OUTCOME_TRYV(patience.wait(sent.error(), stop));
    const auto there = server.uploaded(folder, name, stop);
    if (!there && there.error().code != Errc::io) return there.error();
    if (!there) continue;
    if (there.value() != from) patience.restart();
    // If the server has more than the file, these are bytes of another file.
    from = there.value() <= size ? there.value() : 0;
    on_bytes(from);
  }
}

}  // namespace tessera::client
