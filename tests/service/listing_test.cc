// What there is to take: inputs to choose from, and what results were made into.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

namespace fs = std::filesystem;

class Listing : public ServiceTest {
 protected:
  proto::InputList list(const std::string& folder, std::uint32_t limit = 100, const std::string& after = "") {
    auto found = service->inputs().list(folder, limit, after, alice);
    EXPECT_TRUE(found) << found.error().detail();
    return found ? std::move(found).value() : proto::InputList();
  }
  std::string names(const std::string& folder) {
    std::string names;
    const auto found = list(folder);
    for (const auto& input : found.inputs())
      names += (names.empty() ? "" : " ") + input.name() + (input.folder() ? "/" : "");
    return names;
  }
};

TEST_F(Listing, AFolderTellsOfPointFilesAndFoldersAndOfNothingElse) {
  fs::create_directories(inputs() / "sub" / "deep");
  fs::create_directories(inputs() / ".hidden");
  fs::create_directories(folder.path() / "secret");
  for (const auto* file : {"inputs/a.xyz", "inputs/.b.xyz", "inputs/sub/c.xyz", "inputs/sub/deep/d.xyz",
                           "inputs/notes.doc", "inputs/packed.xyz.gz", "secret/s.xyz"})
    std::ofstream(folder.path() / file) << "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 2\n";
  ASSERT_EQ(::mkfifo((inputs() / "fifo.xyz").c_str(), 0600), 0);
  fs::create_symlink(folder.path() / "secret", inputs() / "link");
  fs::create_symlink(folder.path() / "secret" / "s.xyz", inputs() / "link.xyz");
  fs::create_symlink("../secret/s.xyz", inputs() / "up.xyz");
  fs::create_symlink("nowhere.xyz", inputs() / "gone.xyz");
  fs::create_symlink("sub/c.xyz", inputs() / "inside.xyz");
  std::ofstream(inputs() / "b\xff.xyz") << "no name that JSON could say\n";
  open();
  EXPECT_EQ(names(""), "a.xyz inside.xyz packed.xyz.gz sub/");
  EXPECT_EQ(names("sub"), "sub/c.xyz sub/deep/");
  EXPECT_EQ(names("./sub//deep/"), "sub/deep/d.xyz");
  EXPECT_EQ(names((inputs() / "sub").string()),
            (inputs() / "sub/c.xyz").string() + " " + (inputs() / "sub/deep").string() + "/");
  // A job takes each name.
  for (const std::string folder_name : {"", "sub", "sub/deep"}) {
    const auto found = list(folder_name);
    for (const auto& input : found.inputs()) {
      if (input.folder() || input.name().ends_with(".gz")) continue;
      EXPECT_TRUE(service->processes().estimate(triangulate(input.name()), alice)) << input.name();
    }
  }
  for (const std::string hostile :
       {"..", "sub/../..", "link", "/etc", "/", "../secret", "a.xyz", "nowhere", "upload:x", "fifo.xyz"}) {
    const auto found = service->inputs().list(hostile, 100, "", alice);
    ASSERT_FALSE(found) << hostile;
    EXPECT_EQ(found.error().status(), 400) << found.error().detail();
    EXPECT_EQ(found.error().detail().find("folder: "), 0u) << found.error().detail();
  }
  using std::string_literals::operator""s;
  EXPECT_FALSE(service->inputs().list("sub\0x"s, 100, "", alice));
  const auto reader = service->inputs().list("", 100, "", Caller{"reader", Role::read});
  ASSERT_FALSE(reader);
  EXPECT_EQ(reader.error().status(), 403);
}

TEST_F(Listing, HeadersTellOfPointsAndWhatIsDamagedIsToldWithoutItsPlace) {
  make_cloud("cloud.ply", 500);
  std::ofstream(inputs() / "bad.ply") << "ply\nno header\n";
  open();
  const auto found = list("");
  ASSERT_EQ(found.inputs_size(), 2);
  EXPECT_EQ(found.inputs(0).name(), "bad.ply");
  EXPECT_FALSE(found.inputs(0).has_points());
  EXPECT_EQ(found.inputs(0).note().find("bad.ply"), 0u) << found.inputs(0).note();
  EXPECT_EQ(found.inputs(0).note().find(folder.path().string()), std::string::npos) << found.inputs(0).note();
  EXPECT_EQ(found.inputs(1).points(), 500u);
  EXPECT_EQ(found.inputs(1).format(), "ply");
  EXPECT_EQ(found.inputs(1).bytes(), fs::file_size(inputs() / "cloud.ply"));
}

