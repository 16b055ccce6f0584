// What callers may ask for at once, and what of it is kept.
#include <zlib.h>

#include <chrono>
#include <thread>

#include "src/base/files/names.h"
#include "src/service/deadline.h"
#include "src/service/inputs/uploads.h"
#include "src/service/jobs/kept_inputs.h"
#include "src/service/staging_folder.h"
#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

class Limits : public ServiceTest {
 protected:
  // A 2D result "plane" with the attribute z.
  void make_plane() {
    make_cloud("plane.ply", 2000, 1, 3);
    auto flat = triangulate("plane.ply", "plane");
    flat.mutable_triangulate()->set_dim(2);
    ASSERT_EQ(ended(submit(flat)).status(), "successful");
  }
  static proto::Inputs contours(double interval) {
    proto::Inputs inputs;
    inputs.mutable_contours()->set_triangulation("plane");
    inputs.mutable_contours()->set_interval(interval);
    return inputs;
  }
  Reply<void> send(const std::string& name, const std::string& text, bool whole = true) {
    BOOST_OUTCOME_TRY(sending, service->inputs().upload("u", name, 0, alice));
    BOOST_OUTCOME_TRYV(sending->write(text));
    return whole ? sending->finish() : Reply<void>(success());
  }
};

TEST_F(Limits, ContoursAndExportsThatNeedMoreDiskThanAJobMayHaveAreRefusedAndSaySo) {
  open();
  make_plane();
  options.limits.disk_bytes = 500'000;
  restart();
  for (const auto& [interval, fits] : {std::pair(0.7, true), std::pair(2e-6, false)}) {
    const auto estimate = service->processes().estimate(contours(interval), alice);
    ASSERT_TRUE(estimate) << estimate.error().detail();
    EXPECT_GT(estimate.value().result_bytes(), 0U);
    EXPECT_EQ(estimate.value().accepted(), fits) << estimate.value().reason();
  }
  const auto problem = refused(contours(2e-6));
  EXPECT_EQ(problem.status(), 422);
  EXPECT_NE(problem.detail().find("limits.disk"), std::string::npos) << problem.detail();
  EXPECT_EQ(ended(submit(contours(0.7))).status(), "successful");
  proto::Inputs exported;
  exported.mutable_export_()->set_triangulation("plane");
  exported.mutable_export_()->set_output("mesh.geojson");
  EXPECT_NE(refused(exported).detail().find("limits.disk"), std::string::npos);
}

