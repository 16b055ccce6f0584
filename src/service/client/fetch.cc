#include "src/service/client/fetch.h"

#include <fcntl.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/folder_lock.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/service/client/download.h"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

using Bytes = std::vector<std::byte>;

// The manifest and its text, as the server sent it.
struct RemoteManifest {
  Manifest manifest;
  Bytes text;
};

Result<RemoteManifest> remote_manifest(Server& server, const std::string& triangulation, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(folder, TemporaryFolder::make());
  const auto file = manifest_file(folder.path());
  const RemoteFile remote{.triangulation = triangulation, .path = manifest_file("").string(), .bytes = {}, .xxh3 = {}};
  BOOST_OUTCOME_TRYV(download(
      server, remote, file, [](std::uint64_t) {}, stop));
  auto manifest = read_manifest(folder.path());
  if (!manifest) {
    // The error names the server instead of the temporary folder.
    auto why = manifest.error();
    if (const auto at = why.where.find(file.string()); at == 0)
      why.where.replace(0, file.string().size(), server.address().text() + ": the manifest of " + triangulation);
    return why;
  }
  BOOST_OUTCOME_TRY(text, read_whole(file));
  return RemoteManifest{std::move(manifest).value(), std::move(text)};
}

enum class Target : std::uint8_t { fresh, unfinished, same };

Result<Target> inspect(const fs::path& folder, const Bytes& manifest) {
  BOOST_OUTCOME_TRY(found, look_at(folder));
  if (!found) return Target::fresh;
  if (!S_ISDIR(found->st_mode)) return error(Errc::usage, folder.string() + ": is no folder");
  BOOST_OUTCOME_TRY(whole, is_there(manifest_file(folder)));
  if (whole) {
    BOOST_OUTCOME_TRY(text, read_whole(manifest_file(folder)));
    if (text == manifest) return Target::same;
    return error(Errc::usage, folder.string() + ": holds another result; name a new or empty folder");
  }
  BOOST_OUTCOME_TRY(begun, is_there(temporary_name(manifest_file(folder))));
  if (begun) return Target::unfinished;
  FolderReader reader(folder);
  while (const char* name = reader.next()) {
    if (!is_lock_name(name)) return error(Errc::usage, folder.string() + ": is not empty; name a new or empty folder");
  }
  if (reader.error()) return io_error(folder, "cannot be listed", reader.error().value());
  return Target::fresh;
}

struct Wanted {
  RemoteFile file;
  fs::path to;
};

std::vector<Wanted> wanted_of(const Manifest& manifest, const std::string& triangulation, const fs::path& folder) {
  std::vector<Wanted> list;
  const auto add = [&](auto name_in, std::optional<std::uint64_t> bytes, std::uint64_t xxh3, ChecksumOf sum) {
    list.push_back(
        {.file =
             {.triangulation = triangulation, .path = name_in("").string(), .bytes = bytes, .xxh3 = xxh3, .sum = sum},
         .to = name_in(folder)});
  };
  for (const auto& entry : manifest.tiles) {
    add([&](const fs::path& out) { return tile_file(out, entry); }, entry.bytes, entry.xxh3,
        data_sum_of(manifest.format_version));
  }
  add([&](const fs::path& out) { return master_file(out); }, {}, manifest.master_xxh3, ChecksumOf::bytes);
  if (manifest.duplicates_xxh3 != 0) {
    add([&](const fs::path& out) { return duplicates_of(out, manifest); }, {}, manifest.duplicates_xxh3,
        data_sum_of(manifest.format_version));
  }
  if (manifest.duplicate_rows_xxh3 != 0) {
    add([&](const fs::path& out) { return duplicate_rows_of(out, manifest); }, {}, manifest.duplicate_rows_xxh3,
        data_sum_of(manifest.format_version));
  }
  return list;
}

// True if the file exists and is the one in the manifest.
Result<bool> is_fetched(const Wanted& wanted) {
  BOOST_OUTCOME_TRY(bytes, bytes_if_there(wanted.to));
  if (!bytes || (wanted.file.bytes && *bytes != *wanted.file.bytes)) return false;
  BOOST_OUTCOME_TRY(sum, checksum_file(wanted.to, wanted.file.sum));
  return sum == *wanted.file.xxh3;
}

// The report is for people: a result is complete without it.
Status fetch_report(Server& server, const std::string& triangulation, const fs::path& folder,
                    const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(there, is_there(report_file(folder)));
  if (there) return success();
  const RemoteFile report{.triangulation = triangulation, .path = report_file("").string(), .bytes = {}, .xxh3 = {}};
  const auto fetched = download(
      server, report, report_file(folder), [](std::uint64_t) {}, stop);
  if (fetched || fetched.error().code != Errc::usage) return fetched;
  return remove_file(temporary_name(report_file(folder)));
}

}  // namespace

Result<Manifest> fetch_manifest(Server& server, const std::string& triangulation, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(remote, remote_manifest(server, triangulation, stop));
  return std::move(remote.manifest);
}

Result<Fetched> fetch_result(Server& server, const std::string& triangulation, const fs::path& folder,
                             const std::function<void(const FetchProgress&)>& on_progress,
                             const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(remote, remote_manifest(server, triangulation, stop));
  const auto& manifest = remote.manifest;
  BOOST_OUTCOME_TRYV(inspect(folder, remote.text));
  BOOST_OUTCOME_TRYV(make_directories(folder));
  BOOST_OUTCOME_TRY(lock, FolderLock::take(folder));
  BOOST_OUTCOME_TRY(target, inspect(folder, remote.text));  // another process may have been faster
  const auto unfinished = temporary_name(manifest_file(folder));
  if (target != Target::same) {
    BOOST_OUTCOME_TRY(file, open_handle(unfinished, O_WRONLY | O_CREAT | O_TRUNC));
    BOOST_OUTCOME_TRYV(write_at(file.get(), remote.text, 0, unfinished));
  }
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(folder)));

  const auto list = wanted_of(manifest, triangulation, folder);
  Fetched fetched{.files = list.size() + 1,
                  .bytes = 0,
                  .vertices = manifest.vertices,
                  .cells = manifest.cells,
                  .tiles = manifest.tiles.size()};
  FetchProgress progress;
  for (const auto& wanted : list) progress.bytes_total += wanted.file.bytes.value_or(0);
  for (const auto& wanted : list) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted");
    BOOST_OUTCOME_TRYV(check_held(lock.file()));
    BOOST_OUTCOME_TRY(there, is_fetched(wanted));
    const auto before = progress.bytes;
    if (!there) {
      BOOST_OUTCOME_TRYV(download(
          server, wanted.file, wanted.to,
          [&](std::uint64_t bytes) {
            progress.bytes += bytes;
            on_progress(progress);
          },
          stop));
    }
    // Bytes that were sent twice count once.
    progress.bytes = before + wanted.file.bytes.value_or(0);
    on_progress(progress);
    BOOST_OUTCOME_TRY(bytes, file_bytes(wanted.to));
    fetched.bytes += bytes;
  }
  BOOST_OUTCOME_TRYV(fetch_report(server, triangulation, folder, stop));
  if (target != Target::same) {
    BOOST_OUTCOME_TRYV(sync_folder(tiles_folder(folder)));
    BOOST_OUTCOME_TRYV(publish(unfinished, manifest_file(folder)));
  }
  BOOST_OUTCOME_TRYV(sync_folder(folder));
  return fetched;
}

}  // namespace tessera::client
