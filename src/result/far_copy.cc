#include "src/result/far_copy.h"

#include <fcntl.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>

#include "src/base/attribute.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/folder_lock.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/on_threads.h"
#include "src/base/option.h"
#include "src/input/bytes/objects.h"
#include "src/result/check_sum.h"
#include "src/result/held_manifest.h"
#include "src/result/store/duplicate_rows.h"
#include "src/result/store/manifest.h"
#include "src/result/store/vtk_xml.h"

namespace tessera::result {

namespace fs = std::filesystem;

namespace {

constexpr unsigned files_at_once = 4;  // of each, several ranges are fetched at once

std::vector<NamedFile> all_files(const Manifest& manifest) {
  std::vector<NamedFile> files;
  for (const TileEntry& entry : manifest.tiles)
    files.push_back({tile_file("", entry), {entry.bytes, entry.xxh3, data_sum_of(manifest.format_version)}});
  for (auto& file : files_beside_tiles(manifest)) files.push_back(std::move(file));
  return files;
}

// The name of a far result without slashes at its end.
std::string place_of(std::string name) {
  while (name.ends_with('/')) name.pop_back();
  return name;
}

std::string far_file(const std::string& name, const fs::path& file) {
  return place_of(name) + "/" + file.generic_string();
}

CopiedResult counts_of(const Manifest& manifest) {
  return {
      .files = 0, .bytes = 0, .vertices = manifest.vertices, .cells = manifest.cells, .tiles = manifest.tiles.size()};
}

// An object with the bytes of a file.
Result<NewObject> object_of(const fs::path& path, std::string name) {
  BOOST_OUTCOME_TRY(opened, open_handle(path, O_RDONLY));
  BOOST_OUTCOME_TRY(bytes, size_of(opened, path));
  const auto read = [path](std::uint64_t offset, std::span<std::byte> out) -> Status {
    // Opened for each piece: a result has more files than a process may have open.
    BOOST_OUTCOME_TRY(file, open_handle(path, O_RDONLY));
    BOOST_OUTCOME_TRY(got, read_up_to(file.get(), out, offset, path));
    if (got == out.size()) return success();
    return error(Errc::io, path.string() + ": became shorter while it was read");
  };
  return NewObject{.name = std::move(name), .bytes = bytes, .read = read, .only_new = false};
}

// The files of a folder's result as objects. The manifest is not among them.
Result<std::vector<NewObject>> objects_of(const fs::path& folder, const Manifest& manifest, const std::string& name,
                                          const std::stop_token& stop) {
  std::vector<NewObject> objects;
  for (const auto& [file, told] : all_files(manifest)) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted");
    BOOST_OUTCOME_TRYV(check_sum(folder / file, told.xxh3, told.sum));
    BOOST_OUTCOME_TRY(object, object_of(folder / file, far_file(name, file)));
    objects.push_back(std::move(object));
  }
  BOOST_OUTCOME_TRY(reported, is_there(report_file(folder)));
  if (reported) {
    BOOST_OUTCOME_TRY(object, object_of(report_file(folder), far_file(name, report_file(""))));
    objects.push_back(std::move(object));
  }
  return objects;
}

// Makes the result in a store no result. Returns the names of its files; nothing when there is none.
Result<std::set<std::string>> take_away(const std::string& name, const std::stop_token& stop) {
  std::set<std::string> files;
  BOOST_OUTCOME_TRY(there, object_exists(far_file(name, manifest_file("")), stop));
  if (!there) return files;
  // A manifest that is damaged or of a newer program stays: its owner decides.
  BOOST_OUTCOME_TRY(manifest, read_far_manifest(place_of(name)));
  for (const auto& [file, told] : all_files(manifest)) files.insert(far_file(name, file));
  BOOST_OUTCOME_TRYV(remove_object(far_file(name, manifest_file("")), stop));
  return files;
}

class IntoNamedFile : public ObjectTaker {
 public:
  IntoNamedFile(std::string from, const fs::path& to, std::uint64_t told, std::function<void(std::uint64_t)> tell)
      : from_(std::move(from)), to_(to), told_(told), tell_(std::move(tell)) {}
  Status begin(std::uint64_t bytes) override {
    if (bytes != told_)
      return error(Errc::corrupt,
                   from_ + ": has " + std::to_string(bytes) + " bytes, but the manifest says " + std::to_string(told_));
    BOOST_OUTCOME_TRY(file, open_handle(temporary_name(to_), O_WRONLY | O_CREAT | O_TRUNC, to_));
    file_ = std::move(file);
    return success();
  }
  Status take(std::span<const std::byte> bytes) override {
    BOOST_OUTCOME_TRYV(write_at(file_.get(), bytes, written_, to_));
    written_ += bytes.size();
    tell_(bytes.size());
    return success();
  }

