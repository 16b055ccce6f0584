// Parses server-sent events (WHATWG HTML, 9.2) as their bytes come.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "src/base/result.h"

namespace tessera::client {

struct ServerEvent {
  std::string id;    // the last id that was sent, with this event or an earlier one
  std::string type;  // "message" when none was sent
  std::string data;
};

class EventStream {
 public:
  using OnEvent = std::function<Status(const ServerEvent&)>;
  explicit EventStream(OnEvent on_event) : on_event_(std::move(on_event)) {}
  // Parses more bytes, which may be cut anywhere. Returns the first error of on_event; error io for a line or an event
  // of more than 1 MiB.
  Status feed(std::string_view bytes);

 private:
  Status take_line();

  OnEvent on_event_;
  std::string line_;
  bool after_return_ = false;  // a following line feed belongs to the line end before
  ServerEvent event_;
  bool has_data_ = false;
};

}  // namespace tessera::client