TEST_F(Limits, InputsThatAreTooLargeToBeKeptAreRefused) {
  make_cloud("a.xyz", 100);
  open();
  auto classes = triangulate("a.xyz");
  for (int i = 0; i < 300; ++i) classes.mutable_triangulate()->add_class_(2);
  EXPECT_EQ(refused(classes).status(), 400);
  auto names = triangulate("a.xyz");
  for (int i = 0; i < 40'000; ++i) names.mutable_triangulate()->add_attributes("intensity");
  EXPECT_EQ(refused(names).status(), 413);
  proto::Inputs region;
  region.mutable_region()->add_inputs("a.xyz");
  region.mutable_region()->set_polygon(std::string(inputs_bytes_max, ' '));
  EXPECT_EQ(refused(region).status(), 413);
}

TEST_F(Limits, ASuccessfulJobKeepsItsKeyAndNotItsLists) {
  make_cloud("a.xyz", 100);
  open();
  auto inputs = triangulate("a.xyz", "once");
  for (int i = 0; i < 1000; ++i) inputs.mutable_triangulate()->add_inputs("a.xyz");
  const auto id = submit(inputs, alice, "key");
  ASSERT_EQ(ended(id).status(), "successful");
  EXPECT_LT(std::filesystem::file_size(job_record_file(job_folder(data(), id))), 2000U);
  for (int start = 0; start < 2; ++start) {
    EXPECT_EQ(submit(inputs, alice, "key"), id);
    EXPECT_EQ(refused(triangulate("a.xyz", "once"), alice, "key").status(), 422);
    EXPECT_EQ(status(id).process_id(), "triangulate");
    restart();
  }
}

TEST_F(Limits, OfEachCallerSoManyEndedJobsAreRememberedAndNoMore) {
  make_cloud("a.xyz", 100);
  options.limits.ended_of_a_caller = 3;
  open();
  std::vector<std::string> ids;
  for (int i = 0; i < 6; ++i) {
    ids.push_back(submit(triangulate("a.xyz")));
    ended(ids.back());
  }
  const auto others = submit(triangulate("a.xyz"), bob);
  ended(others);
  for (std::size_t i = 0; i < 3; ++i) {  // in whatever order they are forgotten
    while (service->jobs().status(ids[i])) std::this_thread::yield();
    EXPECT_EQ(service->jobs().status(ids[i]).error().status(), 410);
  }
  for (std::size_t i = 3; i < ids.size(); ++i) EXPECT_EQ(status(ids[i]).status(), "successful");
  EXPECT_EQ(status(others).status(), "successful");
  EXPECT_FALSE(std::filesystem::exists(job_folder(data(), ids[0])));
  EXPECT_TRUE(service->results().info(ids[0])) << "results stay";
}

TEST_F(Limits, APatternGoesOnlyDownAndEachFileCountsOnce) {
  make_cloud("a.xyz", 100);
  std::filesystem::create_directory(inputs() / "sub");
  std::filesystem::copy(inputs() / "a.xyz", inputs() / "sub" / "b.xyz");
  open();
  for (const char* pattern : {"*/../*.xyz", "*/../../*", "sub/../*/b.xyz"})
    EXPECT_EQ(refused(triangulate(pattern)).status(), 400) << pattern;
  auto both = triangulate("a.xyz");
  for (const char* again : {"*.xyz", "a.xyz", "sub/../a.xyz", "sub"}) both.mutable_triangulate()->add_inputs(again);
  const auto made = ended(submit(both));
  ASSERT_EQ(made.status(), "successful") << made.message();
  EXPECT_EQ(made.points(), 200U);
}

TEST_F(Limits, PatternsThatLookAtTooManyNamesAreLeftToAJob) {
  for (int i = 0; i < 100; ++i) std::ofstream(inputs() / ("none" + std::to_string(i)));
  make_cloud("a.xyz", 100);
  open();
  proto::InfoInputs info;
  auto job = triangulate("a*", "all");
  for (std::uint64_t names = 0; names <= WhileAnyoneWaits::names_max; names += 100) {
    info.add_inputs("a*");
    job.mutable_triangulate()->add_inputs("a*");
  }
  const auto at_once = service->processes().info(info, alice);
  ASSERT_FALSE(at_once);
  EXPECT_EQ(at_once.error().type(), "urn:tessera:needs-a-job");
  const auto made = ended(submit(job));
  EXPECT_EQ(made.status(), "successful") << made.message();
}

TEST_F(Limits, UploadsHaveABoundLeaveTheReserveAndCanBeRemoved) {
  options.uploads = true;
  options.limits.upload_bytes = 1000;
  open();
  ASSERT_TRUE(send("a.xyz", std::string(600, '1')));
  const auto full = send("b.xyz", std::string(600, '1'));
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().status(), 507);
  EXPECT_NE(full.error().detail().find("limits.uploads"), std::string::npos);
  EXPECT_EQ(service->inputs().remove_upload("u", "c.xyz", alice).error().status(), 404);
  EXPECT_EQ(service->inputs().remove_upload("..", "a.xyz", alice).error().status(), 400);
  EXPECT_EQ(service->inputs().remove_upload("u", "a.xyz", {"r", Role::read}).error().status(), 403);
  EXPECT_EQ(service->inputs().remove_upload("u", "a.xyz", bob).error().status(), 403);
  ASSERT_TRUE(service->inputs().remove_upload("u", "a.xyz", alice));
  EXPECT_FALSE(service->inputs().uploaded("u", "a.xyz"));
  ASSERT_TRUE(send("b.xyz", std::string(600, '1'), false));
  EXPECT_EQ(service->inputs().uploaded("u", "b.xyz").value(), 600U);
  ASSERT_TRUE(service->inputs().remove_upload("u", "b.xyz", alice)) << "also of a file that has not come whole";
  ASSERT_TRUE(send("d.xyz", std::string(1000, '1')));
  options.limits.reserve_bytes = std::uint64_t{1} << 60;
  options.limits.upload_bytes = 0;
  restart();
  const auto reserved = send("e.xyz", "1 2 3\n");
  ASSERT_FALSE(reserved);
  EXPECT_EQ(reserved.error().status(), 507);
  EXPECT_NE(reserved.error().detail().find("limits.reserve"), std::string::npos);
}