TEST_F(Listing, ComesInPages) {
  fs::create_directories(inputs());
  for (int i = 0; i < 25; ++i) std::ofstream(inputs() / ("p" + std::to_string(10 + i) + ".xyz")) << "1 2 3\n";
  open();
  std::string after;
  std::vector<std::string> all;
  for (int page = 0; page < 3; ++page) {
    const auto part = list("", 10, after);
    EXPECT_EQ(part.number_matched(), 25u);
    EXPECT_EQ(part.inputs_size(), page < 2 ? 10 : 5);
    for (const auto& input : part.inputs()) all.push_back(input.name());
    after = all.back();
  }
  EXPECT_EQ(all.size(), 25u);
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
  EXPECT_EQ(list("", 10, after).inputs_size(), 0);
}

TEST_F(Listing, OfSeveralRootsEachFileHasANameThatMeansIt) {
  const auto other = folder.path() / "other";
  for (const auto& root : {inputs(), other}) fs::create_directories(root / "sub");
  for (const auto& file :
       {inputs() / "a.xyz", other / "a.xyz", other / "b.xyz", inputs() / "sub/c.xyz", other / "sub/d.xyz"})
    std::ofstream(file) << "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 " << file.string().size() << "\n";
  options.roots = {inputs(), other};
  options.uploads = true;
  open();
  EXPECT_EQ(names(""), (other / "a.xyz").string() + " a.xyz b.xyz sub/");
  EXPECT_EQ(names("sub"), "sub/c.xyz sub/d.xyz");
  auto upload = service->inputs().upload("mine", "u.xyz", 0, alice);
  ASSERT_TRUE(upload) << upload.error().detail();
  ASSERT_TRUE(upload.value()->write("1 2 3\n"));
  EXPECT_EQ(names("upload:mine"), "") << "it is not whole yet";
  ASSERT_TRUE(upload.value()->finish());
  EXPECT_EQ(names(""), (other / "a.xyz").string() + " a.xyz b.xyz sub/ upload:mine/");
  EXPECT_EQ(names("upload:mine"), "upload:mine/u.xyz");
  EXPECT_FALSE(service->inputs().list("upload:../results", 100, "", alice));
}

TEST_F(Listing, OfAResultItTellsWhatItWasMadeInto) {
  make_cloud("a.xyz", 500);
  open();
  ASSERT_EQ(ended(submit(triangulate("a.xyz", "made"))).status(), "successful");
  const auto nothing = service->results().exports("made", 100, "");
  ASSERT_TRUE(nothing) << nothing.error().detail();
  EXPECT_EQ(nothing.value().exports_size(), 0);
  std::vector<std::string> jobs;
  for (const auto* output : {"b.ply", "a.mesh"}) {
    proto::Inputs exported;
    exported.mutable_export_()->set_triangulation("made");
    exported.mutable_export_()->set_output(output);
    jobs.push_back(submit(exported));
    ASSERT_EQ(ended(jobs.back()).status(), "successful");
  }
  const auto found = service->results().exports("made", 100, "");
  ASSERT_TRUE(found);
  EXPECT_EQ(found.value().number_matched(), 2u);
  ASSERT_EQ(found.value().exports_size(), 2);
  const auto& ply = found.value().exports(1);
  EXPECT_EQ(found.value().exports(0).name(), "a.mesh");
  EXPECT_EQ(ply.name(), "b.ply");
  EXPECT_EQ(ply.files(), 1u);
  EXPECT_EQ(ply.bytes(), fs::file_size(options.data / "results/made/exports/b.ply"));
  EXPECT_EQ(ply.submitter(), alice.name);
  EXPECT_EQ(ply.process_id(), "export");
  EXPECT_EQ(ply.job_id(), jobs[0]);
  EXPECT_FALSE(ply.created().empty());
  EXPECT_EQ(service->results().exports("made", 1, "").value().exports_size(), 1);
  EXPECT_EQ(service->results().exports("made", 1, "a.mesh").value().exports(0).name(), "b.ply");
  // Without its job it is there as before.
  ASSERT_TRUE(service->jobs().dismiss(jobs[0], alice));
  EXPECT_EQ(service->results().exports("made", 1, "a.mesh").value().exports(0).job_id(), "");
  EXPECT_EQ(service->results().exports("made", 1, "a.mesh").value().exports(0).submitter(), alice.name);
  for (const auto* name : {"nothing", "..", ""}) {
    const auto missing = service->results().exports(name, 100, "");
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().status(), 404);
  }
}

}  // namespace
}  // namespace tessera::service::testing
