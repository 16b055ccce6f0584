#include <algorithm>
#include <map>
#include <set>

#include "src/base/files/names.h"
#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

using Jobs = ServiceTest;

TEST_F(Jobs, AFolderOfANewerVersionIsRefusedAndLeftAlone) {
  open();
  service.reset();
  const auto format = data() / "format";
  const auto content = [&] {
    std::ifstream file(format);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  EXPECT_EQ(content(), "1\n");
  for (const std::string noted : {"2\n", "x", ""}) {
    std::ofstream(format) << noted;
    const auto refused = Service::open(options);
    ASSERT_FALSE(refused) << noted;
    EXPECT_EQ(refused.error().code, Errc::corrupt);
    EXPECT_NE(refused.error().where.find(noted == "2\n" ? "newer version" : "damaged"), std::string::npos);
    EXPECT_EQ(content(), noted);
  }
  std::filesystem::remove(format);  // of a version that noted none
  open();
  EXPECT_EQ(content(), "1\n");
}

TEST_F(Jobs, ATriangulationIsMadeProvedExportedAndDescribed) {
  make_cloud("a.xyz", 2000);
  open();
  const auto made = ended(submit(triangulate("a.xyz", "block")));
  ASSERT_EQ(made.status(), "successful") << made.message();
  EXPECT_EQ(made.progress(), 100);
  EXPECT_EQ(made.points(), 2000);
  const auto info = service->results().info("block");
  ASSERT_TRUE(info) << info.error().detail();
  EXPECT_EQ(info.value().vertices(), 2000);
  EXPECT_EQ(info.value().digest().size(), 32);
  EXPECT_EQ(ended(submit(verify("block"))).status(), "successful");
  proto::Inputs exported;
  exported.mutable_export_()->set_triangulation("block");
  exported.mutable_export_()->set_output("mesh.ply");
  const auto ply = ended(submit(exported));
  ASSERT_EQ(ply.status(), "successful") << ply.message();
  EXPECT_NE(service->jobs().outcome(ply.id()).value().find("\"mesh.ply\""), std::string::npos);
  EXPECT_TRUE(service->results().file("block", "exports/mesh.ply"));
  EXPECT_EQ(refused(exported).status(), 409);
  exported.mutable_export_()->set_overwrite(true);
  EXPECT_EQ(ended(submit(exported)).status(), "successful");
  EXPECT_NE(service->jobs().outcome(ply.id()).value().find("\"written\":[{\"path\":\"exports/mesh.ply\""),
            std::string::npos);
  EXPECT_EQ(service->results().remove_export("block", "mesh.ply", bob).error().status(), 403);
  EXPECT_EQ(service->results().remove_export("block", "..", alice).error().status(), 404);
  ASSERT_TRUE(service->results().remove_export("block", "mesh.ply", alice));
  EXPECT_EQ(service->results().remove_export("block", "mesh.ply", alice).error().status(), 404);
  EXPECT_EQ(service->results().file("block", "exports/mesh.ply").error().status(), 404);
  proto::InfoInputs question;
  question.add_inputs("a.xyz");
  question.set_stats(true);
  const auto told = service->processes().info(question, alice);
  ASSERT_TRUE(told) << told.error().detail();
  EXPECT_NE(told.value().find("\"points\":"), std::string::npos);
  EXPECT_NE(service->jobs().outcome(made.id()).value().find("\"event\":\"summary\""), std::string::npos);
}

TEST_F(Jobs, HeightsAreCopiesOfFilesBesideTheGround) {
  make_cloud("a.las", 500);
  make_cloud("b.las", 500, 2);
  open();
  auto ground = triangulate("a.las", "ground");
  ground.mutable_triangulate()->set_dim(2);
  ASSERT_EQ(ended(submit(ground)).status(), "successful");
  proto::Inputs heights;
  auto& asked = *heights.mutable_hag();
  asked.add_inputs("*.la?");
  asked.set_triangulation("ground");
  asked.set_output("heights.las");
  EXPECT_EQ(refused(heights).detail(),
            "output: 'heights.las' must have no ending, because it becomes a folder of files");
  asked.clear_output();
  const auto made = ended(submit(heights));
  ASSERT_EQ(made.status(), "successful") << made.message();
  const auto outcome = service->jobs().outcome(made.job_id()).value();
  EXPECT_NE(outcome.find(R"("input":"a.las","output":"a.las","points":500,"outside":0)"), std::string::npos) << outcome;
  EXPECT_NE(outcome.find(R"("input":"b.las","output":"b.las","points":500)"), std::string::npos) << outcome;
  for (const char* file : {"exports/heights/a.las", "exports/heights/b.las"})
    EXPECT_TRUE(service->results().file("ground", file)) << file;
  EXPECT_EQ(refused(heights).status(), 409);
  asked.set_overwrite(true);
  asked.set_format("laz");
  ASSERT_EQ(ended(submit(heights)).status(), "successful");
  EXPECT_FALSE(service->results().file("ground", "exports/heights/a.las")) << "the folder is replaced";
  // The surface must have heights over a plane, and the files must be LAS.
  ASSERT_EQ(ended(submit(triangulate("a.las", "solid"))).status(), "successful");
  asked.set_triangulation("solid");
  EXPECT_NE(refused(heights).detail().find("'solid' is a 3D result"), std::string::npos);
  make_cloud("c.ply", 500);
  asked.set_triangulation("ground");
  asked.set_output("others");
  asked.add_inputs("c.ply");
  const auto failed = ended(submit(heights));
  EXPECT_EQ(failed.status(), "failed");
  EXPECT_NE(failed.message().find("c.ply: is not LAS or LAZ"), std::string::npos) << failed.message();
  EXPECT_FALSE(std::filesystem::exists(data() / "results" / "ground" / "exports" / "others"));
}

TEST_F(Jobs, MeasuresAreANewVersionOfTheResult) {
  make_cloud("a.xyz", 2000);
  open();
  ASSERT_EQ(ended(submit(triangulate("a.xyz", "block"))).status(), "successful");
  const auto before = service->questions().identity("block").value();
  proto::Inputs measured;
  measured.mutable_measure()->set_triangulation("block");
  EXPECT_NE(refused(measured).detail().find("there is nothing to measure"), std::string::npos);
  measured.mutable_measure()->set_volume(true);
  const auto made = ended(submit(measured));
  ASSERT_EQ(made.status(), "successful") << made.message();
  const auto outcome = service->jobs().outcome(made.job_id()).value();
  EXPECT_NE(outcome.find(R"("output":"block","version":2,"made":true,"columns":["volume","star_volume"])"),
            std::string::npos)
      << outcome;
  EXPECT_NE(service->questions().identity("block").value(), before);
  EXPECT_EQ(ended(submit(verify("block"))).status(), "successful");
  const auto again = ended(submit(measured));
  EXPECT_NE(service->jobs().outcome(again.job_id()).value().find(R"("made":false)"), std::string::npos);
  measured.mutable_measure()->set_mass("intensity");
  EXPECT_EQ(refused(measured).detail(), "mass: has no effect without density: true");
  measured.mutable_measure()->clear_mass();
  measured.mutable_measure()->set_density(true);
  const auto densities = ended(submit(measured));
  ASSERT_EQ(densities.status(), "successful") << densities.message();
  EXPECT_NE(service->jobs().outcome(densities.job_id()).value().find(R"(["volume","star_volume","density"])"),
            std::string::npos);
  measured.mutable_measure()->set_mass("weight");
  EXPECT_NE(ended(submit(measured)).message().find("no attribute 'weight'"), std::string::npos);
  restart();
  EXPECT_TRUE(service->results().info("block"));
  measured.mutable_measure()->clear_mass();
  measured.mutable_measure()->set_triangulation("missing");
  EXPECT_EQ(refused(measured).status(), 422);
}

TEST_F(Jobs, AFailedJobTellsWhyHarmsNoOtherAndLeavesNothing) {
  options.limits.running = 2;
  make_cloud("a.xyz", 3000);
  std::ofstream(inputs() / "bad.xyz") << "1 2 3\n4 5 6\n7 8 9\n1 2 nan\n";
  open();
  std::vector<std::string> good, bad;
  for (int i = 0; i < 4; ++i) {
    good.push_back(submit(triangulate("a.xyz", "good" + std::to_string(i))));
    bad.push_back(submit(triangulate("bad.xyz", "bad" + std::to_string(i))));
  }
  for (const auto& id : good) EXPECT_EQ(ended(id).status(), "successful");
  for (const auto& id : bad) {
    const auto failed = ended(id);
    EXPECT_EQ(failed.status(), "failed");
    EXPECT_EQ(failed.problem().cause(), 3);
    EXPECT_EQ(failed.problem().status(), 422);
    EXPECT_NE(failed.message().find("skip_invalid"), std::string::npos) << failed.message();
    EXPECT_EQ(service->jobs().outcome(id).error().status(), 422);
  }
  service.reset();
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(data() / "results"))
    names.insert(entry.path().filename());
  EXPECT_EQ(names, (std::set<std::string>{"good0", "good1", "good2", "good3"}));
}

