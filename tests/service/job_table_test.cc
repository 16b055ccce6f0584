#include "src/service/jobs/job_table.h"

#include <algorithm>
#include <fstream>

#include "src/base/files/names.h"
#include "src/service/jobs/job_status.h"
#include "tests/service/table_testing.h"

namespace tessera::service {
namespace {

using testing::alice;

class Table : public testing::TableTest {
 protected:
  std::shared_ptr<Job> job(const std::string& id) {
    const std::lock_guard lock(table->mutex);
    const auto found = table->find(id);
    EXPECT_TRUE(found) << id;
    return found ? found.value() : nullptr;
  }
  void set_state(const std::string& id, const char* state, JobTable::Need need = JobTable::Need::written) {
    const auto changed = job(id);
    const std::lock_guard changes(table->changing);
    const Status done = table->change(*changed, need, [&](proto::JobRecord& record) { record.set_state(state); });
    ASSERT_TRUE(done) << done.error().where;
  }
};

TEST_F(Table, KeepsJobsOverARestartAndTheirOrder) {
  std::vector<std::string> ids;
  for (const char* name : {"a", "b", "c"}) ids.push_back(accepted(name).id());
  set_state(ids[1], job_state::failed);
  open();
  EXPECT_EQ(job(ids[1])->record.state(), job_state::failed);
  std::vector<std::string> waiting;
  for (const auto& [place, id] : table->waiting) waiting.push_back(id);
  EXPECT_EQ(waiting, (std::vector<std::string>{ids[0], ids[2]}));
  EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end()));
  EXPECT_GT(accepted("d").id(), ids[2]);
}

TEST_F(Table, AJobThatRanWhenTheProcessDiedWaitsAgainUntilItDiesTooOften) {
  const auto id = accepted("a").id();
  for (std::uint32_t death = 1; death < limits.deaths; ++death) {
    set_state(id, job_state::running);
    open();
    EXPECT_TRUE(job(id)->is(job_state::accepted));
    EXPECT_EQ(job(id)->record.deaths(), death);
  }
  set_state(id, job_state::running);
  open();
  EXPECT_TRUE(job(id)->is(job_state::failed));
  EXPECT_NE(job(id)->record.problem().detail().find("died 3 times"), std::string::npos)
      << job(id)->record.problem().detail();
}

TEST_F(Table, DeathsAreForgivenToAJobThatGetsOn) {
  const auto id = accepted("a").id();
  set_state(id, job_state::running);
  open();
  set_state(id, job_state::running);
  job(id)->running = std::make_shared<Running>(Ledger::Bounds{});
  job(id)->running->progress.tiles_total = 100;
  job(id)->running->progress.tiles_stored = 40;
  const auto stored = [](const Progress& progress) -> std::uint64_t { return progress.tiles_stored; };
  table->forgive_deaths(stored);
  EXPECT_EQ(job(id)->record.deaths(), 0u);
  EXPECT_EQ(job(id)->record.reached(), 40u);
}

TEST_F(Table, AForgottenJobIsGoneForEver) {
  std::vector<std::string> dropped;
  hooks.drop = [&](const proto::JobRecord& record) -> Status {
    dropped.push_back(record.id());
    return success();
  };
  open();
  const auto id = accepted("a").id();
  set_state(id, job_state::failed);
  {
    const auto ended = job(id);
    const std::lock_guard changes(table->changing);
    table->active.erase(id);
    table->waiting.clear();
    ASSERT_TRUE(table->forget(ended));
  }
  EXPECT_EQ(dropped, std::vector<std::string>{id});
  for (int restart = 0; restart < 2; ++restart) {
    {
      const std::lock_guard lock(table->mutex);
      EXPECT_EQ(table->find(id).error().status(), 410);
      EXPECT_EQ(table->find("nothing").error().status(), 404);
    }
    open();
  }
}

TEST_F(Table, OnlySoManyEndedJobsOfACallerAreKept) {
  limits.ended_of_a_caller = 2;
  open();
  std::vector<std::string> ids;
  for (const char* name : {"a", "b", "c", "d"}) {
    ids.push_back(accepted(name).id());
    set_state(ids.back(), job_state::failed);
    const auto ended = job(ids.back());
    const std::lock_guard changes(table->changing);
    table->active.erase(ids.back());
    table->waiting.clear();
  }
  table->forget_beyond();
  EXPECT_EQ(table->jobs.size(), 2u);
  EXPECT_TRUE(table->jobs.contains(ids[3]));
  table->forget_ended_before(std::chrono::system_clock::now() + std::chrono::hours(1));
  EXPECT_EQ(table->jobs.size(), 0u);
}

TEST_F(Table, AChangeThatCannotBeWrittenIsWrittenLater) {
  const auto id = accepted("a").id();
  const auto record = jobs_folder(folder.path()) / id;
  const auto away = folder.path() / "away";
  std::filesystem::rename(record, away);
  {
    const auto changed = job(id);
    const std::lock_guard changes(table->changing);
    EXPECT_FALSE(table->change(*changed, JobTable::Need::written, [](proto::JobRecord& r) { r.set_points(7); }));
    EXPECT_EQ(changed->record.points(), 0u);
    EXPECT_TRUE(table->change(*changed, JobTable::Need::done, [](proto::JobRecord& r) { r.set_points(8); }));
    EXPECT_EQ(changed->record.points(), 8u);
  }
  EXPECT_EQ(table->unwritten, std::set<std::string>{id});
  std::filesystem::rename(away, record);
  table->write_again();
  EXPECT_TRUE(table->unwritten.empty());
  open();
  EXPECT_EQ(job(id)->record.points(), 8u);
}

TEST_F(Table, AJobWhoseRecordIsDamagedIsShownAndNotLost) {
  const auto id = accepted("a").id();
  for (const auto& entry : std::filesystem::directory_iterator(jobs_folder(folder.path()) / id))
    if (entry.path().filename() != "log") std::ofstream(entry.path()) << "no record";
  open();
  EXPECT_TRUE(job(id)->damaged);
  EXPECT_TRUE(job(id)->is(job_state::failed));
  EXPECT_FALSE(status_of(*job(id)).resumable());
  EXPECT_FALSE(warnings.empty());
}

}  // namespace
}  // namespace tessera::service
