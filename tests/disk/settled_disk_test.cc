// What settled tiles are built from, on a disk that fails at any call: what is said to be synced is, and what was
// appended is never said to be missing.
#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/exchange/settled_files.h"
#include "tests/disk/failing_disk.h"

namespace tessera::testing {
namespace {

constexpr TileId one{1}, two{2};
constexpr NodeId here{3};

const std::vector<std::byte> content(500, std::byte{7});

// `run` gets a new folder, once for each call that it makes there, and that call fails, alone or with all after it.
template <class Prepare, class Run>
void sweep(Prepare prepare, Run run) {
  for (const std::uint64_t count : {std::uint64_t{1}, std::uint64_t{1'000'000}}) {
    std::uint64_t first = 1;
    for (bool all = false; !all; ++first) {
      const auto folder = TemporaryFolder::make().value();
      prepare(folder.path());
      const int number = disk_errors[first % std::size(disk_errors)];
      SCOPED_TRACE("call " + std::to_string(first) + " fails with " + std::generic_category().message(number));
      fail_below(folder.path(), first, count, number);
      run(folder.path());
      all = recover_disk().failed == 0;
      if (::testing::Test::HasFatalFailure()) return;
    }
    EXPECT_GT(first, 3u);
  }
}

TEST(SettledDisk, WhatIsSaidToBeSyncedIs) {
  sweep([](const auto&) {},
        [](const auto& folder) {
          SettledFiles files(folder, 0, here);
          if (!files.append(one, content)) return;
          if (files.sync()) {
            EXPECT_TRUE(was_synced(settled_file(folder, here)));
          }
        });
}

TEST(SettledDisk, WhatAnEarlierProcessHasAppendedIsSyncedToo) {
  sweep([](const auto& folder) { ASSERT_TRUE(SettledFiles(folder, 0, here).append(one, content)); },
        [](const auto& folder) {
          if (SettledFiles(folder, 0, here).sync()) {
            EXPECT_TRUE(was_synced(settled_file(folder, here)));
          }
        });
}

TEST(SettledDisk, WhatWasAppendedIsThereOrAnErrorIsTold) {
  const auto prepare = [](const auto& folder) {
    ASSERT_TRUE(SettledFiles(folder, 0, here).append(one, content));
    ASSERT_TRUE(SettledFiles(folder, 0, NodeId{4}).append(two, content));
  };
  sweep(prepare, [](const auto& folder) {
    SettledFiles files(folder, 0, here);
    for (const TileId tile : {one, two}) {
      if (const auto has = files.has(tile)) {
        EXPECT_TRUE(has.value());
      }
      if (const auto read = files.read(tile)) {
        EXPECT_TRUE(read.value().has_value());
      }
    }
  });
}

}  // namespace
}  // namespace tessera::testing
