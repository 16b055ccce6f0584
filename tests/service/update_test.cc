// Changes of results as jobs: who may make them, what they wait for, and that an end of the service changes nothing.
#include <algorithm>

#include "src/base/files/names.h"
#include "src/base/ledger.h"
#include "src/service/processes/disk_watch.h"
#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

class UpdateJobs : public ServiceTest {
 protected:
  void SetUp() override {
    make_cloud("cloud.ply", 4'000);
    make_cloud("more.ply", 500, 2);
    open();
    for (const char* name : {"hers", "same"}) {
      auto inputs = triangulate("cloud.ply", name);
      inputs.mutable_triangulate()->set_tiles(6);
      ASSERT_EQ(ended(submit(inputs)).status(), "successful");
    }
  }

  static proto::Inputs change(const std::string& name, std::uint64_t id) {
    proto::Inputs inputs;
    inputs.mutable_update()->set_triangulation(name);
    inputs.mutable_update()->add_remove_ids(id);
    return inputs;
  }
  proto::TriangulationInfo info(const std::string& name) { return service->results().info(name).value(); }
};

TEST_F(UpdateJobs, AreForTheOwnerAndAdminsAndTheOwnerStays) {
  const auto problem = refused(change("hers", 1), bob);
  EXPECT_EQ(problem.status(), 403);
  EXPECT_EQ(problem.detail(), "triangulation: only the owner of 'hers' or an admin may change it");
  EXPECT_EQ(ended(submit(change("hers", 1), admin)).status(), "successful");
  EXPECT_EQ(ended(submit(change("hers", 2), alice)).status(), "successful");
  EXPECT_EQ(info("hers").version(), 3U);
  EXPECT_EQ(info("hers").vertices(), info("same").vertices() - 2);
  EXPECT_EQ(refused(change("hers", 3), bob).status(), 403);
  // What another has made of it is his.
  auto copy = change("hers", 3);
  copy.mutable_update()->set_output("his");
  EXPECT_EQ(ended(submit(copy, bob)).status(), "successful");
  EXPECT_EQ(refused(change("his", 5), alice).status(), 403);
  EXPECT_EQ(ended(submit(change("his", 5), bob)).status(), "successful");
}

TEST_F(UpdateJobs, AreAloneOnTheirResult) {
  make_cloud("large.ply", 60'000);
  options.limits.running = 1;
  restart();
  const auto before = submit(triangulate("large.ply", "large"));  // for which the others wait
  const auto first = submit(change("hers", 1));
  const auto problem = refused(change("hers", 2));
  EXPECT_EQ(problem.status(), 409);
  EXPECT_EQ(problem.detail(), "triangulation 'hers': job " + first + " changes it; wait for that job to end");
  auto copy = change("hers", 3);
  copy.mutable_update()->set_output("next");
  EXPECT_EQ(refused(copy).status(), 409);
  EXPECT_EQ(service->results().remove("hers", alice).error().status(), 409);
  submit(verify("hers"));  // which reads
  copy.mutable_update()->set_triangulation("same");
  const auto second = submit(copy);
  EXPECT_EQ(service->results().remove("same", alice).error().status(), 409);  // which the job reads
  EXPECT_EQ(refused(change("same", 1)).status(), 409);
  EXPECT_EQ(ended(before).status(), "successful");
  EXPECT_EQ(ended(first).status(), "successful");
  EXPECT_EQ(ended(second).status(), "successful");
  EXPECT_EQ(info("next").vertices(), info("same").vertices() - 1);
}

TEST_F(UpdateJobs, GoOnAfterARestart) {
  const auto inputs = [](const char* name) {
    auto made = change(name, 7);
    made.mutable_update()->add_inputs("more.ply");
    return made;
  };
  ASSERT_EQ(ended(submit(inputs("same"))).status(), "successful");
  const auto job = submit(inputs("hers"));
  working(job);
  restart();
  EXPECT_EQ(ended(job).status(), "successful");
  EXPECT_EQ(info("hers").version(), 2U);  // not changed twice
  EXPECT_EQ(info("hers").digest(), info("same").digest());
  for (const auto& entry : std::filesystem::directory_iterator(results_folder(data()))) {
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(name.front() != '.' || name.starts_with(".desk-")) << entry.path();  // the desk is the service's own
  }
}

TEST_F(UpdateJobs, AreEstimatedBeforeTheyRun) {
  const auto estimated = [&](const proto::Inputs& inputs) {
    const auto told = service->processes().estimate(inputs, alice);
    EXPECT_TRUE(told) << (told ? "" : told.error().detail());
    return told ? told.value() : proto::Estimate();
  };
  const auto inner = estimated(change("hers", 1));
  EXPECT_TRUE(inner.accepted());
  EXPECT_EQ(inner.reason(), "");
  EXPECT_GE(inner.tiles(), 1U);
  EXPECT_LE(inner.tiles(), 6U);
  EXPECT_GT(inner.points(), 0U);
  EXPECT_LE(inner.points(), 4'000U);
  EXPECT_GT(inner.result_bytes(), 0U);
  EXPECT_GT(inner.seconds(), 0.0);
  EXPECT_GT(inner.memory_bytes(), 0U);
  auto dry = change("hers", 1);
  dry.mutable_update()->set_dry_run(true);
  EXPECT_EQ(estimated(dry).result_bytes(), 0U);

  proto::Inputs adding;
  adding.mutable_update()->set_triangulation("hers");
  adding.mutable_update()->add_inputs("more.ply");
  const auto everywhere = estimated(adding);  // the new points fill the same cube, so all tiles get some
  EXPECT_EQ(everywhere.points(), 4'500U);
  EXPECT_EQ(everywhere.tiles(), 6U);
  EXPECT_GT(everywhere.result_bytes(), inner.result_bytes());
  EXPECT_EQ(service->processes().estimate(adding, {"eve", Role::read}).error().status(), 403);  // it reads inputs

  auto corner = adding;
  corner.mutable_update()->clear_inputs();
  for (const double number : {0.0, 0.0, 0.0, 0.01, 0.01, 0.01}) corner.mutable_update()->add_remove_box(number);
  EXPECT_LE(estimated(corner).points(), 4'000U);
  auto of_input = adding;
  of_input.mutable_update()->clear_inputs();
  of_input.mutable_update()->add_remove_input("cloud.ply");
  const auto all = estimated(of_input);
  EXPECT_EQ(all.tiles(), 6U);
  EXPECT_NE(all.reason().find("the tiles are at most so many"), std::string::npos) << all.reason();
  EXPECT_TRUE(all.accepted());

  // What the job will tell, too.
  std::ofstream(inputs() / "bad.xyz") << "1 2 3\n4 5 6\n7 8 9\n1 2 nan\n";
  auto bad = adding;
  bad.mutable_update()->set_inputs(0, "bad.xyz");
  const auto unknown = estimated(bad);
  EXPECT_TRUE(unknown.accepted());
  EXPECT_NE(unknown.reason().find("bad.xyz"), std::string::npos) << unknown.reason();
  EXPECT_EQ(ended(submit(bad)).status(), "failed");
}

TEST_F(UpdateJobs, CountWhatTheyWrite) {
  std::uint64_t of_result = 0, of_tile = 0;
  for (const auto& entry : std::filesystem::directory_iterator(tiles_folder(data() / "results" / "hers"))) {
    of_result += entry.file_size();
    of_tile = std::max<std::uint64_t>(of_tile, entry.file_size());
  }
  options.limits.disk_bytes = of_tile / 4;
  options.limits.points = 400;
  restart();
  const auto problem = refused(change("hers", 1));
  EXPECT_EQ(problem.status(), 422);
  EXPECT_NE(problem.detail().find("the change needs at least"), std::string::npos) << problem.detail();
  EXPECT_NE(problem.detail().find("limits.disk"), std::string::npos) << problem.detail();
  proto::Inputs adding;
  adding.mutable_update()->set_triangulation("hers");
  adding.mutable_update()->add_inputs("more.ply");
  EXPECT_EQ(refused(adding).detail(), "inputs: hold 500 points; a job may have at most 400 here (limits.points)");
  // Which points are in the box is only found by the job.
  proto::Inputs box;
  box.mutable_update()->set_triangulation("hers");
  for (const double number : {0.4, 0.4, 0.4, 0.6, 0.6, 0.6}) box.mutable_update()->add_remove_box(number);
  const auto failed = ended(submit(box));
  EXPECT_EQ(failed.status(), "failed");
  EXPECT_NE(failed.message().find("limits.disk"), std::string::npos) << failed.message();
  EXPECT_EQ(info("hers").version(), 1U);
  for (const auto& entry : std::filesystem::directory_iterator(results_folder(data()))) {
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(name.front() != '.' || name.starts_with(".desk-")) << entry.path();
  }
  // Files that a new result shares with the old one are not written.
  options.limits.disk_bytes = of_result * 9 / 10;
  restart();
  auto copy = change("hers", 1);
  copy.mutable_update()->set_output("next");
  EXPECT_EQ(ended(submit(copy)).status(), "successful");
}

TEST(DiskWatch, DoesNotCountFilesThatHaveAnotherNameElsewhere) {
  const TemporaryFolder folder = temporary_folder();
  const auto old = folder.path() / "old", made = folder.path() / "made";
  std::filesystem::create_directories(old);
  std::filesystem::create_directories(made);
  std::ofstream(old / "shared") << std::string(200'000, 'a');
  std::filesystem::create_hard_link(old / "shared", made / "shared");
  std::ofstream(made / "own") << std::string(100'000, 'b');
  Ledger ledger;
  DiskWatch watch(made, ledger);
  ASSERT_TRUE(watch.finish());
  EXPECT_GE(ledger.written(), 100'000U);
  EXPECT_LT(ledger.written(), 200'000U);
}

TEST_F(UpdateJobs, TellTheirVersions) {
  auto keeping = change("hers", 1);
  keeping.mutable_update()->set_keep_versions(2);
  ASSERT_EQ(ended(submit(keeping)).status(), "successful");
  const auto told = service->results().versions("hers");
  ASSERT_TRUE(told) << told.error().detail();
  EXPECT_NE(told.value().find("\"keep_versions\":2"), std::string::npos) << told.value();
  EXPECT_EQ(service->results().versions("none").error().status(), 404);
  auto old = verify("hers");
  old.mutable_verify()->set_version(1);
  EXPECT_EQ(ended(submit(old)).status(), "successful");
  old.mutable_verify()->set_version(3);
  const auto problem = refused(old);
  EXPECT_EQ(problem.status(), 422);
  EXPECT_EQ(problem.detail(), "version: 'hers': version 3 does not exist; the versions 1 and 2 can be read");
}

}  // namespace
}  // namespace tessera::service::testing
