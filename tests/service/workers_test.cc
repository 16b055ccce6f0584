#include "src/service/jobs/workers.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <stdexcept>

#include "src/service/jobs/jobs.h"
#include "src/service/problem.h"
#include "tests/service/table_testing.h"

namespace tessera::service {
namespace {

class Work : public testing::TableTest {
 protected:
  // Until the job is in this state, by its events.
  void wait_for(const std::string& id, const std::string& state) {
    Jobs jobs(*table, *admission, *folders);
    std::mutex mutex;
    std::condition_variable changed;
    bool reached = false;
    const auto handle = jobs.subscribe(id, 0, [&](const auto& event) {
      const std::lock_guard lock(mutex);
      reached = reached || event->status().status() == state;
      changed.notify_all();
    });
    ASSERT_TRUE(handle);
    std::unique_lock lock(mutex);
    reached = reached || jobs.status(id).value().status() == state;
    changed.wait(lock, [&] { return reached; });
  }
  proto::StatusInfo status(const std::string& id) { return Jobs(*table, *admission, *folders).status(id).value(); }
};

TEST_F(Work, JobsAreDoneInTheirOrderAndPublished) {
  std::vector<std::string> ids, worked, published;
  for (const char* name : {"a", "b", "c"}) ids.push_back(accepted(name).id());
  {
    const Workers workers(*table,
                          {.work = [&](const JobWork& work) -> Reply<JobDone> {
                             worked.push_back(work.job.id());
                             work.log("at work");
                             return JobDone{"{}", 7, {{"read", 0.5}}};
                           },
                           .publish = [&](const proto::JobRecord& job) -> Reply<std::filesystem::path> {
                             published.push_back(job.id());
                             return std::filesystem::path();
                           }},
                          1);
    for (const auto& id : ids) wait_for(id, job_state::successful);
  }
  EXPECT_EQ(worked, ids);
  EXPECT_EQ(published, ids);
  EXPECT_EQ(table->since_start.successful, 3u);
  EXPECT_EQ(table->since_start.points, 21u);
  EXPECT_EQ(table->phase_seconds.at("read"), 1.5);
  EXPECT_EQ(Jobs(*table, *admission, *folders).outcome(ids[0]).value(), "{}");
}

TEST_F(Work, AnExceptionEndsItsJobAlone) {
  const auto bad = accepted("a").id(), good = accepted("b").id();
  const Workers workers(*table, {.work = [&](const JobWork& work) -> Reply<JobDone> {
    if (work.job.id() == bad) throw std::runtime_error("a pipe burst");
    return JobDone{};
  }},
                        1);
  wait_for(bad, job_state::failed);
  wait_for(good, job_state::successful);
  EXPECT_EQ(status(bad).problem().status(), 500);
  EXPECT_NE(status(bad).message().find("a pipe burst"), std::string::npos);
}

TEST_F(Work, TheEndInterruptsAJobWhichThenWaits) {
  const auto id = accepted("a").id();
  {
    const Workers workers(*table, {.work = [&](const JobWork& work) -> Reply<JobDone> {
      std::mutex mutex;
      std::condition_variable_any stopped;
      std::unique_lock lock(mutex);
      const auto token = work.ledger.token();
      stopped.wait(lock, token, [] { return false; });
      return problem(410, "interrupted", Errc::interrupted);
    }},
                          1);
    wait_for(id, job_state::running);
  }
  EXPECT_EQ(status(id).status(), job_state::accepted);
  open();
  EXPECT_EQ(table->waiting.size(), 1u);
}

TEST_F(Work, AJobThatDiedBeforeRunsAlone) {
  const auto died = accepted("a").id(), other = accepted("b").id();
  table->jobs.at(died)->record.set_deaths(1);
  std::atomic<int> at_once{0}, most{0};
  const Workers workers(*table, {.work = [&](const JobWork&) -> Reply<JobDone> {
    most = std::max(most.load(), ++at_once);
    std::this_thread::yield();
    --at_once;
    return JobDone{};
  }},
                        4);
  wait_for(died, job_state::successful);
  wait_for(other, job_state::successful);
  EXPECT_EQ(most, 1);
}

TEST_F(Work, WhatCannotBePublishedHasFailed) {
  const auto id = accepted("a").id();
  const Workers workers(*table,
                        {.work = [](const JobWork&) -> Reply<JobDone> { return JobDone{}; },
                         .publish = [](const proto::JobRecord&) -> Reply<std::filesystem::path> {
                           return problem(507, "the disk is full", Errc::io);
                         }},
                        1);
  wait_for(id, job_state::failed);
  EXPECT_EQ(status(id).problem().status(), 507);
}

}  // namespace
}  // namespace tessera::service