TEST_F(Jobs, OneKeyIsOneJobAlsoAfterARestart) {
  make_cloud("a.xyz", 500);
  open();
  const auto id = submit(triangulate("a.xyz"), alice, "once");
  const auto again = service->processes().submit(triangulate("a.xyz"), alice, "once");
  ASSERT_TRUE(again);
  EXPECT_FALSE(again.value().fresh);
  EXPECT_EQ(again.value().status.id(), id);
  restart();
  EXPECT_EQ(submit(triangulate("a.xyz"), alice, "once"), id);
  EXPECT_EQ(refused(triangulate("a.xyz", "other"), alice, "once").status(), 422);
  EXPECT_NE(submit(triangulate("a.xyz"), bob, "once"), id);
}

TEST_F(Jobs, QueuedRunningAndEndedJobsGoOnAfterARestartInTheirOrder) {
  make_cloud("small.xyz", 500);
  make_cloud("large.ply", 300'000);
  open();
  const auto first = submit(triangulate("small.xyz", "first"));
  EXPECT_EQ(ended(first).status(), "successful");
  const auto running = submit(triangulate("large.ply", "running"));
  const auto second = submit(triangulate("small.xyz", "second"));
  const auto third = submit(triangulate("small.xyz", "third"));
  working(running);
  service.reset();
  std::ifstream record(job_record_file(job_folder(data(), running)));
  const std::string left(std::istreambuf_iterator<char>(record), {});
  const bool goes_on = left.find("\"state\":\"accepted\"") != std::string::npos;  // or it has ended in time
  open();
  EXPECT_EQ(status(first).status(), "successful");
  EXPECT_EQ(status(first).starts(), 1);
  for (const auto& id : {running, second, third}) EXPECT_EQ(ended(id).status(), "successful");
  EXPECT_EQ(status(running).starts(), goes_on ? 2 : 1);
  EXPECT_LE(status(running).started(), status(second).started());
  EXPECT_LE(status(second).started(), status(third).started());
  EXPECT_EQ(service->results().list(10, "").value().number_matched(), 4);
}

TEST_F(Jobs, ADismissedJobStopsAndCanGoOn) {
  make_cloud("large.ply", 400'000);
  open();
  std::string id, name;
  proto::StatusInfo dismissed;
  do {
    name += "block";
    id = submit(triangulate("large.ply", name));
    wait(id, [](const auto& now) { return now.phase() == "triangulating" || now.status() == "successful"; });
    EXPECT_EQ(service->jobs().dismiss(id, bob).error().status(), 403);
    const auto answer = service->jobs().dismiss(id, alice);
    ASSERT_TRUE(answer) << answer.error().detail();
    dismissed = answer.value();
  } while (dismissed.status() == "successful");  // it had ended, and is forgotten
  EXPECT_EQ(dismissed.status(), "dismissed");
  EXPECT_TRUE(dismissed.resumable());
  EXPECT_EQ(service->jobs().outcome(id).error().status(), 410);
  EXPECT_FALSE(service->results().info(name));
  ASSERT_TRUE(service->jobs().resume(id, alice));
  EXPECT_EQ(ended(id).status(), "successful");
  EXPECT_EQ(service->results().info(name).value().vertices(), 400'000);
  EXPECT_EQ(service->jobs().resume(id, alice).error().status(), 409);
}

TEST_F(Jobs, AWaitingJobThatIsDismissedNeverRunsAndOneThatEndedIsForgottenForGood) {
  make_cloud("large.ply", 200'000);
  make_cloud("small.xyz", 500);
  open();
  std::string running, waiting;
  int rounds = 0;
  while (true) {
    running = submit(triangulate("large.ply"));
    waiting = submit(triangulate("small.xyz", "waiting" + std::to_string(rounds++)));
    const auto dismissed = service->jobs().dismiss(waiting, alice);
    ASSERT_TRUE(dismissed) << dismissed.error().detail();
    if (dismissed.value().starts() == 0) break;  // or it has begun, or ended and is forgotten
  }
  EXPECT_EQ(ended(running).status(), "successful");
  EXPECT_EQ(status(waiting).starts(), 0);
  ASSERT_TRUE(service->jobs().dismiss(waiting, alice));
  EXPECT_EQ(service->jobs().status(waiting).error().status(), 410);
  restart();
  EXPECT_EQ(service->jobs().status(waiting).error().status(), 410);
  EXPECT_EQ(service->jobs().status("nothing").error().status(), 404);
  EXPECT_FALSE(std::filesystem::exists(data() / "jobs" / waiting));
  // The result of a job that is forgotten stays.
  ASSERT_TRUE(service->jobs().dismiss(running, alice));
  EXPECT_TRUE(service->results().info(running));
}

TEST_F(Jobs, AResultIsReplacedOnlyWhenAskedForAndWhenTheNewOneIsWhole) {
  make_cloud("a.xyz", 500);
  make_cloud("b.xyz", 600);
  std::ofstream(inputs() / "bad.xyz") << "1 2 3\n4 5 nan\n";
  open();
  ended(submit(triangulate("a.xyz", "block")));
  EXPECT_EQ(refused(triangulate("b.xyz", "block")).status(), 409);
  auto replacing = triangulate("bad.xyz", "block");
  replacing.mutable_triangulate()->set_overwrite(true);
  EXPECT_EQ(ended(submit(replacing)).status(), "failed");
  EXPECT_EQ(service->results().info("block").value().vertices(), 500);
  *replacing.mutable_triangulate()->mutable_inputs(0) = "b.xyz";
  EXPECT_EQ(ended(submit(replacing)).status(), "successful");
  EXPECT_EQ(service->results().info("block").value().vertices(), 600);
  EXPECT_EQ(service->results().remove("block", bob).error().status(), 403);
  ASSERT_TRUE(service->results().remove("block", alice));
  EXPECT_EQ(service->results().info("block").error().status(), 404);
  service.reset();  // what was replaced is removed after its job has ended
  EXPECT_TRUE(std::filesystem::is_empty(data() / "results"));
}

TEST_F(Jobs, WhatCostsTooMuchIsRefusedAtOnceWithTheFigures) {
  make_cloud("a.xyz", 5000);
  options.limits.points = 1000;
  open();
  const auto points = refused(triangulate("a.xyz"));
  EXPECT_EQ(points.status(), 422);
  EXPECT_NE(points.detail().find("a job may have at most 1 000"), std::string::npos) << points.detail();
  const auto estimate = service->processes().estimate(triangulate("a.xyz"), alice);
  ASSERT_TRUE(estimate);
  EXPECT_FALSE(estimate.value().accepted());
  options.limits.points = 0;
  options.limits.disk_bytes = 1000;
  service.reset();
  open();
  EXPECT_EQ(refused(triangulate("a.xyz")).status(), 422);
  options.limits.disk_bytes = 0;
  options.limits.jobs_of_a_caller = 0;
  service.reset();
  open();
  EXPECT_EQ(refused(triangulate("a.xyz")).status(), 429);
  EXPECT_EQ(refused(triangulate("a.xyz"), {"eve", Role::read}).status(), 403);
}

TEST_F(Jobs, ListsComeInPagesNewestFirst) {
  make_cloud("a.xyz", 100);
  open();
  std::vector<std::string> ids;
  for (int i = 0; i < 7; ++i) ids.push_back(submit(triangulate("a.xyz")));
  std::reverse(ids.begin(), ids.end());
  std::vector<std::string> listed;
  JobQuery query{.limit = 3};
  while (true) {
    const auto page = service->jobs().list(query).value();
    EXPECT_EQ(page.number_matched(), 7);
    if (page.jobs_size() == 0) break;
    for (const auto& job : page.jobs()) listed.push_back(job.id());
    query.after = listed.back();
  }
  EXPECT_EQ(listed, ids);
  EXPECT_EQ(service->jobs().list({.processes = {"verify"}}).value().number_matched(), 0);
}

TEST_F(Jobs, EventsAscendOverRestartsAndAreReplayed) {
  make_cloud("a.xyz", 500);
  open();
  const auto id = submit(triangulate("a.xyz"));
  ended(id);
  const auto events_after = [&](std::uint64_t last, std::size_t wanted) {
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<proto::Event> events;
    const auto handle = service->jobs().subscribe(id, last, [&](const auto& event) {
      const std::lock_guard lock(mutex);
      events.push_back(*event);
      changed.notify_all();
    });
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return events.size() >= wanted; });
    return events;
  };
  const auto all = events_after(1, 3);  // 1 was its acceptance
  for (std::size_t i = 1; i < all.size(); ++i) EXPECT_LT(all[i - 1].id(), all[i].id());
  restart();
  // What is not kept is replaced by the status of the job.
  const auto replaced = events_after(all.back().id(), 1);
  EXPECT_EQ(replaced.front().status().status(), "successful");
  EXPECT_GT(replaced.front().id(), all.back().id());
  EXPECT_FALSE(service->jobs().subscribe("nothing", 0, [](const auto&) {}));
}

TEST_F(Jobs, WhoHearsOfItsEndHasHeardTheWholeLog) {
  make_cloud("a.xyz", 500);
  open();
  const auto id = submit(triangulate("a.xyz"));
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::string> lines;
  bool is_over = false;
  const auto handle = service->jobs().subscribe(id, 1, [&](const auto& event) {
    const std::lock_guard lock(mutex);
    if (is_over) return;
    if (event->kind() == "log") lines.push_back(event->text());
    is_over = event->status().status() == "successful";
    changed.notify_all();
  });
  std::unique_lock lock(mutex);
  changed.wait(lock, [&] { return is_over; });
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.back(), "successful");
}

TEST_F(Jobs, ASecondServiceHasNoPlaceInTheFolder) {
  open();
  const auto second = Service::open(options);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::io);  // to be tried again, unlike what is wrong with options
  EXPECT_NE(second.error().where.find("another tessera is at work in it: process "), std::string::npos);
}

