// The result folders of a data folder: complete results only. A job makes its result beside them under a hidden name,
// and renames it when it is complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "job_record.pb.h"
#include "service.pb.h"
#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/service/reply.h"
#include "src/service/staging_folder.h"

namespace tessera::service {

class ResultFolders {
 public:
  // `desk` is the staging folder of the results; every change passes through it.
  ResultFolders(const std::filesystem::path& data, StagingFolder& desk);
  // Makes the folder. Removes what was half removed, and what was made for jobs that are not among `jobs`. Files that
  // are not ours stay.
  Status open(const std::set<std::string>& jobs);

  std::filesystem::path folder(std::string_view name) const;
  // The path that stands for this version wherever a result is read (named_version()). 0: the newest.
  std::filesystem::path folder(std::string_view name, std::uint32_t version) const;
  // Where the job makes its triangulation or its export, on the same file system. A change of a result is made in
  // update_run_folder() of unfinished().
  std::filesystem::path unfinished(const std::string& job) const;
  std::filesystem::path unfinished_export(std::string_view name, const std::string& job) const;

  // Also false for an invalid name. Error io, here and below.
  Result<bool> exists(std::string_view name) const;
  Result<bool> export_exists(std::string_view name, const std::string& file) const;
  // The command in the manifest of this job's result. It tells the job and the owner of a result, even when the job is
  // forgotten.
  static std::vector<std::string> command_of(const proto::JobRecord& job);
  // Whether a command of a log of versions, where long words are shortened, is that of the job.
  static bool is_of(const std::vector<std::string>& command, const proto::JobRecord& job);
  struct Maker {
    std::string job, owner;  // empty when the manifest does not say, or is damaged
  };
  Result<Maker> maker(std::string_view name);
  Result<bool> made_by(std::string_view name, const std::string& job);
  // True if the job's folder has become the result already, before a crash.
  Result<bool> is_published(const std::string& job, std::string_view name);

  // Makes the job's folder the result. Returns the folder of the replaced result, for discard(). Error usage when a
  // result exists that may not be replaced.
  Result<std::filesystem::path> publish(const std::string& job, const std::string& name, bool overwrite);

  // Removes what the job has made and not published: its unfinished folder and that of a change, or that of an export
  // of `exported_from`; of the latter all but the folder or file `but`.
  Status drop_unfinished(const std::string& job);
  // Removes only what a change of a result has needed.
  Status drop_change(const std::string& job);
  Status drop_unfinished_export(std::string_view exported_from, const std::string& job,
                                const std::filesystem::path& but = {});

  Status remove_export(std::string_view name, const std::string& file);
  // The owner of an export; empty when unknown. Error io.
  Result<std::string> export_owner(std::string_view name, const std::string& file) const;
  // Moves the job's export to its place. Files that the job has made beside its output may replace only files of its
  // owner, or files that belonged to the replaced output. Error usage.
  Status publish_export(const proto::JobRecord& job);
  // Removes the result from its place. Returns a folder for discard(), which removes the files and may take long. Error
  // io.
  Result<std::filesystem::path> take_away(std::string_view name);
  static Status discard(const std::filesystem::path& folder);

  Result<std::vector<std::string>> names() const;  // sorted
  Reply<proto::TriangulationInfo> info(std::string_view name);
  Reply<ServedFile> file(std::string_view name, std::string_view path);
  // Errors: io when there is no such result; corrupt.
  Result<std::shared_ptr<const Manifest>> manifest(std::string_view name, std::uint32_t version = 0);

  struct Held {
    FileHandle folder;  // open: another result cannot take its place
    std::shared_ptr<const Manifest> manifest;
    std::string identity;  // differs from that of any other result of the same name
    std::string created;
  };
  // `version` 0: the newest. Error usage, also, for a version that cannot be read.
  Result<Held> hold(std::string_view name, std::uint32_t version = 0);
  // Returns nothing when there is no such result.
  Result<std::optional<Held>> find(std::string_view name);

 private:
  Status drop(const std::filesystem::path& folder);
  std::shared_ptr<const Manifest> known_manifest(const std::string& identity);
  void keep_manifest(const std::string& identity, const std::shared_ptr<const Manifest>& manifest);

  std::filesystem::path results_;
  StagingFolder& desk_;
  // Manifests with many tiles are large: keeps those used last, by the identity of the file.
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const Manifest>> manifests_;
};

// The media type of a file's ending; never one that a browser would execute.
std::string media_type_of(const std::filesystem::path& path);
// Makes an answer of an open regular file; `etag` has no quotes.
Result<ServedFile> served(FileHandle file, const std::filesystem::path& path, const std::string& type,
                          std::string etag);

}  // namespace tessera::service
