// Hostile names, inputs and paths.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <limits>

#include "src/service/inputs/roots.h"
#include "src/service/naming.h"
#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

namespace fs = std::filesystem;

class Inputs : public ServiceTest {
 protected:
  void SetUp() override {
    fs::create_directories(inputs() / "sub" / "deep");
    fs::create_directories(folder.path() / "secret");
    for (const auto* file :
         {"inputs/a.xyz", "inputs/b.xyz", "inputs/sub/c.xyz", "inputs/sub/deep/d.xyz", "secret/s.xyz"})
      std::ofstream(folder.path() / file) << "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 2\n";
  }
  // Of the files that the input means: their names below the root, or the sentence.
  std::string files(const std::string& input, bool recursive = false) {
    const auto roots = Roots::open({inputs()}, "");
    if (!roots) return roots.error().where;
    const auto found = roots.value().files({input}, recursive);
    if (!found) return "refused: " + found.error().where;
    std::string names;
    for (const auto& file : found.value())
      names += (names.empty() ? "" : " ") + fs::path(file).lexically_relative(fs::canonical(inputs())).string();
    return names;
  }
};

TEST_F(Inputs, FilesFoldersAndPatternsAreFoundBelowTheRootSorted) {
  EXPECT_EQ(files("a.xyz"), "a.xyz");
  EXPECT_EQ(files((inputs() / "a.xyz").string()), "a.xyz");
  EXPECT_EQ(files("sub"), "sub/c.xyz");
  EXPECT_EQ(files("sub", true), "sub/c.xyz sub/deep/d.xyz");
  EXPECT_EQ(files("*.xyz"), "a.xyz b.xyz");
  EXPECT_EQ(files("s*/[c-d].xyz"), "sub/c.xyz");
  EXPECT_EQ(files("s*/*/?.xyz"), "sub/deep/d.xyz");
  EXPECT_EQ(files(inputs().string()), "a.xyz b.xyz");
  EXPECT_EQ(files((inputs() / "*.xyz").string()), "a.xyz b.xyz");
  std::ofstream(inputs() / "[c].xyz") << "1 2 3\n";
  EXPECT_EQ(files("[c].xyz"), "[c].xyz");
}

TEST_F(Inputs, NothingOutsideOfTheRootIsReached) {
  const auto secret = folder.path() / "secret";
  fs::create_symlink(secret, inputs() / "link");
  fs::create_symlink(secret / "s.xyz", inputs() / "link.xyz");
  fs::create_symlink("../secret/s.xyz", inputs() / "up.xyz");
  fs::create_symlink("sub/c.xyz", inputs() / "inside.xyz");
  const std::vector<std::string> hostile{"../secret/s.xyz",
                                         "sub/../../secret/s.xyz",
                                         (secret / "s.xyz").string(),
                                         inputs().string() + "/../secret/s.xyz",
                                         "link/s.xyz",
                                         "link.xyz",
                                         "up.xyz",
                                         "link",
                                         "link/*.xyz",
                                         "l*/s.xyz",
                                         "../s*/s.xyz",
                                         "/etc/passwd",
                                         "/proc/self/environ",
                                         ".",
                                         "..",
                                         "*.xyz"};
  for (const auto& input : hostile) EXPECT_EQ(files(input).find("refused: "), 0) << input << ": " << files(input);
  EXPECT_EQ(files("inside.xyz"), "sub/c.xyz");
  fs::remove(inputs() / "link.xyz");
  fs::remove(inputs() / "up.xyz");
  EXPECT_EQ(files("*.xyz"), "a.xyz b.xyz sub/c.xyz");
}

