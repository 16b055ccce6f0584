// A service on a disk that fails at any call while it opens its data folder, answers, and ends: an error is told, or
// the truth; nothing that was accepted is removed, and no format is written over.
#include <fstream>
#include <map>
#include <sstream>

#include "src/base/files/names.h"
#include "tests/disk/failing_disk.h"
#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

namespace fs = std::filesystem;

// All files below a folder with what is in them.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ostringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    all[fs::relative(entry.path(), folder).string()] = text.str();
  }
  return all;
}

class ServiceDisk : public ServiceTest {
 protected:
  // A result, a job that has made it, one that has failed and can go on with what it has done, one that is forgotten,
  // and an upload.
  void prepare() {
    options.uploads = true;
    make_cloud("a.xyz", 100);
    std::ofstream(inputs() / "bad.xyz") << "1 2 3\n4 5 6\n7 8 9\n1 2 nan\n";
    open();
    made_ = submit(triangulate("a.xyz", "block"));
    failed_ = submit(triangulate("bad.xyz", "bad"));
    const auto forgotten = submit(triangulate("a.xyz", "other"));
    for (const auto& id : {made_, failed_, forgotten}) ended(id);
    ASSERT_TRUE(service->jobs().dismiss(forgotten, admin));
    service.reset();
    const auto begun = unfinished_folder(results_folder(data()), failed_);
    fs::create_directories(begun);
    std::ofstream(begun / "plan.json") << "what it has done";
    fs::create_directories(uploads_folder(data()) / "d");
    std::ofstream(uploads_folder(data()) / "d" / "f.xyz") << "1 2 3\n";
    fs::rename(data(), kept());
  }
  fs::path kept() const { return folder.path() / "kept"; }

  // `run` finds a new copy of the data, once for each call that is made there, and that call fails, alone or with all
  // after it.
  template <class Run>
  void sweep(Run run) {
    for (const std::uint64_t count : {std::uint64_t{1}, std::uint64_t{1'000'000}}) {
      std::uint64_t first = 1;
      for (bool all = false; !all; ++first) {
        fs::remove_all(data());
        fs::copy(kept(), data(), fs::copy_options::recursive);
        const int number = tessera::testing::disk_errors[first % std::size(tessera::testing::disk_errors)];
        SCOPED_TRACE("call " + std::to_string(first) + (count > 1 ? " and those after it fail" : " fails") + " with " +
                     std::generic_category().message(number));
        tessera::testing::fail_below(data(), first, count, number);
        run();
        all = tessera::testing::recover_disk().failed == 0;
        check_kept();
        if (HasFatalFailure()) return;
      }
      EXPECT_GT(first, 20u);
    }
  }

  // All that was there is there as it was, but for what a service counts.
  void check_kept() {
    auto before = contents(kept()), after = contents(data());
    for (auto* all : {&before, &after}) {
      all->erase(fs::relative(event_numbers_file(data()), data()).string());
    }
    for (const auto& [file, content] : before) {
      ASSERT_TRUE(after.contains(file)) << file << " is gone";
      ASSERT_EQ(after[file], content) << file;
    }
  }

  std::string made_, failed_;
};

TEST_F(ServiceDisk, ATroubleWithItAtAnyCallIsToldAndNothingIsRemovedOrForgotten) {
  prepare();
  int refused = 0, opened = 0;
  sweep([&] {
    auto made = Service::open(options);
    if (!made) {
      ++refused;
      EXPECT_EQ(made.error().code, Errc::io) << made.error().where;
      EXPECT_NE(made.error().where.find(data().string()), std::string::npos) << made.error().where;
      return;
    }
    ++opened;
    service = std::move(made).value();
    EXPECT_EQ(status(made_).status(), "successful");
    EXPECT_EQ(status(failed_).status(), "failed");
    if (const auto listed = service->results().list(10, "")) {
      EXPECT_EQ(listed.value().number_matched(), 2);
    } else {
      EXPECT_EQ(listed.error().status(), 500);
    }
    if (const auto told = service->results().info("block"); !told) {
      EXPECT_EQ(told.error().status(), 500) << told.error().detail();
    }
    if (const auto told = service->results().file("block", "manifest.json")) {
      ::close(told.value().descriptor);
    } else {
      EXPECT_EQ(told.error().status(), 500) << told.error().detail();
    }
    if (const auto size = service->inputs().uploaded("d", "f.xyz")) {
      EXPECT_EQ(size.value(), 6u);
    } else {
      EXPECT_EQ(size.error().status(), 500) << size.error().detail();
    }
    // Taken already, whatever the disk says.
    const auto again = service->processes().submit(triangulate("a.xyz", "block"), alice, "");
    ASSERT_FALSE(again);
    EXPECT_TRUE(again.error().status() == 409 || again.error().status() == 500) << again.error().detail();
    service.reset();
  });
  EXPECT_GT(refused, 20);
  EXPECT_GT(opened, 20);
}

TEST_F(ServiceDisk, TheNumberOfANewerFormatIsNeverWrittenOver) {
  prepare();
  std::ofstream(data_format_file(kept())) << "99\n";
  sweep([&] {
    const auto made = Service::open(options);
    ASSERT_FALSE(made);
  });
}

}  // namespace
}  // namespace tessera::service::testing
