// What a service does when its process died, and what it forgets.
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include "src/base/files/names.h"
#include "src/service/jobs/deaths.h"
#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

class Faults : public ServiceTest {
 protected:
  fs::path record(const std::string& id) const { return job_record_file(job_folder(data(), id)); }

  // On disk it is as if the process had been killed now: a service that ends says of its jobs that they wait. Returns
  // those that ran: on a busy machine a job may end before it could be killed.
  std::set<std::string> die() {
    std::map<std::string, std::string> before;
    std::set<std::string> ran;
    const auto listed = service->jobs().list({.limit = 1000}).value();
    for (const auto& job : listed.jobs()) {
      const auto text = before[job.id()] = content(record(job.id()));
      if (text.find("\"state\":\"running\"") != std::string::npos) ran.insert(job.id());
    }
    service.reset();
    for (const auto& [id, text] : before) std::ofstream(record(id)) << text;
    return ran;
  }
  static proto::Inputs triangulate_again(const std::string& input, const std::string& output) {
    auto inputs = triangulate(input, output);
    inputs.mutable_triangulate()->set_overwrite(true);
    return inputs;
  }
  void set_finished(const std::string& id, const std::string& time) {
    std::string text = content(record(id));
    const std::string key = "\"finished\":\"";
    const auto at = text.find(key);
    ASSERT_NE(at, std::string::npos) << text;
    text.replace(at + key.size(), text.find('"', at + key.size()) - at - key.size(), time);
    std::ofstream(record(id)) << text;
  }
};