 private:
  std::string from_;
  const fs::path& to_;
  std::uint64_t told_, written_ = 0;
  std::function<void(std::uint64_t)> tell_;
  FileHandle file_;
};

Status fetch_file(const std::string& from, const fs::path& to, const ToldFile& told,
                  const std::function<void(std::uint64_t)>& tell, const std::stop_token& stop) {
  TemporaryFile unfinished(temporary_name(to));
  {
    IntoNamedFile taker(from, to, told.bytes, tell);
    BOOST_OUTCOME_TRYV(copy_object(from, taker, stop));
  }
  const auto same = check_sum(unfinished.path(), told.xxh3, told.sum);
  if (!same) {
    auto wrong = same.error();
    if (wrong.where.starts_with(unfinished.path().string()))
      wrong.where.replace(0, unfinished.path().string().size(), from);
    return wrong;
  }
  BOOST_OUTCOME_TRYV(publish(unfinished.path(), to));
  unfinished.keep();
  return success();
}

// Adds up what arrives, for one listener at a time.
std::function<void(std::uint64_t)> adding_up(const TellBytes& tell, std::uint64_t total) {
  struct Sum {
    std::mutex mutex;
    std::uint64_t bytes = 0;
  };
  return [tell, total, sum = std::make_shared<Sum>()](std::uint64_t bytes) {
    const std::lock_guard lock(sum->mutex);
    sum->bytes += bytes;
    if (tell) tell(sum->bytes, total);
  };
}

// Copies the files, the manifest last.
Status fill(const std::string& name, const fs::path& folder, const Manifest& manifest, std::span<const std::byte> text,
            const TellBytes& tell, const std::stop_token& stop) {
  const auto files = all_files(manifest);
  std::uint64_t total = 0;
  for (const auto& [file, told] : files) total += told.bytes;
  const auto add = adding_up(tell, total);
  BOOST_OUTCOME_TRYV(make_directories(tiles_folder(folder)));
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  BOOST_OUTCOME_TRYV(on_threads(files_at_once, failed, [&]() -> Status {
    for (std::size_t i = next++; i < files.size() && !failed; i = next++) {
      BOOST_OUTCOME_TRYV(
          fetch_file(far_file(name, files[i].first), folder / files[i].first, files[i].second, add, stop));
    }
    return success();
  }));
  BOOST_OUTCOME_TRYV(sync_folder(tiles_folder(folder)));
  return write_whole(manifest_file(folder), text);
}

}  // namespace

std::vector<NamedFile> files_beside_tiles(const Manifest& manifest) {
  std::vector<NamedFile> files;
  files.push_back({master_file(""), {store::master_text(manifest).size(), manifest.master_xxh3, ChecksumOf::bytes}});
  const ChecksumOf sum = data_sum_of(manifest.format_version);
  if (manifest.duplicates_xxh3 != 0)
    files.push_back(
        {duplicates_of("", manifest), {manifest.duplicates * sizeof(DuplicatePair), manifest.duplicates_xxh3, sum}});
  if (manifest.duplicate_rows_xxh3 != 0)
    files.push_back({duplicate_rows_of("", manifest),
                     {manifest.duplicates * row_bytes(carried_schema(manifest)), manifest.duplicate_rows_xxh3, sum}});
  return files;
}