TEST_F(Inputs, WhatIsNoFileOfOursIsRefusedAndNothingWaits) {
  ASSERT_EQ(::mkfifo((inputs() / "fifo.xyz").c_str(), 0600), 0);
  fs::create_symlink("loop.xyz", inputs() / "loop.xyz");
  using std::string_literals::operator""s;
  const std::vector<std::string> hostile{"-",
                                         "",
                                         "http://example.org/a.laz",
                                         "/vsicurl/http://x/a.laz",
                                         "s3://b/a.laz",
                                         "a.xyz\0.laz"s,
                                         "fifo.xyz",
                                         "/dev/zero",
                                         "loop.xyz",
                                         "missing.xyz",
                                         "upload:a/b",
                                         std::string(100'000, 'x'),
                                         "\xff\xfe",
                                         "sub/deep/d.xyz/x"};
  for (const auto& input : hostile) EXPECT_EQ(files(input).find("refused: "), 0) << input;
  EXPECT_NE(files(".").find("fifo.xyz"), std::string::npos);
}

TEST_F(Inputs, EveryRefusalOfASubmissionNamesTheField) {
  open();
  const auto detail = [&](auto change, int status = 400) {
    auto inputs = triangulate("a.xyz");
    change(*inputs.mutable_triangulate());
    const auto problem = refused(inputs);
    EXPECT_EQ(problem.status(), status) << problem.detail();
    EXPECT_EQ(problem.detail().find("--"), std::string::npos) << problem.detail();
    return problem.detail();
  };
  using Fields = proto::TriangulateInputs;
  EXPECT_EQ(detail([](Fields& of) { of.set_dim(4); }), "dim: is neither 2 nor 3");
  EXPECT_EQ(detail([](Fields& of) { of.set_tile_points(0); }), "tile_points: must be at least 1");
  EXPECT_EQ(detail([](Fields& of) { of.set_tiles(2), of.set_tile_points(9); }),
            "tiles and tile_points contradict each other: give one of them");
  EXPECT_EQ(detail([](Fields& of) { of.set_memory("lots"); }), "memory: 'lots' is not a size like 800M, 4G or 1.5G");
  EXPECT_EQ(detail([](Fields& of) { of.add_class_(256); }),
            "class: 256 is not a LAS class, which is a number from 0 to 255");
  EXPECT_EQ(detail([](Fields& of) { of.set_kernel("x"); }),
            "kernel: 'x' is not a kernel; the kernels are flat and cgal");
  const auto nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(detail([&](Fields& of) {
                for (const double x : {0.0, 0.0, 1.0, nan}) of.add_crop(x);
              }),
              "crop: is not a box: one of its numbers is not finite");
  }
  EXPECT_EQ(detail([&](Fields& of) { of.set_resolution(nan); }), "resolution: must be a finite number above 0");
  EXPECT_EQ(detail([](Fields& of) { of.set_returns("second"); }),
            "returns: 'second' is not one of all, first, last and single");
  EXPECT_NE(detail([](Fields& of) { of.add_without("x"); }).find("without: "), std::string::npos);
  EXPECT_EQ(detail([](Fields& of) { of.add_columns("x"), of.add_columns("z"); }), "columns: no column is called y");
  EXPECT_EQ(detail([](Fields& of) { of.set_keep("middle"); }),
            "keep: 'middle' is not one of first, last, lowest and highest");
  EXPECT_NE(detail([](Fields& of) { of.set_partition("x"); }).find("partition: "), std::string::npos);
  EXPECT_EQ(detail([](Fields& of) { of.clear_inputs(); }), "inputs: no file, folder or pattern is given");
  EXPECT_NE(detail([](Fields& of) { of.set_memory("1"); }, 422).find("memory"), std::string::npos);
}

TEST_F(Inputs, NoLightComesFromWhereThereIsNoAngle) {
  open();
  ASSERT_EQ(ended(submit(triangulate("a.xyz", "a"))).status(), "successful");
  const auto detail = [&](double azimuth, double altitude) {
    proto::Inputs inputs;
    auto& dem = *inputs.mutable_dem();
    dem.set_triangulation("a");
    dem.set_res(1);
    dem.set_hillshade(true);
    dem.set_azimuth(azimuth);
    dem.set_altitude(altitude);
    const auto problem = refused(inputs);
    EXPECT_EQ(problem.status(), 400) << problem.detail();
    return problem.detail();
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double none : {nan, inf, -inf})
    EXPECT_EQ(detail(none, 45).find("azimuth: must be a finite number of degrees"), 0u);
  for (const double none : {nan, inf, 0.0, 91.0}) EXPECT_EQ(detail(315, none).find("altitude: must be above 0"), 0u);
}

TEST_F(Inputs, AFileIsNoCoordinateSystem) {
  open();
  std::ofstream(inputs() / "a.prj") << "EPSG:2154";
  for (const std::string& crs : {(inputs() / "a.prj").string(), std::string("/etc/passwd"), std::string("a.prj"),
                                 std::string("http://spatialreference.org/ref/epsg/2154/"),
                                 std::string("+init=epsg:4326"), std::string("/vsicurl/http://x")}) {
    auto inputs = triangulate("a.xyz");
    inputs.mutable_triangulate()->set_crs(crs);
    const std::string detail = refused(inputs).detail();
    EXPECT_TRUE(detail.starts_with("crs: '" + crs.substr(0, 40))) << detail;
    EXPECT_NE(detail.find("is neither EPSG:n nor WKT (it does not begin with the keyword"), std::string::npos)
        << detail;
  }
}

TEST_F(Inputs, NamesOfResultsStayInTheirFolder) {
  open();
  using std::string_literals::operator""s;
  for (const auto& name : {".."s, "."s, "../x"s, "a/b"s, "/x"s, ".hidden"s, "a\\b"s, "a\0b"s, "a\nb"s,
                           "a\xC2\x9B"
                           "b"s,
                           "a\xE2\x80\xAE"
                           "b"s,
                           "\xff"s, std::string(101, 'a')}) {
    EXPECT_EQ(refused(triangulate("a.xyz", name)).status(), 400) << name;
    EXPECT_EQ(service->results().info(name).error().status(), 404);
    EXPECT_EQ(service->results().file(name, "manifest.json").error().status(), 404);
    EXPECT_EQ(service->results().remove(name, admin).error().status(), 404);
    EXPECT_EQ(refused(verify(name)).status(), 400);
    EXPECT_EQ(service->jobs().status(name).error().status(), 404);
    EXPECT_EQ(service->jobs().log(name).error().status(), 404);
  }
  EXPECT_EQ(ended(submit(triangulate("a.xyz", "été 1"))).status(), "successful");
}

