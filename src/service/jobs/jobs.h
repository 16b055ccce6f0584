// Answers requests about accepted jobs.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "src/service/jobs/admission.h"
#include "src/service/jobs/job_table.h"
#include "src/service/jobs/jobs_backend.h"
#include "src/service/results/result_folders.h"

namespace tessera::service {

class Jobs final : public JobsBackend {
 public:
  Jobs(JobTable& table, Admission& admission, ResultFolders& folders)
      : table_(table), admission_(admission), folders_(folders) {}

  Reply<proto::JobList> list(const JobQuery& query) override;
  Reply<proto::StatusInfo> status(std::string_view id) override;
  Reply<proto::StatusInfo> dismiss(std::string_view id, const Caller& caller) override;
  Reply<proto::StatusInfo> resume(std::string_view id, const Caller& caller) override;
  Reply<ServedFile> log(std::string_view id) override;
  Reply<ServedFile> report(std::string_view id) override;
  Reply<proto::JobTiles> tiles(std::string_view id, bool with_layout) override;
  Reply<std::string> outcome(std::string_view id) override;
  Reply<std::unique_ptr<Subscription>> subscribe(std::string_view id, std::uint64_t last, OnEvent on_event) override;

 private:
  // Whether the triangulation `name` is still the one that the job made; 410 when it is not.
  Reply<void> still_made_by(std::string_view id, const std::string& name);

  JobTable& table_;
  Admission& admission_;
  ResultFolders& folders_;
};

}  // namespace tessera::service