TEST_F(Limits, PartsOfUploadsThatNobodyGoesOnSendingAreRemovedAndFilesAreBounded) {
  std::filesystem::create_directories(uploads_folder(data()));
  const auto desk = StagingFolder::lay(uploads_folder(data()), 1, [] { return Status(success()); });
  ASSERT_TRUE(desk) << desk.error().where;
  Uploads uploads(data(), {.files = 2}, *desk.value());
  ASSERT_TRUE(uploads.open());
  {
    const auto sending = uploads.begin("u", "a.xyz", 0, alice);
    ASSERT_TRUE(sending);
    const auto future = std::chrono::system_clock::now() + std::chrono::hours(1);
    EXPECT_TRUE(uploads.expire(future).empty()) << "it is being sent";
    ASSERT_TRUE(uploads.begin("u", "b.xyz", 0, alice).value()->finish());
    EXPECT_EQ(uploads.begin("u", "c.xyz", 0, alice).error().status(), 507);
  }
  EXPECT_TRUE(uploads.expire(std::chrono::system_clock::now() - std::chrono::hours(1)).empty()) << "it is young";
  EXPECT_EQ(uploads.expire(std::chrono::system_clock::now() + std::chrono::hours(1)).size(), 1U);
  EXPECT_FALSE(uploads.uploaded("u", "a.xyz"));
  EXPECT_TRUE(uploads.uploaded("u", "b.xyz")) << "whole files stay";
  EXPECT_TRUE(uploads.begin("u", "c.xyz", 0, alice));
}

TEST_F(Limits, WhatTheCallerDidIsNoErrorOfTheServer) {
  open();
  make_plane();
  Question star{.about = Question::About::star, .triangulation = "plane", .vertex = "5"};
  star.options["tile"] = "999999";
  EXPECT_EQ(service->questions().ask(star).error().status(), 400) << service->questions().ask(star).error().detail();
  // Unpacked it is larger than a body may be.
  std::string bomb(1 << 20, '\0');
  std::string text;
  while (text.size() < (std::size_t{65} << 20)) text += "0.5 0.5\n";
  z_stream packed{};
  ASSERT_EQ(::deflateInit2(&packed, 1, Z_DEFLATED, 31, 8, Z_DEFAULT_STRATEGY), Z_OK);
  packed.next_in = reinterpret_cast<Bytef*>(text.data());
  packed.avail_in = static_cast<uInt>(text.size());
  packed.next_out = reinterpret_cast<Bytef*>(bomb.data());
  packed.avail_out = static_cast<uInt>(bomb.size());
  ASSERT_EQ(::deflate(&packed, Z_FINISH), Z_STREAM_END);
  bomb.resize(packed.total_out);
  ::deflateEnd(&packed);
  Question locate{.about = Question::About::locate, .triangulation = "plane"};
  locate.body = bomb;
  locate.type = "text/csv";
  EXPECT_EQ(service->questions().ask(locate).error().status(), 422)
      << service->questions().ask(locate).error().detail();
}

}  // namespace
}  // namespace tessera::service::testing
