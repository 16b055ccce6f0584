#include "src/service/http/head.h"

#include <array>
#include <ctime>

namespace tessera::service::http {
namespace {

// The date of this second, made once a second.
const std::string& date() {
  thread_local std::time_t made = 0;
  thread_local std::string text;
  const std::time_t now = std::time(nullptr);
  if (now == made) return text;
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 64> buffer{};
  text.assign(buffer.data(), std::strftime(buffer.data(), buffer.size(), "%a, %d %b %Y %H:%M:%S GMT", &parts));
  made = now;
  return text;
}

// A line break in a value would begin another header.
void append_value(std::string& head, const std::string& value) {
  for (const char c : value) head += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
}

}  // namespace

std::string head_of(const Answer& answer, bool keep) {
  std::string head = "HTTP/1.1 " + std::to_string(answer.status) + " ";
  head += reason_phrase(answer.status);
  head += "\r\nDate: " + date() + "\r\n";
  for (const auto& [name, value] : answer.headers) {
    head += name + ": ";
    append_value(head, value);
    head += "\r\n";
  }
  if (!answer.events && !has_no_body(answer.status))
    head += "Content-Length: " + std::to_string(answer.file ? answer.file->bytes : answer.body.size()) + "\r\n";
  head += keep ? "Connection: keep-alive\r\n\r\n" : "Connection: close\r\n\r\n";
  return head;
}

}  // namespace tessera::service::http
