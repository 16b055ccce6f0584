#include "src/base/option.h"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "src/base/check.h"

namespace tessera {
namespace {

// A mark is: mark_begin key [ '=' value ] mark_end
constexpr char mark_begin = '\0', mark_end = '\x01';

bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
bool is_key(std::string_view text) {
  const auto fits = [](char c) { return is_lower(c) || (c >= '0' && c <= '9') || c == '-'; };
  return !text.empty() && is_lower(text.front()) && std::all_of(text.begin(), text.end(), fits);
}
bool is_value(std::string_view text) {
  const auto fits = [](char c) { return is_lower(c) || (c >= '0' && c <= '9') || c == '-' || c == '.'; };
  return !text.empty() && std::all_of(text.begin(), text.end(), fits);
}

struct Mark {
  std::string_view key, value;
  std::size_t length;
};

// Returns the mark that begins `text`, if there is one.
std::optional<Mark> mark_at(std::string_view text) {
  const auto end = text.find(mark_end);
  if (text.empty() || text.front() != mark_begin || end == std::string_view::npos) return std::nullopt;
  const auto inside = text.substr(1, end - 1);
  const auto sign = inside.find('=');
  const auto key = inside.substr(0, sign);
  const auto value = sign == std::string_view::npos ? std::string_view() : inside.substr(sign + 1);
  if (!is_key(key) || (sign != std::string_view::npos && !is_value(value))) return std::nullopt;
  return Mark{key, value, end + 1};
}

}  // namespace

std::string option(std::string_view key) {
  check(is_key(key), "an option has a key");
  return mark_begin + std::string(key) + mark_end;
}

std::string option(std::string_view key, std::string_view value) {
  check(is_key(key) && is_value(value), "an option has a key and a value");
  return mark_begin + std::string(key) + "=" + std::string(value) + mark_end;
}

std::string render(std::string_view sentence, const OptionName& name) {
  std::string rendered;
  while (true) {
    const auto at = sentence.find(mark_begin);
    rendered += sentence.substr(0, at);
    if (at == std::string_view::npos) return rendered;
    sentence.remove_prefix(at);
    if (const auto mark = mark_at(sentence)) {
      rendered += name(mark->key, mark->value);
      sentence.remove_prefix(mark->length);
    } else {
      rendered += ' ';
      sentence.remove_prefix(1);
    }
  }
}

std::string in_plain_words(std::string_view sentence) {
  return render(sentence, [](std::string_view key, std::string_view value) {
    return std::string(key) + (value.empty() ? "" : "=") + std::string(value);
  });
}

std::vector<std::string> option_keys(std::string_view sentence) {
  std::vector<std::string> keys;
  render(sentence, [&](std::string_view key, std::string_view) {
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.emplace_back(key);
    return std::string();
  });
  return keys;
}

}  // namespace tessera
