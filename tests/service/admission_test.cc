#include "src/service/jobs/admission.h"

#include "src/service/jobs/jobs.h"
#include "tests/service/table_testing.h"

namespace tessera::service {
namespace {

using testing::alice;
using testing::bob;

using Admit = testing::TableTest;

TEST_F(Admit, ARepeatedKeyGivesTheSameJobAndOtherInputsAreRefused) {
  const auto first = accept("a", alice, "once");
  ASSERT_TRUE(first);
  EXPECT_TRUE(first.value().fresh);
  auto same = record_of("a", alice, "once");
  const auto again = admission->same_as(same.inputs(), alice, "once");
  ASSERT_TRUE(again);
  ASSERT_TRUE(again.value());
  EXPECT_EQ(again.value()->status.id(), first.value().status.id());
  EXPECT_FALSE(again.value()->fresh);
  EXPECT_EQ(admission->same_as(record_of("b", alice).inputs(), alice, "once").error().status(), 422);
  EXPECT_FALSE(admission->same_as(same.inputs(), bob, "once").value());
  EXPECT_FALSE(admission->same_as(same.inputs(), alice, "").value());
}

TEST_F(Admit, OneJobAloneMakesAResult) {
  ASSERT_TRUE(accept("a"));
  EXPECT_EQ(accept("a", bob).error().status(), 409);
  EXPECT_TRUE(accept("b", bob));
}

TEST_F(Admit, OneJobAtATimeAddsColumnsToAResultAndOthersReadIt) {
  const auto on_a = [&](const auto& set) {
    auto record = record_of("a", testing::admin);
    set(*record.mutable_inputs());
    return admission->accept(record, testing::admin, "");
  };
  const auto measure = [](proto::Inputs& inputs) { inputs.mutable_measure()->set_triangulation("a"); };
  const auto verify = [](proto::Inputs& inputs) { inputs.mutable_verify()->set_triangulation("a"); };
  ASSERT_TRUE(on_a(measure));
  EXPECT_TRUE(on_a(verify));
  const auto second = on_a(measure);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().status(), 409);
  EXPECT_NE(second.error().detail().find("changes it"), std::string::npos) << second.error().detail();
}

TEST_F(Admit, AResultThatAJobReadsAsItsSecondIsNotReplaced) {
  auto volume = record_of("before", alice);
  volume.mutable_inputs()->mutable_volume()->set_triangulation("before");
  volume.mutable_inputs()->mutable_volume()->set_second("after");
  volume.mutable_inputs()->mutable_volume()->set_output("volumes.csv");
  ASSERT_TRUE(admission->accept(volume, alice, ""));
  const auto replaced = accept("after", alice);
  ASSERT_FALSE(replaced);
  EXPECT_EQ(replaced.error().status(), 409);
  EXPECT_NE(replaced.error().detail().find("'after'"), std::string::npos) << replaced.error().detail();
  ASSERT_TRUE(accept("other", alice));
  volume.mutable_inputs()->mutable_volume()->set_second("other");
  volume.mutable_inputs()->mutable_volume()->set_output("others.csv");
  const auto read = admission->accept(volume, alice, "");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().status(), 409);
}

TEST_F(Admit, AJobWithoutANameIsNamedByItsId) {
  const auto made = accept("");
  ASSERT_TRUE(made);
  EXPECT_EQ(made.value().status.triangulation(), made.value().status.id());
}

TEST_F(Admit, LimitsHoldForAllAndForACaller) {
  limits.jobs_of_a_caller = 2;
  limits.queued = 3;
  open();
  ASSERT_TRUE(accept("a"));
  ASSERT_TRUE(accept("b"));
  EXPECT_EQ(accept("c").error().status(), 429);
  ASSERT_TRUE(accept("d", bob));
  EXPECT_EQ(accept("e", Caller{"eve", Role::submit}).error().status(), 429);
}

TEST_F(Admit, AJobThatCannotBeWrittenIsNotAccepted) {
  std::filesystem::remove_all(folder.path() / "jobs");
  std::ofstream(folder.path() / "jobs") << "a file in the way";
  EXPECT_FALSE(accept("a", alice, "once"));
  EXPECT_TRUE(table->jobs.empty());
  EXPECT_TRUE(table->active.empty());
  EXPECT_TRUE(table->by_key.empty());
}

TEST_F(Admit, OnlyItsSubmitterOrAnAdminDismissesAndResumesAJob) {
  Jobs jobs(*table, *admission, *folders);
  const auto id = accepted("a").id();
  EXPECT_EQ(jobs.dismiss(id, bob).error().status(), 403);
  EXPECT_EQ(jobs.dismiss(id, alice).value().status(), "dismissed");
  EXPECT_TRUE(table->waiting.empty());
  EXPECT_EQ(jobs.resume(id, bob).error().status(), 403);
  EXPECT_EQ(jobs.resume(id, testing::admin).value().status(), "accepted");
  EXPECT_EQ(table->waiting.size(), 1u);
  EXPECT_EQ(jobs.list({}).value().number_matched(), 1u);
  EXPECT_EQ(jobs.outcome(id).error().status(), 404);
  EXPECT_EQ(jobs.dismiss(id, alice).value().status(), "dismissed");
  EXPECT_EQ(jobs.dismiss(id, alice).value().message(), "was removed");
  EXPECT_EQ(jobs.status(id).error().status(), 410);
}

}  // namespace
}  // namespace tessera::service
