#include "src/service/client/event_stream.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

namespace tessera::client {
namespace {

struct Heard {
  std::vector<std::string> events;  // "id type data"
  EventStream stream{[this](const ServerEvent& event) -> Status {
    events.push_back(event.id + " " + event.type + " " + event.data);
    return success();
  }};
};

TEST(EventStream, TellsTheSameHoweverTheBytesAreCut) {
  const std::string text =
      ": hello\n\nid: 1\nevent: status\ndata: {\"a\": 1}\n\nevent: log\rdata:two\rdata:  lines\r\r"
      "data\r\n\r\nid: 4\n\nretry: 10\nevent: lost\n\ndata: last\r\n\r\n";
  const std::vector<std::string> expected{"1 status {\"a\": 1}", "1 log two\n lines", "1 message ", "4 message last"};
  for (std::size_t step = 1; step <= text.size(); ++step) {
    Heard heard;
    for (std::size_t at = 0; at < text.size(); at += step)
      ASSERT_TRUE(heard.stream.feed(std::string_view(text).substr(at, step)));
    EXPECT_EQ(heard.events, expected) << step;
  }
}

TEST(EventStream, TellsNothingOfAnEventWithoutEnd) {
  Heard heard;
  ASSERT_TRUE(heard.stream.feed("data: cut off\n"));
  EXPECT_TRUE(heard.events.empty());
}

TEST(EventStream, RefusesEventsWithoutEnd) {
  Heard one_line, many_lines;
  EXPECT_FALSE(one_line.stream.feed(std::string(2 << 20, 'x')));
  std::string lines;
  for (int i = 0; i < 300'000; ++i) lines += "data: x\n";
  EXPECT_TRUE(many_lines.stream.feed("data: x\n\n"));
  EXPECT_TRUE(many_lines.stream.feed(lines.substr(0, 80'000)));
  EXPECT_FALSE(many_lines.stream.feed(lines + lines + lines));
}

TEST(EventStream, EndsWithWhatItsListenerReturns) {
  EventStream stream([](const ServerEvent&) -> Status { return error(Errc::corrupt, "no"); });
  const auto fed = stream.feed("data: x\n\n");
  ASSERT_FALSE(fed);
  EXPECT_EQ(fed.error().code, Errc::corrupt);
}

}  // namespace
}  // namespace tessera::client
