// Jobs on disk: a folder for each, whose record is replaced whole. What is not ours is neither touched nor removed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "job_record.pb.h"
#include "src/base/files/shared_sync.h"
#include "src/base/result.h"
#include "src/service/staging_folder.h"

namespace tessera {

class JobStore {
 public:
  // `desk`: of the data folder; every change passes over it.
  JobStore(std::filesystem::path data, StagingFolder& desk);

  struct Loaded {
    std::vector<proto::JobRecord> jobs;  // by id
    // Id, and what is wrong with the record: what is there stays, and is told of.
    std::vector<std::pair<std::string, std::string>> damaged;
    std::set<std::string> forgotten;    // ids of jobs that were removed
    std::vector<std::string> warnings;  // sentences: what is there and cannot be read; it stays
    std::string last_id;                // the greatest that there ever was
  };
  // Also removes what a process that was killed has left: folders of jobs that were never accepted, or are forgotten.
  Result<Loaded> load();

  // On disk, for good, when this returns without error: then, and only then, a job is accepted. Without it nothing is
  // left of a new job. Syncs its record and its folder, and with all that are added at the same time the folder of
  // jobs. Safe to call from several threads for different jobs, also beside all else.
  Status add(const proto::JobRecord& job);
  Status replace(const proto::JobRecord& job);
  // Its id stays in the list of forgotten ones; on a full disk from the next load() on.
  Status forget(const std::string& id);

  // A line for people, with the time. What cannot be written is lost: a full disk ends no job.
  void log(const std::string& id, std::string_view line) const;
  // Replaces the outcome: JSON.
  Status write_outcome(const std::string& id, std::string_view json);

  std::filesystem::path folder(const std::string& id) const;
  const std::filesystem::path& data() const { return data_; }

 private:
  Result<proto::JobRecord> read_record(const std::string& id) const;
  Status write_record(const proto::JobRecord& job);
  Status remove_files(const std::filesystem::path& job) const;
  Status finish_forgetting(const std::string& id) const;
  Result<std::set<std::string>> read_forgotten() const;

  std::filesystem::path data_;
  StagingFolder& desk_;
  SharedSync new_folders_;
};

}  // namespace tessera
