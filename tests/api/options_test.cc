// The library has the options of the command, and refuses what makes no sense.
#include "tessera/options.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "src/base/files/descriptor.h"
#include "tests/api/api_testing.h"
#include "tests/api/temporary_home.h"

namespace tessera {
namespace {

using testing::cells_of;
using testing::cloud;
using testing::expected_cells;
using testing::failure_of;
using testing::TemporaryHome;

// A program sees a pointer, whatever options there will be: built today, it runs with all of them.
static_assert(sizeof(TriangulationOptions) == sizeof(void*));
static_assert(sizeof(ExportRequest) == sizeof(void*));
static_assert(sizeof(VerifyRequest) == sizeof(void*));
// What the library makes and programs read may grow at the end alone.
static_assert(offsetof(JobProgress, phase) == 0 && offsetof(JobProgress, seconds) == 72 && sizeof(JobProgress) >= 80);

const std::string corpus = TESSERA_TEST_DATA "/../fuzz/corpus/";

TriangulationOptions two_threads() { return TriangulationOptions().threads(2).memory_bytes(std::uint64_t{1} << 30); }

class OptionsOfTheCommand : public ::testing::Test {
 protected:
  const TemporaryHome home_;
};

TEST_F(OptionsOfTheCommand, AreCopiedByValue) {
  TriangulationOptions one = two_threads().dimension(2);
  const TriangulationOptions other = one;
  one.dimension(3).crop({0, 0, 1});
  EXPECT_EQ(triangulate(cloud("uniform", 2, 50), other).dimension(), 2);
  EXPECT_EQ(failure_of([&] { triangulate(cloud("uniform", 3, 50), one); }).cause(), Cause::usage);
  one = other;
  EXPECT_EQ(triangulate(cloud("uniform", 2, 50), one).dimension(), 2);
}

TEST_F(OptionsOfTheCommand, CropLeavesOutWhatIsOutsideItsClosedBox) {
  const std::vector<double> square{0, 0, 4, 0, 0, 4, 4, 4, 2, 2, 2, 5, 3, 1, std::nextafter(4, 5), 1};
  const auto t = triangulate(square, two_threads().dimension(2).crop({0, 0, 4, 4}));
  EXPECT_EQ(t.vertices(), 6u);
  EXPECT_EQ(t.points_read(), 8u);
  const auto points = cloud("uniform", 3, 500);
  std::vector<double> inside;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    if (points[i + 2] <= 0.5) inside.insert(inside.end(), &points[i], &points[i] + 3);
  }
  const auto half = triangulate(points, two_threads().crop({0, 0, 0, 1, 1, 0.5}));
  EXPECT_EQ(half.vertices(), inside.size() / 3);
  EXPECT_EQ(half.cells(), expected_cells(inside, 3).size());
}

TEST_F(OptionsOfTheCommand, TilesAndPartitionsGiveTheSameTriangulation) {
  const auto points = cloud("lattice", 3, 1000);
  const auto expected = expected_cells(points, 3);
  for (const char* kind : {"kdtree", "grid", "octree", "random"}) {
    const auto t = triangulate(points, two_threads().partition(kind).tiles(8));
    EXPECT_EQ(difference(expected, cells_of(t)), "") << kind;
    EXPECT_GT(t.tiles(), 4u) << kind;
    EXPECT_NE(t.describe().find("\"partition\":\"" + std::string(kind) + "\""), std::string::npos);
  }
}

TEST_F(OptionsOfTheCommand, ClassesHeightsAndCrsAreOfFiles) {
  const std::string las = TESSERA_TEST_DATA "/../../data/ign";
  const auto all = triangulate({las}, two_threads().dimension(2).attributes({"classification"}));
  const auto ground = triangulate({las}, two_threads().dimension(2).classes({2}).heights(false).crs("EPSG:2154"));
  EXPECT_GT(ground.vertices(), 100u);
  EXPECT_LT(ground.vertices(), all.vertices());
  EXPECT_EQ(ground.points_read(), all.points_read());
  EXPECT_EQ(ground.crs(), "EPSG:2154");
  EXPECT_TRUE(ground.tile(0).attributes().empty());
  EXPECT_EQ(all.tile(0).attributes().size(), 2u) << "classification and z";
}

TEST_F(OptionsOfTheCommand, ResolutionChoosesLevelsOfCopc) {
  const std::string copc = corpus + "laz/small.copc.laz";
  EXPECT_EQ(triangulate({copc}, two_threads().resolution(1)).vertices(), 256u) << "it has one level";
  std::ofstream(home_.path() / "a.xyz") << "0 0 0\n";
  const auto failure = failure_of([&] { triangulate({home_.path() / "a.xyz"}, two_threads().resolution(1)); });
  EXPECT_NE(std::string(failure.what()).find("is neither COPC nor EPT, so it has no levels for resolution"),
            std::string::npos);
}

TEST_F(OptionsOfTheCommand, AnInputListNamesFiles) {
  std::ofstream(home_.path() / "a.xyz") << "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  std::ofstream(home_.path() / "list.txt") << "# one\na.xyz\n";
  const auto options = two_threads().input_list(home_.path() / "list.txt");
  EXPECT_EQ(triangulate(std::vector<std::string>{}, options).cells(), 1u);
  EXPECT_NE(describe({}, options).find("\"points\":"), std::string::npos);
}

TEST_F(OptionsOfTheCommand, WarningsAreTold) {
  std::ofstream(home_.path() / "plain.xyz") << "0 0 0\n";
  std::vector<std::string> told;
  const auto options =
      two_threads().dimension(2).warning([&](const std::string& sentence) { told.push_back(sentence); });
  triangulate({TESSERA_TEST_DATA "/../../data/ign", (home_.path() / "plain.xyz").string()}, options);
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].find("plain.xyz"), std::string::npos) << told[0];
}

