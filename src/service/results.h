// The result folders of a data folder: complete ones only. What a job makes stands beside them under a hidden name, and
// is renamed when it is whole.
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
#include "src/service/service.h"
#include "src/service/staging_folder.h"

namespace tessera {

class Results {
 public:
  // `desk`: of the results of the data folder; every change passes over it.
  Results(const std::filesystem::path& data, StagingFolder& desk);
  // Makes the folder, and removes what was being removed or made for jobs that are not among `jobs`. What of it is not
  // ours stays.
  Status open(const std::set<std::string>& jobs);

  std::filesystem::path folder(std::string_view name) const;
  // Where the job makes its triangulation, or what it exports: on the same file system.
  std::filesystem::path unfinished(const std::string& job) const;
  std::filesystem::path unfinished_export(std::string_view name, const std::string& job) const;

  // False also for what can be no name. Error io, here and below.
  Result<bool> exists(std::string_view name) const;
  Result<bool> export_exists(std::string_view name, const std::string& file) const;
  // The command in the manifest of what this job makes; by it a result is known to be the job's, and its owner's, even
  // when nothing is known of the job any more.
  static std::vector<std::string> command_of(const proto::JobRecord& job);
  struct Maker {
    std::string job, owner;  // empty when the manifest does not say, or is damaged
  };
  Result<Maker> maker(std::string_view name);
  Result<bool> made_by(std::string_view name, const std::string& job);
  // Whether the job's folder has become the result already: before a crash.
  Result<bool> is_published(const std::string& job, std::string_view name);

  // The job's folder becomes the result; for one that stood there before, what is to be given to discard(). Error usage
  // when one stands there that may not be replaced.
  Result<std::filesystem::path> publish(const std::string& job, const std::string& name, bool overwrite);

  // What the job has made, and did not publish, is gone: its unfinished folder, or that of an export of
  // `exported_from`, there with all but the folder or file `but`.
  Status drop_unfinished(const std::string& job);
  Status drop_unfinished_export(std::string_view exported_from, const std::string& job,
                                const std::filesystem::path& but = {});

  Status remove_export(std::string_view name, const std::string& file);
  // Empty when nobody knows. Error io.
  Result<std::string> export_owner(std::string_view name, const std::string& file) const;
  // What the job has made beside its output replaces only what was its owner's, or of one piece with what stood in the
  // output's place. Error usage.
  Status publish_export(const proto::JobRecord& job);
  // The result is gone; its files are, once what this returns is given to discard(), which takes its time. Error io.
  Result<std::filesystem::path> take_away(std::string_view name);
  static Status discard(const std::filesystem::path& folder);

  Result<std::vector<std::string>> names() const;  // sorted
  Reply<proto::TriangulationInfo> info(std::string_view name);
  Reply<ServedFile> file(std::string_view name, std::string_view path);
  // Error io when there is none, corrupt.
  Result<std::shared_ptr<const Manifest>> manifest(std::string_view name);

  struct Held {
    FileHandle folder;  // the result cannot be exchanged for another behind it
    std::shared_ptr<const Manifest> manifest;
    std::string identity;  // another result under the same name has another
    std::string created;
  };
  Result<Held> hold(std::string_view name);
  // Nothing when there is no such result.
  Result<std::optional<Held>> find(std::string_view name);

 private:
  Status drop(const std::filesystem::path& folder);

  std::filesystem::path results_;
  StagingFolder& desk_;
  // Manifests are large where there are many tiles: those asked for last, by what identifies the file.
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const Manifest>> manifests_;
};

// By the ending; what a browser would run is none of it.
std::string media_type_of(const std::filesystem::path& path);
// A file that is open and regular, to be sent; `etag` without quotes.
Result<ServedFile> served(FileHandle file, const std::filesystem::path& path, const std::string& type,
                          std::string etag);

}  // namespace tessera
