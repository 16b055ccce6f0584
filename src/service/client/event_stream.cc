#include "src/service/client/event_stream.h"

#include <cstddef>
#include <utility>

namespace tessera::client {
namespace {

constexpr std::size_t event_bytes_max = 1 << 20;

}  // namespace

Status EventStream::feed(std::string_view bytes) {
  for (const char c : bytes) {
    if (std::exchange(after_return_, c == '\r') && c == '\n') continue;
    if (c == '\r' || c == '\n') {
      BOOST_OUTCOME_TRYV(take_line());
      continue;
    }
    line_ += c;
    if (line_.size() + event_.data.size() > event_bytes_max)
      return error(Errc::io, "an event of the server is longer than " + std::to_string(event_bytes_max >> 20) + " MiB");
  }
  return success();
}

Status EventStream::take_line() {
  const auto line = std::exchange(line_, {});
  if (line.empty()) {
    auto event = std::exchange(event_, {});
    event_.id = event.id;
    if (!std::exchange(has_data_, false)) return success();
    if (event.type.empty()) event.type = "message";
    event.data.pop_back();  // the line feed of its last line
    return on_event_(event);
  }
  const auto colon = line.find(':');
  const auto name = line.substr(0, colon);
  auto value = colon == std::string::npos ? std::string() : line.substr(colon + 1);
  if (value.starts_with(' ')) value.erase(0, 1);
  if (name == "data") {
    event_.data += value + "\n";
    has_data_ = true;
  } else if (name == "event") {
    event_.type = value;
  } else if (name == "id" && value.find('\0') == std::string::npos) {
    event_.id = value;
  }
  return success();  // comments and other fields are ignored
}

}  // namespace tessera::client
