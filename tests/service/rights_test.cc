// What one caller has made no other can take away, by whatever name removing goes: DELETE, overwrite, a job that is
// given up again, a second upload.
#include <fstream>
#include <string>

#include "src/service/results/owners.h"
#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

class Rights : public ServiceTest {
 protected:
  Rights() { make_cloud("a.xyz", 500); }

  static proto::Inputs overwriting(proto::Inputs inputs) {
    if (inputs.has_triangulate()) inputs.mutable_triangulate()->set_overwrite(true);
    if (inputs.has_export_()) inputs.mutable_export_()->set_overwrite(true);
    if (inputs.has_dem()) inputs.mutable_dem()->set_overwrite(true);
    return inputs;
  }
  static proto::Inputs made_in_2d(const std::string& output) {
    auto inputs = triangulate("a.xyz", output);
    inputs.mutable_triangulate()->set_dim(2);
    return inputs;
  }
  static proto::Inputs exported(const std::string& output) {
    proto::Inputs inputs;
    inputs.mutable_export_()->set_triangulation("hers");
    inputs.mutable_export_()->set_output(output);
    return inputs;
  }
  std::string identity() { return service->questions().identity("hers").value(); }
  // All of it, as one piece.
  int send(const std::string& text, const Caller& caller, std::uint64_t offset = 0) {
    auto upload = service->inputs().upload("folder", "cloud.xyz", offset, caller);
    if (!upload) return upload.error().status();
    EXPECT_TRUE(upload.value()->write(text));
    EXPECT_TRUE(upload.value()->finish());
    return 204;
  }
  std::string uploaded_text() const {
    std::ifstream file(data() / "uploads" / "folder" / "cloud.xyz");
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

TEST_F(Rights, ToOverwriteAResultTakesTheRightToRemoveIt) {
  open();
  EXPECT_EQ(ended(submit(made_in_2d("hers"))).status(), "successful");
  const auto before = identity();
  EXPECT_EQ(service->results().remove("hers", bob).error().status(), 403);
  const auto problem = refused(overwriting(made_in_2d("hers")), bob);
  EXPECT_EQ(problem.status(), 403);
  EXPECT_NE(problem.detail().find("'hers'"), std::string::npos) << problem.detail();
  EXPECT_EQ(identity(), before);
  EXPECT_EQ(ended(submit(overwriting(made_in_2d("hers")))).status(), "successful");
  EXPECT_NE(identity(), before);
  EXPECT_EQ(ended(submit(overwriting(made_in_2d("hers")), admin)).status(), "successful");
  EXPECT_EQ(refused(overwriting(made_in_2d("hers"))).status(), 403) << "it is the admin's now";
}

TEST_F(Rights, AJobThatMadeNothingGivesNoRight) {
  std::ofstream(inputs() / "bad.xyz") << "1 2 3\n4 5 nan\n";
  open();
  // Both wanted the name; alice got it.
  EXPECT_EQ(ended(submit(triangulate("bad.xyz", "hers"), bob)).status(), "failed");
  EXPECT_EQ(ended(submit(made_in_2d("hers"))).status(), "successful");
  EXPECT_EQ(service->results().remove("hers", bob).error().status(), 403);
  EXPECT_TRUE(service->results().remove("hers", alice));
}

TEST_F(Rights, AJobThatIsResumedReplacesNothingOfOthers) {
  std::ofstream(inputs() / "bad.xyz") << "1 2 3\n4 5 nan\n";
  open();
  const auto his = submit(overwriting(triangulate("bad.xyz", "hers")), bob);
  EXPECT_EQ(ended(his).status(), "failed");
  EXPECT_EQ(ended(submit(made_in_2d("hers"))).status(), "successful");
  EXPECT_EQ(service->jobs().resume(his, bob).error().status(), 403);
  EXPECT_TRUE(service->jobs().resume(his, admin)) << "who may remove it may have it replaced";
  ended(his);
}

TEST_F(Rights, AreKnownWhenTheJobIsForgotten) {
  open();
  const auto job = submit(made_in_2d("hers"));
  ended(job);
  ended(submit(exported("mesh.ply")));
  restart();
  const auto all = service->jobs().list({}).value();
  for (const auto& each : all.jobs()) EXPECT_TRUE(service->jobs().dismiss(each.id(), alice));
  EXPECT_EQ(service->jobs().list({}).value().number_matched(), 0U);
  EXPECT_EQ(service->results().remove_export("hers", "mesh.ply", bob).error().status(), 403);
  EXPECT_EQ(service->results().remove("hers", bob).error().status(), 403);
  EXPECT_TRUE(service->results().remove_export("hers", "mesh.ply", alice));
  EXPECT_TRUE(service->results().remove("hers", alice));
}

TEST_F(Rights, ToOverwriteAnExportTakesTheRightToRemoveIt) {
  open();
  ended(submit(made_in_2d("hers")));
  ended(submit(exported("mesh.ply")));
  EXPECT_EQ(refused(exported("mesh.ply"), bob).status(), 409);
  EXPECT_EQ(refused(overwriting(exported("mesh.ply")), bob).status(), 403);
  EXPECT_EQ(ended(submit(exported("his.ply"), bob)).status(), "successful");
  EXPECT_EQ(service->results().remove_export("hers", "mesh.ply", bob).error().status(), 403);
  EXPECT_EQ(service->results().remove_export("hers", "his.ply", alice).error().status(), 403);
  EXPECT_TRUE(service->results().remove_export("hers", "his.ply", bob));
  EXPECT_EQ(ended(submit(overwriting(exported("mesh.ply")))).status(), "successful");
  EXPECT_TRUE(service->results().remove_export("hers", "mesh.ply", admin));
  EXPECT_EQ(ended(submit(exported("mesh.ply"), bob)).status(), "successful") << "the name is free again";
  EXPECT_EQ(refused(overwriting(exported("mesh.ply"))).status(), 403);
  proto::Inputs dem;
  dem.mutable_dem()->set_triangulation("hers");
  dem.mutable_dem()->set_res(0.1);
  EXPECT_EQ(ended(submit(dem)).status(), "successful");
  EXPECT_EQ(refused(overwriting(dem), bob).status(), 403);
}

TEST_F(Rights, ToAddColumnsTakesTheRightToRemoveTheResult) {
  open();
  ended(submit(made_in_2d("hers")));
  proto::Inputs measured;
  measured.mutable_measure()->set_triangulation("hers");
  measured.mutable_measure()->set_volume(true);
  const auto problem = refused(measured, bob);
  EXPECT_EQ(problem.status(), 403);
  EXPECT_EQ(problem.detail(), "triangulation: only the owner of 'hers' or an admin may change it");
  EXPECT_EQ(ended(submit(measured)).status(), "successful");
  EXPECT_EQ(ended(submit(measured, admin)).status(), "successful") << "they are there already";
  EXPECT_TRUE(service->results().remove("hers", alice)) << "it is still hers";
}

// What is from before owners were kept.
TEST_F(Rights, WhatNobodyIsKnownToHaveMadeIsAnAdmins) {
  open();
  ended(submit(made_in_2d("hers")));
  ended(submit(exported("mesh.ply")));
  ASSERT_TRUE(forget_owner(data() / "results" / "hers" / "exports" / "mesh.ply"));
  for (const auto& each : {alice, bob}) EXPECT_EQ(refused(overwriting(exported("mesh.ply")), each).status(), 403);
  EXPECT_TRUE(service->results().remove_export("hers", "mesh.ply", admin));
}

TEST_F(Rights, AnUploadIsReplacedByWhoSentItOrAnAdmin) {
  options.uploads = true;
  open();
  const std::string hers = "1 2 3\n", his = "9 9 9\n";
  EXPECT_EQ(send(hers, alice), 204);
  EXPECT_EQ(send(his, bob), 403);
  EXPECT_EQ(uploaded_text(), hers);
  restart();
  EXPECT_EQ(send(his, bob), 403);
  EXPECT_EQ(send("4 5 6\n", alice), 204);
  EXPECT_EQ(send(his, admin), 204);
  EXPECT_EQ(uploaded_text(), his);
  EXPECT_EQ(send(hers, alice), 403) << "it is the admin's now";
}

TEST_F(Rights, WhatHasComeOfAnUploadIsNotGoneOnWithByOthers) {
  options.uploads = true;
  open();
  {
    auto begun = service->inputs().upload("folder", "cloud.xyz", 0, alice);
    ASSERT_TRUE(begun);
    EXPECT_TRUE(begun.value()->write("1 2 3\n"));
  }
  EXPECT_EQ(send("9 9 9\n", bob, 6), 403);
  EXPECT_EQ(send("9 9 9\n", bob), 403);
  EXPECT_EQ(send("4 5 6\n", alice, 6), 204);
  EXPECT_EQ(uploaded_text(), "1 2 3\n4 5 6\n");
}

}  // namespace
}  // namespace tessera::service::testing