TEST_F(Inputs, OnlyFilesOfAResultAreServedWithTheirChecksumsAsTags) {
  open();
  ASSERT_EQ(ended(submit(triangulate("a.xyz", "a"))).status(), "successful");
  const auto serve = [&](const std::string& path) {
    auto file = service->results().file("a", path);
    if (file) ::close(file.value().descriptor);
    return file;
  };
  for (const auto* path : {"manifest.json", "triangulation.pvtu", "tiles/000000.vtu", "report.html"}) {
    const auto file = serve(path);
    ASSERT_TRUE(file) << path;
    EXPECT_EQ(file.value().bytes, fs::file_size(data() / "results/a" / path));
    EXPECT_EQ(file.value().etag, serve(path).value().etag);
  }
  EXPECT_EQ(serve("tiles/000000.vtu").value().etag.find("\"xxh3-"), 0);
  EXPECT_EQ(serve("report.html").value().type, "text/html; charset=utf-8");
  fs::create_symlink("/etc/passwd", data() / "results/a/exports");
  fs::create_symlink("/etc/passwd", data() / "results/a/tiles/000001.vtu");
  std::ofstream(data() / "results/a/mine.txt") << "x";
  using std::string_literals::operator""s;
  for (const auto& path :
       {""s, "."s, "tiles"s, "tiles/"s, "../a/manifest.json"s, "tiles/../manifest.json"s, "tiles/000001.vtu"s,
        "exports"s, "exports/x"s, ".lock"s, "mine.txt"s, "/etc/passwd"s, "tiles/000000.vtu\0"s,
        "tiles//../../../../etc/passwd"s, "manifest.json.tmp"s, std::string(9000, 'a'), "tiles/000000.vtu/x"s}) {
    EXPECT_EQ(serve(path).error().status(), 404) << path;
  }
}

TEST_F(Inputs, UploadsAreThereWhenWholeAndWithinTheirLimit) {
  open();
  EXPECT_EQ(service->inputs().upload("u", "a.xyz", 0, alice).error().status(), 403);
  options.uploads = true;
  options.limits.upload_bytes = 100;
  service.reset();
  open();
  {
    auto upload = service->inputs().upload("u", "a.xyz", 0, alice);
    ASSERT_TRUE(upload) << upload.error().detail();
    EXPECT_EQ(service->inputs().upload("u", "a.xyz", 0, bob).error().status(), 409);
    ASSERT_TRUE(upload.value()->write("0 0 0\n1 0 0\n"));
  }
  EXPECT_EQ(refused(triangulate("upload:u/a.xyz")).status(), 422);
  EXPECT_EQ(service->inputs().uploaded("u", "a.xyz").value(), 12);
  EXPECT_EQ(service->inputs().upload("u", "a.xyz", 5, alice).error().status(), 409);
  auto rest = service->inputs().upload("u", "a.xyz", 12, alice);
  ASSERT_TRUE(rest);
  ASSERT_TRUE(rest.value()->write("0 1 0\n0 0 1\n"));
  EXPECT_EQ(rest.value()->write(std::string(77, 'x')).error().status(), 507);
  ASSERT_TRUE(rest.value()->finish());
  EXPECT_EQ(service->inputs().uploaded("u", "a.xyz").value(), 24);
  EXPECT_EQ(ended(submit(triangulate("upload:u/a.xyz", "up"))).status(), "successful");
  EXPECT_EQ(ended(submit(triangulate("upload:u", "up2"))).status(), "successful");
  for (const auto* name : {"..", "a/b", ".x", ""}) {
    EXPECT_EQ(service->inputs().upload(name, "a", 0, alice).error().status(), 400);
    EXPECT_EQ(service->inputs().upload("a", name, 0, alice).error().status(), 400);
  }
  EXPECT_EQ(refused(triangulate("upload:../inputs/a.xyz")).status(), 400);
}

TEST(Ids, AscendAlsoWhenTheClockIsSetBack) {
  JobIds ids;
  const auto now = std::chrono::system_clock::now();
  std::string last;
  for (int i = 0; i < 200'000; ++i) {
    const auto id = ids.next(now - std::chrono::seconds(i % 7 * 1000));
    ASSERT_TRUE(JobIds::is_id(id)) << id;
    ASSERT_LT(last, id);
    last = id;
  }
  JobIds later;
  later.seen(last);
  EXPECT_LT(last, later.next({}));
}

TEST(Times, AreReadBack) {
  const auto time = std::chrono::system_clock::from_time_t(1'795'336'828) + std::chrono::milliseconds(7);
  EXPECT_EQ(time_text(time), "2026-11-22T08:40:28.007Z");
  EXPECT_EQ(time_of(time_text(time)), time);
}

}  // namespace
}  // namespace tessera::service::testing
