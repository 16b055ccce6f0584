// Changes of results as jobs: who may make them, what they wait for, and that an end of the service changes nothing.
#include "src/base/files/names.h"
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