Status check_far_target(const std::string& name, bool overwrite, const std::stop_token& stop) {
  if (!name.starts_with("s3://") || name.find_first_of("?#") != std::string::npos)
    return error(Errc::usage, name.substr(0, name.find_first_of("?#")) +
                                  ": results are written to folders and to s3://bucket/folder");
  if (place_of(name).find('/', 5) == std::string::npos)
    return error(Errc::usage, name + ": names no folder in the bucket, as s3://bucket/folder does");
  const std::string manifest = far_file(name, manifest_file(""));
  BOOST_OUTCOME_TRY(there, object_exists(manifest, stop));
  if (there && !overwrite)
    return error(Errc::usage, name + ": holds a finished result; " + option("overwrite", "true") + " replaces it");
  return check_writable_object(manifest, stop);
}

Result<CopiedResult> put_result(const fs::path& folder, const std::string& name, bool overwrite, const TellBytes& tell,
                                const std::stop_token& stop) {
  BOOST_OUTCOME_TRYV(check_far_target(name, overwrite, stop));
  BOOST_OUTCOME_TRY(held, hold_manifest(folder));
  BOOST_OUTCOME_TRY(objects, objects_of(folder, held.manifest, name, stop));
  BOOST_OUTCOME_TRY(bytes, size_of(held.file, manifest_file(folder)));
  std::vector<std::byte> text(bytes);
  BOOST_OUTCOME_TRY(got, read_up_to(held.file.get(), text, 0, manifest_file(folder)));
  text.resize(got);
  const NewObject manifest{.name = far_file(name, manifest_file("")),
                           .bytes = text.size(),
                           .read = [&](std::uint64_t offset, std::span<std::byte> out) -> Status {
                             const auto from = std::span<const std::byte>(text).subspan(offset, out.size());
                             std::copy(from.begin(), from.end(), out.begin());
                             return success();
                           },
                           .only_new = true};
  CopiedResult copied = counts_of(held.manifest);
  copied.files = objects.size() + 1;
  copied.bytes = manifest.bytes;
  for (const auto& object : objects) copied.bytes += object.bytes;
  const auto add = adding_up(tell, copied.bytes);

  BOOST_OUTCOME_TRY(stale, take_away(name, stop));
  BOOST_OUTCOME_TRYV(put_objects(objects, add, stop));
  BOOST_OUTCOME_TRYV(put_objects(std::span(&manifest, 1), add, stop));
  for (const auto& object : objects) stale.erase(object.name);
  for (const auto& file : stale) {
    BOOST_OUTCOME_TRYV(remove_object(file, stop));
  }
  return copied;
}

Result<CopiedResult> copy_far_result(const fs::path& name, const fs::path& folder, const TellBytes& tell,
                                     const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(far, read_far_text(name));
  BOOST_OUTCOME_TRY(manifest, parse_manifest(manifest_file(name), far));
  BOOST_OUTCOME_TRY(there, is_there(folder));
  if (there) {
    BOOST_OUTCOME_TRY(empty, is_empty_folder(folder));
    if (!empty) return error(Errc::usage, folder.string() + ": is not empty; name a new or empty folder");
  }
  BOOST_OUTCOME_TRYV(make_directories(folder));
  const auto filled = fill(name.string(), folder, manifest, far, tell, stop);
  if (!filled) {
    for (const auto& [file, told] : all_files(manifest)) {
      BOOST_OUTCOME_TRYV(remove_file(folder / file));
    }
    std::error_code ignored;  // what another program has put there stays
    fs::remove(tiles_folder(folder), ignored);
    if (!there) fs::remove(folder, ignored);
    return filled.error();
  }
  CopiedResult copied = counts_of(manifest);
  copied.files = all_files(manifest).size() + 1;
  copied.bytes = far.size();
  for (const auto& [file, told] : all_files(manifest)) copied.bytes += told.bytes;
  return copied;
}

}  // namespace tessera::result
