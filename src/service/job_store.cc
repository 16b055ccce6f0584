#include "src/service/job_store.h"

#include <fcntl.h>

#include <algorithm>
#include <chrono>
#include <span>
#include <system_error>

#include "src/files/descriptor.h"
#include "src/files/folder.h"
#include "src/files/names.h"
#include "src/files/there.h"
#include "src/files/whole_file.h"
#include "src/service/json.h"
#include "src/service/naming.h"

namespace tessera {
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

Result<std::vector<std::string>> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  FolderReader reader(folder);
  while (const char* name = reader.next()) names.emplace_back(name);
  if (reader.error()) return error(Errc::io, folder.string() + ": cannot be read: " + reader.error().message());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

JobStore::JobStore(fs::path data) : data_(std::move(data)), new_folders_(jobs_folder(data_)) {}

fs::path JobStore::folder(const std::string& id) const { return job_folder(data_, id); }

Result<std::set<std::string>> JobStore::read_forgotten() const {
  std::set<std::string> ids;
  BOOST_OUTCOME_TRY(there, is_there(forgotten_jobs_file(data_)));
  if (!there) return ids;
  BOOST_OUTCOME_TRY(bytes, read_whole(forgotten_jobs_file(data_)));
  auto text = as_text(bytes);
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    // A line that was cut short is no id: its job was not forgotten.
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
  if (!loaded.forgotten.empty()) loaded.last_id = *loaded.forgotten.rbegin();
  BOOST_OUTCOME_TRY(names, names_in(jobs_folder(data_)));
  for (const auto& name : names) {
    if (!JobIds::is_id(name)) continue;
    loaded.last_id = std::max(loaded.last_id, name);
    BOOST_OUTCOME_TRY(accepted, is_there(job_record_file(folder(name))));
    if (!accepted || loaded.forgotten.contains(name)) {
      if (const auto removed = remove_files(name); !removed) loaded.warnings.push_back(removed.error().where);
      continue;
    }
    // A disk that does not give it may give it to the next start; a job that is passed over is lost.
    BOOST_OUTCOME_TRY(bytes, read_whole(job_record_file(folder(name))));
    proto::JobRecord job;
    const auto read = from_json(as_text(bytes), job);
    if (!read || job.id() != name) {
      loaded.warnings.push_back(job_record_file(folder(name)).string() +
                                ": is not the record of a job, and is left alone" +
                                (read ? "" : ": " + read.error().where));
      continue;
    }
    loaded.jobs.push_back(std::move(job));
  }
  return loaded;
}

Status JobStore::add(const proto::JobRecord& job) {
  const auto made = [&]() -> Status {
    BOOST_OUTCOME_TRYV(make_directories(folder(job.id())));
    log(job.id(), "accepted");
    BOOST_OUTCOME_TRYV(write_whole(job_record_file(folder(job.id())), to_json(job)));
    return new_folders_.sync();
  }();
  if (made) return success();
  // The first error is the one to tell.
  if (const auto removed = remove_files(job.id()); !removed)
    return error(made.error().code, made.error().where + "; and " + removed.error().where);
  return made.error();
}

Status JobStore::replace(const proto::JobRecord& job) {
  return write_whole(job_record_file(folder(job.id())), to_json(job));
}

Status JobStore::forget(const std::string& id) {
  BOOST_OUTCOME_TRYV(append_line(forgotten_jobs_file(data_), id + "\n", true));
  return remove_files(id);
}

Status JobStore::remove_files(const std::string& id) const {
  const auto job = folder(id);
  BOOST_OUTCOME_TRY(there, is_there(job, FollowLinks::no));
  if (!there) return success();
  // The record last: what is left before has still a job to belong to, or is forgotten.
  BOOST_OUTCOME_TRY(names, names_in(job));
  for (const auto& name : names) {
    if (!is_job_name(name) || name == job_record_file("")) continue;
    BOOST_OUTCOME_TRYV(remove_file(job / name));
  }
  BOOST_OUTCOME_TRYV(remove_file(job_record_file(job)));
  std::error_code foreign;
  fs::remove(job, foreign);  // stays when somebody else's files are in it
  return success();
}

void JobStore::log(const std::string& id, std::string_view line) const {
  const std::string text = time_text(std::chrono::system_clock::now()) + " " + as_utf8(line) + "\n";
  const auto written = append_line(job_log_file(folder(id)), text, false);
  static_cast<void>(written);  // see the header
}

Status JobStore::write_outcome(const std::string& id, std::string_view json) const {
  return write_whole(job_outcome_file(folder(id)), json);
}

}  // namespace tessera
