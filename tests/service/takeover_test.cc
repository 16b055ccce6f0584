// A service whose data folder another one has taken: it hears of that, and whatever it still tries changes nothing.
#include <fstream>
#include <map>
#include <sstream>

#include "src/base/files/lock_owner.h"
#include "src/base/files/names.h"
#include "src/service/staging_folder.h"
#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

namespace fs = std::filesystem;

class Takeover : public ServiceTest {
 protected:
  // What a service on another machine does first of all.
  void take_over() {
    auto other = LockOwner::this_process();
    other.host = "node-7";
    other.boot = "00000000-0000-0000-0000-000000000000";
    const fs::path held = fs::directory_iterator(lock_folder(data()))->path();
    fs::rename(held, lock_folder(data()) / other.name());
    lay_desks();
  }
  void lay_desks() {
    for (const fs::path& area : {data(), results_folder(data()), uploads_folder(data())}) {
      auto desk = StagingFolder::lay(area, 1'000, [] { return success(); });
      ASSERT_TRUE(desk) << desk.error().where;
      desks.push_back(std::move(desk).value());
    }
  }
  // Every file of the data folder but locks and logs, with what is in it.
  std::map<std::string, std::string> all() const {
    std::map<std::string, std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(data())) {
      if (!entry.is_regular_file() || entry.path().filename() == "log.txt") continue;
      std::ostringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      found[entry.path().lexically_relative(data()).string()] = text.str();
    }
    return found;
  }
  void try_all(const std::string& done, const std::string& waits) {
    EXPECT_FALSE(service->processes().submit(triangulate("small.xyz", "another"), alice));
    EXPECT_FALSE(service->jobs().dismiss(waits, admin));
    EXPECT_FALSE(service->jobs().dismiss(done, admin));
    EXPECT_FALSE(service->results().remove("small", admin));
    EXPECT_FALSE(service->results().remove_export("small", "small.ply", admin));
    if (upload) {
      EXPECT_FALSE(upload->finish());
    }
  }

  std::vector<std::unique_ptr<StagingFolder>> desks;
  std::unique_ptr<Upload> upload;
};

proto::Inputs export_of(const std::string& name) {
  proto::Inputs inputs;
  inputs.mutable_export_()->set_triangulation(name);
  inputs.mutable_export_()->set_format("ply");
  inputs.mutable_export_()->set_output(name + ".ply");
  return inputs;
}

TEST_F(Takeover, WhatWasTakenIsLeftAsItIs) {
  make_cloud("small.xyz", 300);
  make_cloud("large.ply", 600'000);
  std::vector<std::string> told;
  std::mutex mutex;
  options.uploads = true;
  options.lost = [&](const Error& why) {
    const std::lock_guard lock(mutex);
    told.push_back(why.where);
  };
  open();
  EXPECT_FALSE(service->health().lost());
  const auto done = submit(triangulate("small.xyz", "small"));
  ASSERT_EQ(ended(done).status(), "successful");
  ASSERT_EQ(ended(submit(export_of("small"))).status(), "successful");
  const auto runs = submit(triangulate("large.ply", "large"));
  working(runs);
  const auto waits = submit(triangulate("small.xyz", "late"));
  auto sent = service->inputs().upload("d", "file.xyz", 0, alice);
  ASSERT_TRUE(sent && sent.value()->write("1 2 3\n"));
  upload = std::move(sent).value();

  take_over();
  const auto records = all();
  try_all(done, waits);
  EXPECT_TRUE(service->health().unready());
  EXPECT_TRUE(service->health().lost());
  upload.reset();
  service.reset();  // its running job stops, or ends, and cannot say so
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told.front().find("another process has taken the lock of the folder: process"), std::string::npos)
      << told.front();
  EXPECT_NE(told.front().find("on node-7"), std::string::npos) << told.front();
  const auto after = all();
  for (const auto& [name, content] : records) {
    if (name.starts_with("results/.unfinished-") || name.starts_with(".lock/")) continue;
    ASSERT_TRUE(after.contains(name)) << name;
    EXPECT_EQ(after.at(name), content) << name;
  }
  EXPECT_FALSE(after.contains("results/large/manifest.json"));
  EXPECT_FALSE(after.contains("results/another/manifest.json"));
  EXPECT_FALSE(after.contains("uploads/d/file.xyz"));
}

// Between a last look at the lock and the call that changes the folder a process may stand still for any time.
TEST_F(Takeover, WhatBelievesThatItHasTheLockChangesNothingEither) {
  make_cloud("small.xyz", 300);
  options.uploads = true;
  open();
  const auto done = submit(triangulate("small.xyz", "small"));
  ASSERT_EQ(ended(done).status(), "successful");
  ASSERT_EQ(ended(submit(export_of("small"))).status(), "successful");
  auto sent = service->inputs().upload("d", "file.xyz", 0, alice);
  ASSERT_TRUE(sent && sent.value()->write("1 2 3\n"));
  upload = std::move(sent).value();
  lay_desks();  // a successor's, and the lock looks as it did
  auto before = all();
  try_all(done, done);
  EXPECT_EQ(all(), before);
}

TEST_F(Takeover, RecordsTellWhichDaemonHasWrittenThem) {
  make_cloud("small.xyz", 300);
  open();
  const auto first = submit(triangulate("small.xyz", "first"));
  ASSERT_EQ(ended(first).status(), "successful");
  restart();
  const auto second = submit(triangulate("small.xyz", "second"));
  ASSERT_EQ(ended(second).status(), "successful");
  service.reset();
  const auto records = all();
  EXPECT_NE(records.at("jobs/" + first + "/job.json").find("\"term\":1"), std::string::npos);
  EXPECT_NE(records.at("jobs/" + second + "/job.json").find("\"term\":2"), std::string::npos);
  EXPECT_TRUE(fs::is_directory(terms_folder(data()) / "2"));
  for (const auto& [name, content] : records) EXPECT_EQ(name.find(".desk-"), std::string::npos) << name;
}

}  // namespace
}  // namespace tessera::service::testing
