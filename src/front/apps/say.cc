#include "src/front/apps/say.h"

#include <cstdarg>
#include <cstdio>

#include "src/base/printable.h"

namespace tessera::apps {
namespace {

std::string written(const char* format, std::va_list values) {
  std::va_list again;
  va_copy(again, values);
  const int length = std::vsnprintf(nullptr, 0, format, again);
  va_end(again);
  std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  std::vsnprintf(text.data(), text.size() + 1, format, values);
  return printable_lines(text);
}

}  // namespace

void say(const char* format, ...) {
  std::va_list values;
  va_start(values, format);
  std::fputs(written(format, values).c_str(), stdout);
  va_end(values);
}

void say_whole(const std::string& text, bool is_json) {
  std::fputs((is_json ? text : printable_lines(text)).c_str(), stdout);
}

void say_beside(const char* format, ...) {
  std::va_list values;
  va_start(values, format);
  std::fputs(written(format, values).c_str(), stderr);
  va_end(values);
}

}  // namespace tessera::apps
