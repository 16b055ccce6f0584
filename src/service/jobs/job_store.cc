#include "src/service/jobs/job_store.h"

#include <fcntl.h>

#include <algorithm>
#include <chrono>
#include <span>
#include <system_error>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/service/jobs/job_state.h"
#include "src/service/json.h"
#include "src/service/naming.h"

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

Status append_line(const fs::path& file, const std::string& line, bool sync) {
  BOOST_OUTCOME_TRY(handle, open_handle(file, O_WRONLY | O_CREAT | O_APPEND));
  BOOST_OUTCOME_TRYV(write_on(handle.get(), std::as_bytes(std::span(line)), file));
  if (!sync) return success();
  const fs::path files[] = {file};
  BOOST_OUTCOME_TRYV(sync_files(files));
  return sync_folder(file.parent_path());
}

}  // namespace

JobStore::JobStore(fs::path data, StagingFolder& desk)
    : data_(std::move(data)), desk_(desk), new_folders_(jobs_folder(data_)) {}

fs::path JobStore::folder(const std::string& id) const { return job_folder(data_, id); }

Result<std::set<std::string>> JobStore::read_forgotten() const {
  std::set<std::string> ids;
  BOOST_OUTCOME_TRY(there, is_there(forgotten_jobs_file(data_)));
  if (!there) return ids;
  BOOST_OUTCOME_TRY(bytes, read_whole(forgotten_jobs_file(data_)));
  auto text = as_text(bytes);
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    // A line that was cut off is no id, and its job was not forgotten.
    if (JobIds::is_id(text.substr(0, end))) ids.emplace(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return ids;
}

Result<JobStore::Loaded> JobStore::load() {
  BOOST_OUTCOME_TRYV(make_directories(jobs_folder(data_)));
  Loaded loaded;
  BOOST_OUTCOME_TRY(forgotten, read_forgotten());
  loaded.forgotten = std::move(forgotten);
  BOOST_OUTCOME_TRY(names, sorted_names(jobs_folder(data_)));
  for (const auto& name : names) {
    if (const auto removed = token_of_removed(name)) {
      const bool fresh = JobIds::is_id(*removed) && loaded.forgotten.insert(*removed).second;
      const Status done = fresh ? finish_forgetting(*removed) : remove_files(jobs_folder(data_) / name);
      if (!done) loaded.warnings.push_back(done.error().where);
      continue;
    }
    if (!JobIds::is_id(name)) continue;
    loaded.last_id = std::max(loaded.last_id, name);
    BOOST_OUTCOME_TRY(accepted, is_there(job_record_file(folder(name))));
    if (!accepted) {
      if (const auto removed = remove_files(folder(name)); !removed) loaded.warnings.push_back(removed.error().where);
      continue;
    }
    // If there is a record, the job exists, whatever the list of forgotten jobs says: the list may be from an older
    // daemon.
    loaded.forgotten.erase(name);
    auto job = read_record(name);
    if (job) {
      loaded.jobs.push_back(std::move(job).value());
    } else if (job.error().code == Errc::corrupt) {
      loaded.damaged.emplace_back(name, job.error().where);
    } else {
      return job.error();  // the contents are unknown
    }
  }
  if (!loaded.forgotten.empty()) loaded.last_id = std::max(loaded.last_id, *loaded.forgotten.rbegin());
  return loaded;
}

Result<proto::JobRecord> JobStore::read_record(const std::string& id) const {
  const auto file = job_record_file(folder(id));
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  proto::JobRecord job;
  const auto wrong = [&](const std::string& what) {
    return error(Errc::corrupt, file.string() + ": is not the record of a job, and is left alone: " + what);
  };
  if (const auto read = from_json(as_text(bytes), job); !read) return wrong(read.error().where);
  if (job.id() != id) return wrong("its id is '" + job.id() + "'");
  if (!job_state::is_one(job.state())) return wrong("'" + job.state() + "' is not a state of a job");
  return job;
}

Status JobStore::add(const proto::JobRecord& job) {
  const auto made = [&]() -> Status {
    BOOST_OUTCOME_TRYV(make_directories(folder(job.id())));
    log(job.id(), "accepted");
    BOOST_OUTCOME_TRYV(write_record(job));
    return new_folders_.sync();
  }();
  if (made) return success();
  // The first error is reported.
  if (const auto removed = remove_files(folder(job.id())); !removed)
    return error(made.error().code, made.error().where + "; and " + removed.error().where);
  return made.error();
}

Status JobStore::replace(const proto::JobRecord& job) { return write_record(job); }

Status JobStore::write_record(const proto::JobRecord& job) {
  proto::JobRecord written = job;
  written.set_term(desk_.term());
  return desk_.write(job_record_file(folder(job.id())), to_json(written));
}

Status JobStore::forget(const std::string& id) {
  BOOST_OUTCOME_TRYV(desk_.move(folder(id), removed_folder(jobs_folder(data_), id)));
  // The job is gone. The rest, if it fails as on a full disk, is done by the next load().
  BOOST_OUTCOME_TRYV(sync_folder(jobs_folder(data_)));
  static_cast<void>(finish_forgetting(id));
  return success();
}

Status JobStore::finish_forgetting(const std::string& id) const {
  BOOST_OUTCOME_TRYV(append_line(forgotten_jobs_file(data_), id + "\n", true));
  const auto gone = removed_folder(jobs_folder(data_), id);
  BOOST_OUTCOME_TRYV(remove_files(gone));
  BOOST_OUTCOME_TRY(foreign, is_there(gone, FollowLinks::no));
  return foreign ? desk_.move(gone, folder(id)) : success();  // files that are not ours stay in their place
}

// Removes our files from the folder of a job.
Status JobStore::remove_files(const fs::path& job) const {
  BOOST_OUTCOME_TRY(there, is_there(job, FollowLinks::no));
  if (!there) return success();
  BOOST_OUTCOME_TRY(names, sorted_names(job));
  for (const auto& name : names) {
    if (!is_job_name(name) || name == job_record_file("")) continue;
    BOOST_OUTCOME_TRYV(remove_file(job / name));
  }
  BOOST_OUTCOME_TRYV(remove_file(job_record_file(job)));
  std::error_code foreign;
  fs::remove(job, foreign);  // fails, as it should, while it has files that are not ours
  return success();
}

void JobStore::log(const std::string& id, std::string_view line) const {
  const std::string text = time_text(std::chrono::system_clock::now()) + " " + as_utf8(line) + "\n";
  const auto written = append_line(job_log_file(folder(id)), text, false);
  static_cast<void>(written);  // see the header
}

Status JobStore::write_outcome(const std::string& id, std::string_view json) {
  return desk_.write(job_outcome_file(folder(id)), json);
}

}  // namespace tessera::service