TEST_F(OptionsOfTheCommand, AnInterruptedRunIsResumed) {
  const auto points = cloud("uniform", 3, 400'000);  // longer at work than two looks at it are apart
  std::ofstream file(home_.path() / "cloud.xyz");
  file.precision(17);
  for (std::size_t i = 0; i < points.size(); i += 3)
    file << points[i] << ' ' << points[i + 1] << ' ' << points[i + 2] << '\n';
  file.close();
  const std::vector<std::string> files{(home_.path() / "cloud.xyz").string()};
  const auto out = home_.path() / "out";
  std::stop_source stop;
  auto options = two_threads().folder(out).max_points_per_tile(20'000).resume(true);
  options.stop(stop.get_token()).progress([&](const JobProgress& now) {
    if (now.tiles_triangulated > 0) stop.request_stop();
  });
  const auto stopped = failure_of([&] { triangulate(files, options); });
  EXPECT_EQ(stopped.cause(), Cause::interrupted);
  EXPECT_STREQ(stopped.what(), "stopped, as was requested; resume(true) goes on");
  EXPECT_NE(std::string(failure_of([&] { triangulate(files, two_threads().folder(out)); }).what()).find("resume(true)"),
            std::string::npos);
  const auto t = triangulate(files, options.stop({}).progress({}));
  EXPECT_EQ(t.digest(), triangulate(files, two_threads()).digest());
  EXPECT_EQ(triangulate(files, options).digest(), t.digest()) << "there is nothing left to do";
}

TEST_F(OptionsOfTheCommand, ThatMakeNoSenseAreUsage) {
  const auto points = cloud("uniform", 3, 50);
  const auto said = [&](const TriangulationOptions& options) {
    const auto failure = failure_of([&] { triangulate(points, options); });
    EXPECT_EQ(failure.cause(), Cause::usage) << failure.what();
    return std::string(failure.what());
  };
  EXPECT_EQ(said(TriangulationOptions().crop({1, 0, 0, 1})),
            "crop: is an empty box: its lowest x is above its highest");
  EXPECT_EQ(said(TriangulationOptions().crop({NAN, 0, 0, 1})),
            "crop: is an empty box: its lowest x is above its highest");
  EXPECT_EQ(said(TriangulationOptions().crop({0, 0, 1})),
            "crop: is not xmin,ymin,xmax,ymax or xmin,ymin,zmin,xmax,ymax,zmax");
  EXPECT_EQ(said(TriangulationOptions().classes({2, 300})), "classes: LAS has the classes 0 to 255");
  EXPECT_EQ(said(TriangulationOptions().classes({2})),
            "the array: has no attribute 'classification', so classes cannot choose points by it");
  EXPECT_EQ(said(TriangulationOptions().resolution(-1)),
            "resolution: must be a distance, above 0, or 0 for all levels");
  EXPECT_EQ(said(TriangulationOptions().tiles(2'000'000)), "tiles: more than 1000000 tiles are not possible");
  EXPECT_EQ(said(TriangulationOptions().tiles(2).max_points_per_tile(30)),
            "tiles and max_points_per_tile contradict each other: give one of them");
  EXPECT_EQ(said(TriangulationOptions().partition("hexagons")).find("partition"), 0u);
  EXPECT_EQ(
      said(TriangulationOptions().crs("nonsense")).find("crs: 'nonsense' is no file: the coordinate system is neither"),
      0u);
  EXPECT_EQ(said(TriangulationOptions().resume(true)),
            "resume: an array may have changed since the first run; save it in a file");
  EXPECT_EQ(said(TriangulationOptions().input_list("list")),
            "input_list: the points are an array, so there are no input files");
  const auto no_folder = failure_of([] { triangulate({"cloud.las"}, TriangulationOptions().resume(true)); });
  EXPECT_STREQ(no_folder.what(), "resume: an unfinished run stays in the result folder, so name one");
}

TEST_F(OptionsOfTheCommand, VerifyProvesAResultOrTellsWhatIsWrong) {
  const auto out = home_.path() / "out";
  const auto t = triangulate(cloud("lattice", 3, 600), two_threads().folder(out).max_points_per_tile(100));
  const Proof proof = t.verify(VerifyRequest().against_cgal(true).scratch(home_.path()));
  EXPECT_EQ(proof.cells(), t.cells());
  EXPECT_EQ(proof.vertices(), t.vertices());
  EXPECT_EQ(2 * proof.facets(), 4 * proof.cells() + proof.hull_facets());
  EXPECT_GT(proof.checks().size(), 5u);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(failure_of([&] { t.verify(VerifyRequest().stop(stop.get_token())); }).cause(), Cause::interrupted);
  std::filesystem::remove(out / "tiles" / "000001.vtu");
  EXPECT_NE(failure_of([&] { t.verify(); }).cause(), Cause::internal);
}

TEST_F(OptionsOfTheCommand, DescribeSaysWhatInfoSays) {
  std::ofstream(home_.path() / "a.xyz") << "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  const std::string file = (home_.path() / "a.xyz").string(), out = (home_.path() / "out").string();
  const auto text = describe({file}, two_threads());
  EXPECT_EQ(text.find("{\"files\":[{\"path\":\"" + file), 0u) << text;
  const auto t = triangulate({file}, two_threads().folder(out));
  EXPECT_EQ(t.describe().find("{\"result\":\"" + out), 0u) << t.describe();
  EXPECT_EQ(describe({out}), t.describe());
  EXPECT_EQ(failure_of([&] { describe({out, file}); }).cause(), Cause::usage);
  EXPECT_EQ(failure_of([] { describe({}); }).cause(), Cause::usage);
  EXPECT_EQ(failure_of([] { describe({"/nowhere.las"}); }).cause(), Cause::io);
}

// A server that gives one object to who asks for its first bytes.
class OneObject {
 public:
  explicit OneObject(const std::string& body) {
    const std::string last = std::to_string(body.size() - 1), size = std::to_string(body.size());
    answer_ = "HTTP/1.1 206 Partial Content\r\nContent-Range: bytes 0-" + last + "/" + size +
              "\r\nContent-Length: " + size + "\r\nConnection: close\r\n\r\n" + body;
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t bytes = sizeof address;
    EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<sockaddr*>(&address), bytes), 0);
    EXPECT_EQ(::listen(socket_.get(), 64), 0);
    EXPECT_EQ(::getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&address), &bytes), 0);
    address_ = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::jthread([this] { serve(); });
  }
  OneObject(const OneObject&) = delete;
  OneObject& operator=(const OneObject&) = delete;
  ~OneObject() { ::shutdown(socket_.get(), SHUT_RDWR); }

  const std::string& address() const { return address_; }

 private:
  void serve() {
    while (true) {
      const FileHandle peer(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      if (peer.get() < 0) return;
      std::string request;
      char buffer[4096];
      while (request.find("\r\n\r\n") == std::string::npos) {
        const auto got = ::recv(peer.get(), buffer, sizeof buffer, 0);
        if (got <= 0) break;
        request.append(buffer, static_cast<std::size_t>(got));
      }
      EXPECT_EQ(::send(peer.get(), answer_.data(), answer_.size(), MSG_NOSIGNAL), static_cast<ssize_t>(answer_.size()));
    }
  }

  std::string answer_, address_;
  FileHandle socket_{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  std::jthread thread_;
};

TEST_F(OptionsOfTheCommand, InputsMayBeAddresses) {
  const OneObject server("0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
  EXPECT_EQ(triangulate({server.address() + "/a.xyz"}, two_threads()).cells(), 1u);
  const auto here = two_threads().endpoint(server.address()).anonymous(true).requester_pays(true);
  EXPECT_EQ(triangulate({"s3://bucket/a.xyz"}, here).cells(), 1u);
  const std::string box = describe({"s3://bucket/a.xyz"}, here);
  EXPECT_NE(box.find("s3://bucket/a.xyz"), std::string::npos) << box;
}

TEST_F(OptionsOfTheCommand, OptionsOfStoresAreNamedAsHere) {
  const auto said = [](const TriangulationOptions& options) {
    const auto failure = failure_of([&] { triangulate({"s3://bucket/a.xyz"}, options); });
    EXPECT_EQ(failure.cause(), Cause::usage);
    return std::string(failure.what());
  };
  EXPECT_EQ(said(TriangulationOptions().profile("nobody of this name")).find("profile: neither "), 0u);
  EXPECT_NE(said(TriangulationOptions().endpoint("ftp://host").anonymous(true)).find("not by ftp://"),
            std::string::npos);
}

}  // namespace
}  // namespace tessera
