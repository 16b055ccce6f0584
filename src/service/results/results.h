// Answers requests about results and their exports.
#pragma once

#include <string>
#include <string_view>

#include "src/service/caller.h"
#include "src/service/jobs/admission.h"
#include "src/service/jobs/job_table.h"
#include "src/service/jobs/jobs_backend.h"
#include "src/service/questions/questions.h"
#include "src/service/results/result_folders.h"
#include "src/service/results/results_backend.h"

namespace tessera::service {

class Results final : public ResultsBackend {
 public:
  // The jobs tell who works on a result, and what they have made.
  Results(ResultFolders& folders, JobTable& table, JobsBackend& jobs, Admission& admission, Questions& questions)
      : folders_(folders), table_(table), jobs_(jobs), admission_(admission), questions_(questions) {}

  Reply<proto::TriangulationList> list(std::uint32_t limit, std::string_view after) override;
  Reply<proto::TriangulationInfo> info(std::string_view name) override;
  Reply<std::string> versions(std::string_view name) override;
  Reply<ServedFile> file(std::string_view name, std::string_view path) override;
  Reply<void> remove(std::string_view name, const Caller& caller) override;
  Reply<proto::ExportList> exports(std::string_view name, std::uint32_t limit, std::string_view after) override;
  Reply<void> remove_export(std::string_view name, std::string_view file, const Caller& caller) override;

 private:
  ResultFolders& folders_;
  JobTable& table_;
  JobsBackend& jobs_;
  Admission& admission_;
  Questions& questions_;
};

}  // namespace tessera::service