TEST_F(Faults, AJobDuringWhichTheProcessDiesThriceHasFailedAndCanBeResumed) {
  make_cloud("large.ply", 400'000);
  make_cloud("small.xyz", 500);
  std::vector<std::string> told;
  options.log = [&](const std::string& line) { told.push_back(line); };
  open();
  auto deadly = submit(triangulate("large.ply", "deadly"));
  const auto neighbour = submit(triangulate("small.xyz", "neighbour"));
  for (int deaths = 0; deaths < 3;) {
    working(deadly);
    if (die().contains(deadly)) {
      ++deaths;
      open();
    } else {
      deaths = 0;
      open();
      deadly = submit(triangulate_again("large.ply", "deadly"));
    }
  }
  const auto failed = status(deadly);
  ASSERT_EQ(failed.status(), "failed") << failed.message();
  EXPECT_NE(failed.message().find("died 3 times"), std::string::npos) << failed.message();
  EXPECT_EQ(failed.problem().cause(), static_cast<int>(Errc::internal));
  EXPECT_TRUE(failed.resumable());
  EXPECT_EQ(failed.starts(), 3);
  ASSERT_EQ(told.size(), 1);
  EXPECT_NE(told[0].find(deadly), std::string::npos);
  EXPECT_EQ(ended(neighbour).status(), "successful");
  restart();
  EXPECT_EQ(status(deadly).status(), "failed");
  ASSERT_TRUE(service->jobs().resume(deadly, alice));
  EXPECT_EQ(ended(deadly).status(), "successful");
  EXPECT_EQ(service->results().info("deadly").value().vertices(), 400'000);
}

TEST(Deaths, AreForgivenToAJobThatGetsOnInSteps) {
  proto::JobRecord job;
  EXPECT_FALSE(gets_on(job, 500, 1000));  // it has never died
  job.set_deaths(2);
  EXPECT_FALSE(gets_on(job, 9, 1000));
  EXPECT_TRUE(gets_on(job, 10, 1000));
  job.set_deaths(0);
  job.set_reached(10);
  EXPECT_FALSE(gets_on(job, 19, 1000));
  EXPECT_TRUE(gets_on(job, 20, 1000));  // so the next attempt must get beyond that
  job.set_deaths(1);
  EXPECT_FALSE(gets_on(job, 10, 1000));
  EXPECT_FALSE(gets_on(job, 0, 0));
  EXPECT_TRUE(gets_on(job, 11, 7));
}

TEST_F(Faults, RestartsThatTheServiceSurvivesAreNoDeaths) {
  make_cloud("large.ply", 400'000);
  open();
  const auto id = submit(triangulate("large.ply", "block"));
  for (int i = 0; i < 2; ++i) {
    working(id);
    die();
    open();
    working(id);
    restart();
  }
  EXPECT_EQ(ended(id).status(), "successful");
}

TEST_F(Faults, AfterADeathJobsThatRanAreBegunAgainAloneSoThatNeighboursAreNotBlamed) {
  options.limits.running = 2;
  make_cloud("large.ply", 200'000);
  std::string first, second, third;
  int round = 0;
  do {
    service.reset();
    open();
    const auto n = std::to_string(round++);
    first = submit(triangulate("large.ply", "first" + n));
    second = submit(triangulate("large.ply", "second" + n));
    third = submit(triangulate("large.ply", "third" + n));
    working(first);
    working(second);
  } while (die() != std::set{first, second});
  open();
  for (const auto& id : {first, second, third}) EXPECT_EQ(ended(id).status(), "successful");
  // One that has died begins when no other runs, and none begins beside it.
  EXPECT_GE(status(second).started(), status(first).finished());
  EXPECT_GE(status(third).started(), status(second).finished());
}

// Accepted is accepted: nobody hears that there is no such job, and what it has made stays.
TEST_F(Faults, AJobWhoseRecordIsDamagedIsToldOfAndItsWorkIsKept) {
  make_cloud("a.xyz", 500);
  std::vector<std::string> told;
  options.log = [&](const std::string& line) { told.push_back(line); };
  options.retention_s = 1;
  open();
  const auto id = submit(triangulate("a.xyz", "a"));
  ASSERT_EQ(ended(id).status(), "successful");
  service.reset();
  const auto good = content(record(id));
  auto bogus = good;
  bogus.replace(bogus.find("successful"), 10, "bogus-like");
  const auto work = data() / "results" / (".unfinished-" + id) / "x";
  for (const auto& damaged :
       {std::string(), good.substr(0, good.size() / 2), bogus, std::string("{\"id\":\"other\"}")}) {
    std::ofstream(record(id)) << damaged;
    fs::create_directories(work.parent_path());
    std::ofstream(work) << "x";
    told.clear();
    open();
    const auto now = status(id);
    EXPECT_EQ(now.status(), "failed");
    EXPECT_FALSE(now.resumable());
    EXPECT_NE(now.message().find("is not the record of a job"), std::string::npos) << now.message();
    EXPECT_EQ(now.problem().cause(), static_cast<int>(Errc::corrupt));
    EXPECT_EQ(told.size(), 1u);
    EXPECT_FALSE(service->jobs().resume(id, admin));
    service.reset();
    EXPECT_EQ(content(record(id)), damaged);
    EXPECT_TRUE(fs::exists(work));
  }
  open();
  ASSERT_TRUE(service->jobs().dismiss(id, admin));  // an admin may forget it
  EXPECT_EQ(service->jobs().status(id).error().status(), 410);
  EXPECT_FALSE(fs::exists(work));
  restart();
  EXPECT_EQ(service->jobs().status(id).error().status(), 410);
}

// It is but a counter.
TEST_F(Faults, NumbersOfEventsThatAreDamagedStopNothingAndGoOnBeyondAllBefore) {
  make_cloud("a.xyz", 500);
  std::vector<std::string> told;
  options.log = [&](const std::string& line) { told.push_back(line); };
  open();
  service.reset();
  for (const char* damaged : {"", "garbage", "-1", "99999999999999999999999"}) {
    std::ofstream(event_numbers_file(data())) << damaged;
    told.clear();
    open();
    EXPECT_EQ(told.size(), 1u) << damaged;
    std::uint64_t number = 0;
    const auto handle = service->jobs().subscribe("", 0, [&](const auto& event) { number = event->id(); });
    ended(submit(triangulate("a.xyz")));
    service.reset();
    EXPECT_GT(number, 1'000'000'000'000u);
    EXPECT_LT(number, std::uint64_t{1} << 53);
  }
}

TEST_F(Faults, RetentionForgetsWhatEndedLongAgoAndNeverAResult) {
  make_cloud("a.xyz", 500);
  std::ofstream(inputs() / "bad.xyz") << "1 2 3\n4 5 6\n7 8 9\n1 2 nan\n";
  open();
  const auto old = submit(triangulate("a.xyz", "old"));
  const auto old_failed = submit(triangulate("bad.xyz", "bad"));
  const auto recent = submit(triangulate("a.xyz", "recent"));
  for (const auto& id : {old, old_failed, recent}) ended(id);
  service.reset();
  set_finished(old, "2001-01-01T00:00:00.000Z");
  set_finished(old_failed, "2001-01-01T00:00:00.000Z");
  std::ofstream(job_folder(data(), old) / "mine.txt") << "mine";

  open();  // off by default
  EXPECT_EQ(service->jobs().list({}).value().number_matched(), 3);
  service.reset();
  options.retention_s = 3600;
  open();
  while (service->jobs().status(old) || service->jobs().status(old_failed)) std::this_thread::yield();
  EXPECT_EQ(service->jobs().status(old).error().status(), 410);
  EXPECT_EQ(status(recent).status(), "successful");
  EXPECT_EQ(service->results().info("old").value().vertices(), 500);
  EXPECT_FALSE(fs::exists(record(old)));
  EXPECT_TRUE(fs::exists(job_folder(data(), old) / "mine.txt"));
  restart();
  EXPECT_EQ(service->jobs().status(old).error().status(), 410);
  EXPECT_TRUE(service->results().info("old"));
}

}  // namespace
}  // namespace tessera::service::testing
