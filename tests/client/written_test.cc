#include "src/service/client/written.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace tessera::client {
namespace {

namespace fs = std::filesystem;

std::vector<WrittenFile> files_of(std::initializer_list<std::string> insides) {
  std::vector<WrittenFile> files;
  for (const auto& inside : insides) files.push_back({"exports/" + inside, inside, 1, 1});
  return files;
}

Result<std::vector<WrittenFile>> told(const std::string& path) {
  using Json = nlohmann::ordered_json;
  const Json entry{{"path", path}, {"bytes", 5U}, {"xxh3", "00ff"}};
  return written_files(Json{{"written", Json::array({entry})}});
}

TEST(Written, PathsOfAServerThatLeadElsewhereAreRefused) {
  EXPECT_EQ(told("exports/tiles/000042.vtu").value().at(0).inside, "tiles/000042.vtu");
  for (const std::string path :
       {"", "exports/", "exports", "tiles/a", "/etc/passwd", "exports//etc/passwd", "exports/../../x",
        "exports/a/../../../x", "exports/./a", "exports/a/", "../exports/a"})
    EXPECT_EQ(told(path).error().code, Errc::corrupt) << path;
  EXPECT_FALSE(told(std::string("exports/a\0b", 11)));
}

TEST(Written, FilesOfAFolderStayBelowIt) {
  EXPECT_EQ(places_in_folder(files_of({"made/a.npy", "made/deep/b.npy"}), "made", "here").value(),
            (std::vector<fs::path>{"here/a.npy", "here/deep/b.npy"}));
  // As a hostile server would: what it calls the export moves what is below it.
  for (const auto& [made, inside] : std::vector<std::pair<std::string, std::string>>{{"a/b", "PWNED"},
                                                                                     {"a/b/c", "a/PWNED"},
                                                                                     {"", "PWNED"},
                                                                                     {".", "PWNED"},
                                                                                     {"..", "../PWNED"},
                                                                                     {"made", "PWNED"},
                                                                                     {"made", "made"},
                                                                                     {"made", "made/"},
                                                                                     {"made", "made/../../PWNED"},
                                                                                     {"made", "made//etc/passwd"},
                                                                                     {"made", "madeup/x"}})
    EXPECT_EQ(places_in_folder(files_of({inside}), made, "here").error().code, Errc::corrupt) << made << " " << inside;
}

TEST(Written, AFileIsTheOneAskedForOrBesideItWithItsName) {
  const std::set<std::string> endings{".csv", ".vrt"};
  EXPECT_EQ(places_beside(files_of({"made.csv", "made.vrt"}), "made.csv", "out/here.csv", endings).value(),
            (std::vector<fs::path>{"out/here.csv", "out/here.vrt"}));
  EXPECT_EQ(places_beside(files_of({"made.dat"}), "made.dat", "out/here.txt", {}).value(),
            std::vector<fs::path>{"out/here.txt"});
  for (const auto& [made, inside] : std::vector<std::pair<std::string, std::string>>{{"made.csv", "made.py"},
                                                                                     {"made.csv", "other.csv"},
                                                                                     {"made.csv", "a/made.csv"},
                                                                                     {"a/made.csv", "a/made.csv"},
                                                                                     {"../made.csv", "../made.csv"},
                                                                                     {"made.csv", "made"}})
    EXPECT_EQ(places_beside(files_of({inside}), made, "out/here.csv", endings).error().code, Errc::corrupt)
        << made << " " << inside;
  // Two for one place.
  EXPECT_FALSE(places_beside(files_of({"made.csv", "made.csv"}), "made.csv", "out/here.csv", endings));
}

}  // namespace
}  // namespace tessera::client
