// Stores jobs on disk: a folder for each job, whose record is replaced as a whole. Files that are not ours are neither
// changed nor removed.
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

namespace tessera::service {

class JobStore {
 public:
  // `desk` is the staging folder of the data folder; every change passes through it.
  JobStore(std::filesystem::path data, StagingFolder& desk);

  struct Loaded {
    std::vector<proto::JobRecord> jobs;  // by id
    // Ids of jobs with damaged records, and what is wrong. Their files are kept, and the jobs are reported.
    std::vector<std::pair<std::string, std::string>> damaged;
    std::set<std::string> forgotten;    // ids of jobs that were removed
    std::vector<std::string> warnings;  // sentences about files that cannot be read; they stay
    std::string last_id;                // the greatest id that there ever was
  };
  // Loads all jobs. Also removes what a killed process has left: folders of jobs that were never accepted or are
  // forgotten.
  Result<Loaded> load();

  // Adds a job. A return without error means that the job is safely on disk; only then is it accepted. After an error
  // nothing is left of the job. Syncs the job's record and folder; calls at the same time share the sync of the folder
  // of jobs. Safe to call from several threads for different jobs, also beside all other functions.
  Status add(const proto::JobRecord& job);
  Status replace(const proto::JobRecord& job);
  // Removes a job. Its id stays in the list of forgotten jobs; if the disk is full, it is added at the next load().
  Status forget(const std::string& id);

  // Adds a line with the time to the job's log. Errors are ignored, because a full disk must not end a job.
  void log(const std::string& id, std::string_view line) const;
  // Replaces the job's outcome, which is JSON.
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

}  // namespace tessera::service
