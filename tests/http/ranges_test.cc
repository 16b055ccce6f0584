#include "src/service/http/ranges.h"

#include <gtest/gtest.h>

namespace tessera::service::http {
namespace {

ByteRange part(const char* header, std::uint64_t size) {
  const RangeFound found = find_range(header, size);
  EXPECT_EQ(found.kind, RangeKind::part) << header;
  return found.range;
}

TEST(Range, IsThatOfTheStandard) {
  EXPECT_EQ(part("bytes=0-0", 10), (ByteRange{0, 1}));
  EXPECT_EQ(part("bytes=3-5", 10), (ByteRange{3, 3}));
  EXPECT_EQ(part("bytes=3-", 10), (ByteRange{3, 7}));
  EXPECT_EQ(part("bytes=-4", 10), (ByteRange{6, 4}));
  EXPECT_EQ(part("bytes=-40", 10), (ByteRange{0, 10}));
  EXPECT_EQ(part("bytes=9-99999999999999999999999", 10), (ByteRange{9, 1}));
}

TEST(Range, BeyondTheEndCannotBeSatisfied) {
  for (const char* header : {"bytes=10-", "bytes=10-11", "bytes=99999999999999999999999-", "bytes=-0"})
    EXPECT_EQ(find_range(header, 10).kind, RangeKind::unsatisfiable) << header;
  EXPECT_EQ(find_range("bytes=-5", 0).kind, RangeKind::unsatisfiable);
}

TEST(Range, ThatIsNotUnderstoodIsTheWholeFile) {
  for (const char* header : {"", "bytes", "bytes=", "bytes=-", "bytes=5-3", "bytes=a-b", "bytes=1-2,4-5", "lines=1-2",
                             "bytes=+1-2", "bytes= 1-2", "bytes=1--2"})
    EXPECT_EQ(find_range(header, 10).kind, RangeKind::whole) << header;
}

TEST(EntityTag, IsFoundInLists) {
  EXPECT_TRUE(names_tag("\"a\", W/\"b\"", "\"b\"", true));
  EXPECT_FALSE(names_tag("\"a\", W/\"b\"", "\"b\"", false));
  EXPECT_TRUE(names_tag("*", "\"b\"", false));
  EXPECT_FALSE(names_tag("\"a\"", "\"b\"", true));
  EXPECT_FALSE(names_tag("*", "", true));
}

}  // namespace
}  // namespace tessera::service::http
