// A service lives for months: what a job has taken is given back when it has ended.
#include <malloc.h>

#include <algorithm>
#include <cstddef>

#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

using ManyJobs = ServiceTest;

std::ptrdiff_t descriptors() {
  const std::filesystem::directory_iterator open("/proc/self/fd");
  return std::distance(begin(open), end(open));
}

// What is allocated and not freed: unlike resident memory it does not hang on what the allocator keeps.
std::size_t live_bytes() {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

// Of a job that has ended there are kept: its record, some 2 KiB, and a dozen events of 1 KiB, of those the last 2,000.
// The smallest tile alone takes more than this.
constexpr std::size_t kept_of_a_job = 32 << 10;

TEST_F(ManyJobs, LeaveNoDescriptorsAndNoMoreMemoryThanTheirRecords) {
  make_cloud("a.xyz", 1000);
  options.limits.running = 2;
  open();
  std::ptrdiff_t descriptors_before = 0;
  std::size_t bytes_before = 0;
  constexpr int jobs = 200, few = 10;
  for (int i = 0; i < jobs; ++i) {
    const auto name = "block" + std::to_string(i);
    const auto made = submit(triangulate("a.xyz", name));
    if (i % 4 == 3) {  // some are dismissed, some fail, and some are forgotten
      ASSERT_TRUE(service->jobs().dismiss(made, alice));
    } else {
      ASSERT_EQ(ended(made).status(), "successful");
      ASSERT_EQ(ended(submit(verify(name))).status(), "successful");
      ASSERT_TRUE(service->results().remove(name, admin));
    }
    if (i + 1 == few) {
      descriptors_before = descriptors();
      bytes_before = live_bytes();
    }
  }
  const auto last = ended(submit(triangulate("a.xyz", "last")));  // the threads have let go of those before
  ASSERT_EQ(last.status(), "successful");
  ASSERT_EQ(ended(submit(verify("last"))).status(), "successful");
  EXPECT_LE(descriptors(), descriptors_before);
  EXPECT_LE(live_bytes(), bytes_before + 2 * (jobs - few) * kept_of_a_job);
}

}  // namespace
}  // namespace tessera::service::testing
