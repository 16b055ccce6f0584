// A table of jobs without a service around it, for tests.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "src/service/jobs/admission.h"
#include "src/service/jobs/events.h"
#include "src/service/jobs/job_table.h"
#include "src/service/results/result_folders.h"
#include "tests/service/service_testing.h"

namespace tessera::service::testing {

class TableTest : public ::testing::Test {
 protected:
  TableTest() {
    hooks.warn = [this](const std::string& line) { warnings.push_back(line); };
    open();
  }

  // Opens the folder again, as the next process does.
  void open() {
    admission.reset();
    table.reset();
    folders.reset();
    events.reset();
    staging.reset();
    staging = StagingFolder::lay(folder.path(), ++term, [] { return success(); }).value();
    events = Events::open(folder.path() / "numbers", *staging, {}).value();
    folders = std::make_unique<ResultFolders>(folder.path(), *staging);
    table = std::make_unique<JobTable>(folder.path(), *staging, *events, limits, hooks);
    const auto known = table->load();
    ASSERT_TRUE(known) << known.error().where;
    ASSERT_TRUE(folders->open(known.value()));
    admission = std::make_unique<Admission>(*table, *folders);
  }

  static proto::JobRecord record_of(const std::string& output, const Caller& caller, const std::string& key = "") {
    proto::JobRecord record;
    record.mutable_inputs()->mutable_triangulate()->add_inputs("a.xyz");
    record.mutable_inputs()->mutable_triangulate()->set_output(output);
    record.set_triangulation(output);
    record.set_caller(caller.name);
    record.set_idempotency_key(key);
    return record;
  }
  Reply<Submitted> accept(const std::string& output, const Caller& caller = alice, const std::string& key = "") {
    return admission->accept(record_of(output, caller, key), caller, "");
  }
  proto::StatusInfo accepted(const std::string& output, const Caller& caller = alice) {
    const auto made = accept(output, caller);
    if (!made) ADD_FAILURE() << made.error().detail();
    return made ? made.value().status : proto::StatusInfo();
  }

  const TemporaryFolder folder = temporary_folder();
  std::uint64_t term = 0;
  ServiceLimits limits;
  JobTableHooks hooks;
  std::vector<std::string> warnings;
  std::unique_ptr<StagingFolder> staging;
  std::unique_ptr<Events> events;
  std::unique_ptr<ResultFolders> folders;
  std::unique_ptr<JobTable> table;
  std::unique_ptr<Admission> admission;
};

}  // namespace tessera::service::testing