TEST_F(Jobs, WhatIsNotOursInTheDataFolderStays) {
  const std::vector<std::string> foreign{"jobs/mine/x.txt",
                                         "jobs/job.json",
                                         "results/mine/x.txt",
                                         "x.txt",
                                         "results/.unfinished-mine/x.txt",
                                         "jobs/0193e1f0a2b4-0001-9f3a2b1c/x.txt"};
  for (const auto& file : foreign) {
    std::filesystem::create_directories((data() / file).parent_path());
    std::ofstream(data() / file) << "mine";
  }
  std::filesystem::create_directories(data() / "jobs/0193e1f0a2b4-0002-9f3a2b1c");
  std::ofstream(data() / "jobs/0193e1f0a2b4-0002-9f3a2b1c/job.json") << "{\"id\": \"cut";
  make_cloud("a.xyz", 500);
  open();
  ended(submit(triangulate("a.xyz", "a")));
  EXPECT_EQ(service->jobs().list({}).value().number_matched(), 2);
  ASSERT_TRUE(service->results().remove("a", admin));
  EXPECT_EQ(service->results().remove("mine", admin).error().status(), 404);
  restart();
  for (const auto& file : foreign) EXPECT_TRUE(std::filesystem::exists(data() / file)) << file;
  EXPECT_TRUE(std::filesystem::exists(data() / "jobs/0193e1f0a2b4-0002-9f3a2b1c/job.json"));
}

TEST_F(Jobs, WhereNoStateCanBeWrittenNothingIsAccepted) {
  make_cloud("a.xyz", 100);
  open();
  EXPECT_FALSE(service->health().unready());
  std::filesystem::remove_all(data() / "jobs");
  std::ofstream(data() / "jobs") << "a file";
  EXPECT_EQ(refused(triangulate("a.xyz")).status(), 500);
  EXPECT_EQ(service->jobs().list({}).value().number_matched(), 0);
}

}  // namespace
}  // namespace tessera::service::testing
