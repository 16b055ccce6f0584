#include "src/service/client/download.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <span>
#include <string_view>
#include <system_error>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/service/client/patience.h"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

std::string etag_of(const RemoteFile& file) {
  return file.xxh3 && file.in_manifest ? "\"xxh3-" + checksum_text(*file.xxh3) + "\"" : "";
}

std::string name_of(const RemoteFile& file) { return file.triangulation + "/" + file.path; }

// One request for the bytes after the `have` bytes that `partial` has.
class Transfer {
 public:
  Transfer(FileHandle& out, const fs::path& partial, std::uint64_t have,
           const std::function<void(std::uint64_t)>& on_bytes)
      : out_(out), partial_(partial), begin_(have), have_(have), on_bytes_(on_bytes) {}

  HttpReceiver receiver() {
    return {.head = [this](const HttpHead& head) { return take_head(head); },
            .body = [this](std::string_view bytes) { return take(bytes); }};
  }
  std::uint64_t have() const { return have_; }
  // True for an error of the disk or a refusal of the server, which trying again does not help.
  bool is_final() const { return disk_failed_ || refused_; }

 private:
  Result<bool> take_head(const HttpHead& head) {
    if (head.status == 206 && head.header("content-range").starts_with("bytes " + std::to_string(begin_) + "-"))
      return true;
    refused_ = head.status != 200 && head.status != 206;
    if (refused_) return false;
    // Status 206 here means another range than the requested one; else the whole file comes.
    refused_ = head.status == 206;
    if (refused_) return error(Errc::io, "the server has sent another part of the file than it was asked for");
    if (::ftruncate(out_.get(), 0) != 0) return failed(io_error(partial_, "cannot be emptied", errno));
    have_ = 0;
    return true;
  }
  Status take(std::string_view bytes) {
    const auto written = write_at(out_.get(), std::as_bytes(std::span(bytes)), have_, partial_);
    if (!written) return failed(written.error());
    have_ += bytes.size();
    on_bytes_(bytes.size());
    return success();
  }
  Error failed(Error why) {
    disk_failed_ = true;
    return why;
  }

  FileHandle& out_;
  const fs::path& partial_;
  const std::uint64_t begin_;
  std::uint64_t have_;
  const std::function<void(std::uint64_t)>& on_bytes_;
  bool disk_failed_ = false, refused_ = false;
};

// Receives all bytes into `partial`, over as many connections as needed.
Status receive(Server& server, const RemoteFile& file, const fs::path& partial,
               const std::function<void(std::uint64_t)>& on_bytes, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(out, open_handle(partial, O_WRONLY | O_CREAT));
  BOOST_OUTCOME_TRY(have, size_of(out, partial));
  if (have > 0 && (!file.xxh3 || (file.bytes && have > *file.bytes))) {
    if (::ftruncate(out.get(), 0) != 0) return io_error(partial, "cannot be emptied", errno);
    have = 0;
  }
  on_bytes(have);
  Patience patience(server.patience());
  while (!(file.bytes && have == *file.bytes)) {
    Transfer transfer(out, partial, have, on_bytes);
    auto answer = server.file(file.triangulation, file.path, have, etag_of(file), transfer.receiver(), stop);
    if (answer && answer.value().status == 416) {
      return error(Errc::corrupt, name_of(file) + ": is shorter on the server than the part of it that is here");
    }
    if (transfer.have() != have) patience.restart();
    have = file.xxh3 ? transfer.have() : 0;
    if (answer) break;
    if (answer.error().code != Errc::io || transfer.is_final()) return answer.error();
    BOOST_OUTCOME_TRYV(patience.wait(answer.error(), stop));
    if (have == 0 && ::ftruncate(out.get(), 0) != 0) return io_error(partial, "cannot be emptied", errno);
  }
  if (!out.close()) return io_error(partial, "cannot be written", errno);
  return success();
}

Status check_received(const RemoteFile& file, const fs::path& partial) {
  BOOST_OUTCOME_TRY(bytes, file_bytes(partial));
  if (file.bytes && bytes != *file.bytes) {
    return error(Errc::corrupt, name_of(file) + ": has " + std::to_string(bytes) + " bytes on the server, not " +
                                    std::to_string(*file.bytes) + " as it says itself");
  }
  if (!file.xxh3) return success();
  BOOST_OUTCOME_TRY(sum, checksum_file(partial, file.sum));
  if (sum == *file.xxh3) return success();
  return error(Errc::corrupt, name_of(file) + ": its checksum is " + checksum_text(sum) + ", the server says " +
                                  checksum_text(*file.xxh3) + ": it is damaged there, or on the way");
}

}  // namespace

Status download(Server& server, const RemoteFile& file, const fs::path& to,
                const std::function<void(std::uint64_t)>& on_bytes, const std::stop_token& stop) {
  const auto partial = temporary_name(to);
  while (true) {
    BOOST_OUTCOME_TRY(went_on, is_there(partial));
    auto received = receive(server, file, partial, on_bytes, stop);
    if (received) received = check_received(file, partial);
    if (received) return publish(partial, to);
    if (received.error().code != Errc::corrupt) return received;
    BOOST_OUTCOME_TRYV(remove_file(partial));
    // The partial file may have been the beginning of another file.
    if (!went_on) return received;
  }
}

}  // namespace tessera::client
